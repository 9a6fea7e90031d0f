"""MuJoCo as a world that reads one file, with one fault each; the named test of such worlds finds it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest
from golden import Golden
from nrp_conformance import OwnSceneTests, proof
from nrp_conformance.proof import Proof
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests
from nrp_world_mujoco.backend import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine as E

from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldOptions
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine

ARM = """<sdf version="1.9"><model name="arm">
<link name="base"><inertial><mass>1</mass></inertial></link>
<link name="fore"><pose>0.3 0 0 0 0 0</pose>
  <inertial><mass>0.5</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>
<joint name="held" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="elbow" type="revolute"><parent>base</parent><child>fore</child><pose>-0.3 0 0 0 0 0</pose>
  <axis><xyz>0 1 0</xyz><dynamics><damping>0.2</damping></dynamics></axis></joint>
<plugin name="c" filename="libgeneric_controller_plugin.so">
  <controller joint_name="elbow"><type>effort</type></controller></plugin>
</model></sdf>"""


class OwnScene(MujocoBackend):
    """MuJoCo that takes only the model ``arm``, with other methods."""

    methods: ClassVar[dict[str, Any]] = {}

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return replace(super().capabilities(options), own_scene=True)

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        if any(model.name != "arm" for model in scene.models):
            raise CapabilityError("only arms can be simulated")
        kind: Any = type("Changed", (E,), dict(self.methods))
        engine: Engine = kind(scene, seed=seed, capabilities=self.capabilities(options), options=options)
        return engine


def keep_speed(self: E, seed: int) -> None:
    speed = self._data.qvel.copy()
    E._do_reset(self, seed)
    self._data.qvel[:] = speed


def forget_speed(self: E, saved: Any) -> None:
    E._do_restore(self, saved)
    self._data.qvel[:] = 0


def long_first_step(self: E, steps: int) -> None:
    E._do_advance(self, steps + (steps > 5))


def move_when_read(self: E, model: str) -> Any:
    self._data.qpos[:] += 1e-9
    return E._do_joint_states(self, model)


WRONG = {
    "reset keeps speeds": ("a_reset_world_equals_a_fresh_one", {"_do_reset": keep_speed}),
    "snapshots lack speeds": ("a_snapshot_decides_the_future", {"_do_restore": forget_speed}),
    "long runs are longer": ("splitting_a_run_is_invisible", {"_do_advance": long_first_step}),
    "reading moves": ("reading_changes_nothing", {"_do_joint_states": move_when_read}),
    "commands are ignored": (
        "every_command_changes_what_the_world_publishes",
        {"_do_set_joint_effort": lambda *_: None, "_do_set_servo_target": lambda *_: None},
    ),
}


@pytest.fixture
def arm(tmp_path: Path) -> str:
    file = tmp_path / "arm.sdf"
    file.write_text(ARM)
    return str(file)


def outcomes(arm: str, methods: dict[str, Any], only: list[str]) -> dict[str, Outcome]:
    """Return the outcomes of tests by name."""
    backend = type("Backend", (OwnScene,), {"methods": methods})
    given = {"make_backend": classmethod(lambda cls: backend()), "scene": arm}
    results = run_tests(type("Mine", (OwnSceneTests,), given), only=only, traceback="native")
    return {result.test: result.outcome for result in results}


def test_a_right_world_passes_all_tests_that_apply(arm: str) -> None:
    found = outcomes(arm, {}, [])
    assert set(found.values()) == {Outcome.PASSED, Outcome.SKIPPED}
    assert [name for name, outcome in found.items() if outcome is Outcome.SKIPPED] == [
        "test_samples_come_at_their_rate_each_with_its_own_time",
        "test_a_number_out_of_range_is_refused_or_clipped",
        "test_an_undeclared_snapshot_is_refused",
    ]


@pytest.mark.parametrize("fault", WRONG)
def test_a_wrong_world_is_found(fault: str, arm: str) -> None:
    found_by, methods = WRONG[fault]
    assert Outcome.FAILED in outcomes(arm, methods, [f"test_{found_by}"]).values()


def test_a_scene_is_required_where_the_world_has_its_own_and_only_there(
    arm: str, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=r"arm\.sdf"):
        Proof("world", "mujoco", {}, "core", arm).report([])
    registry = type("Registry", (), {"load": lambda *_: OwnScene(), "provider": lambda *_: {}})
    monkeypatch.setattr(proof, "worlds", registry)
    with golden.raises(CapabilityError, match="commanded"):
        Proof("world", "mine", {}, "core").report([])
    assert Proof("world", "mine", {}, "core", arm).report([]).scene == "arm.sdf"
