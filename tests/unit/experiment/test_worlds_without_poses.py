"""An engine that does not report where its models are: it needs no such method, and runs are whole."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from golden import Golden

from nrp_core import InvalidExperimentError, Recording, Run, load_experiment, run, validate
from nrp_core.errors import CapabilityError
from nrp_core.findings import Code, has_errors
from nrp_core.world.model_states import MODEL_STATES

BLIND = """
from experiment_fakes import DiscBackend, DiscEngine
from nrp_core.world import Engine, WorldCapabilities


class BlindEngine(Engine):
    def _do_reset(self, seed): self.steps, self.velocities = 0, []
    def __init__(self, scene, capabilities, **settings):
        super().__init__(scene, capabilities, **settings)
        self._do_reset(0)
    def _do_advance(self, steps): self.steps += steps
    def _do_set_drive(self, model, drive, velocity): self.velocities.append(velocity.forward)
    def _do_close(self): ...


class BlindBackend(DiscBackend):
    def capabilities(self, options):
        return WorldCapabilities(step_ns=options.timestep, poses=False, own_scene=True)

    def engine(self, scene, *, seed, options):
        return BlindEngine(scene, self.capabilities(options), seed=seed, identity="blind")
"""


@pytest.fixture
def blind(fakes: None, install: Callable[..., None], drive_to_the_wall: Path) -> Path:
    """An experiment in a world that takes commands and reports nothing; it has no distances."""
    install("blind", "[nrp_core.world]\nblind = blind:BlindBackend\n", BLIND)
    file = drive_to_the_wall / "experiment.yaml"
    text: dict[str, Any] = yaml.safe_load(file.read_text())
    text["world"]["backend"] = "blind"
    del text["criteria"], text["events"]["arrived"]
    file.write_text(yaml.safe_dump(text))
    return drive_to_the_wall


def test_an_experiment_runs_in_a_world_without_poses(blind: Path, golden: Golden) -> None:
    assert not has_errors(validate(load_experiment(blind)))
    with Run(load_experiment(blind)) as simulation:
        simulation.run_until(1.0)
        engine: Any = simulation.world.engine
        assert engine.steps == 500  # of 2 ms
        assert engine.velocities
        assert MODEL_STATES not in simulation.world.topics
        assert simulation.result().final_pose == {}
        with golden.raises(CapabilityError):
            simulation.world.model_motion("husky")


def test_a_run_in_a_world_without_poses_is_recorded(blind: Path, tmp_path: Path) -> None:
    result = run(blind, until_s=0.2, record=tmp_path / "out")
    assert result.sim_time_s == 0.2
    recording = Recording(tmp_path / "out")
    assert "/speed" in recording.topics
    assert [m for m in recording.messages({MODEL_STATES}) if m.message.name] == []


@pytest.mark.one_of(2)
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("events", {"arrived": {"when": {"near": {"model": "husky", "point": [1, 0], "within": "1 m"}}}}),
        ("criteria", {"stays": {"stays_within": {"model": "husky", "distance": "3 m", "of": [0, 0]}}}),
        ("criteria", {"comes": {"near": {"model": "husky", "point": [1, 0], "within": "1 m"}}}),
    ],
)
def test_criteria_that_need_a_distance_are_found_before_and_refused_at_the_start(
    blind: Path, key: str, value: dict[str, Any], golden: Golden
) -> None:
    file = blind / "experiment.yaml"
    text = yaml.safe_load(file.read_text())
    text[key] = value | (text.get(key, {}) if key == "events" else {})
    file.write_text(yaml.safe_dump(text))
    (finding,) = (each for each in validate(load_experiment(blind)) if each.code is Code.NRP216)
    assert f"'{next(iter(value))}' needs a distance" in finding.message
    with golden.raises(InvalidExperimentError):
        Run(load_experiment(blind))
