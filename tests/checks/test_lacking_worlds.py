"""Parts of an experiment that its world cannot simulate are named before a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nrp_experiments
import pytest
from golden import Golden
from nrp_world_mujoco import MujocoBackend

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level
from nrp_core.world.capabilities import WorldCapabilities


def test_a_sensor_that_the_world_does_not_simulate_is_named(
    husky: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    blind = WorldCapabilities(step_ns=1_000_000)
    monkeypatch.setattr(MujocoBackend, "capabilities", lambda self, options: blind)
    (finding,) = [one for one in validate_file(husky) if one.level is Level.WARNING]
    assert finding.code.name == "NRP216"
    golden(finding.message)
    assert finding.path == husky / "listing2.py"


def test_nothing_is_known_to_be_lacking_in_a_world_with_its_own_scene(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    elsewhere = WorldCapabilities(step_ns=1_000_000, own_scene=True)
    monkeypatch.setattr(MujocoBackend, "capabilities", lambda self, options: elsewhere)
    found = validate_file(Path(nrp_experiments.__path__[0]) / "following_head")
    assert "NRP216" not in {one.code.name for one in found}


def test_wheels_that_the_world_does_not_turn_are_named(husky: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    still = WorldCapabilities(step_ns=1_000_000, renderers=("raster",), dynamics=False)
    monkeypatch.setattr(MujocoBackend, "capabilities", lambda self, options: still)
    (husky / "listing1.py").write_text(
        "@nrp.MapRobotSubscriber('wheels', Topic('/husky/wheel_speeds', gazebo_msgs.msg.WheelSpeeds))\n"
        "@nrp.Robot2Neuron()\ndef listen(t, wheels):\n    print(wheels.value)\n"
    )
    warned = [one.message for one in validate_file(husky) if one.level is Level.WARNING]
    assert "'wheels' gets no messages: the world backend 'mujoco' lacks the capability 'dynamics'" in warned


def refused(folder: Path, monkeypatch: pytest.MonkeyPatch, **has: Any) -> list[str]:
    """Return what is said of an experiment in a world that has little."""
    little = WorldCapabilities(step_ns=1_000_000, **{"renderers": ("raster",), "links": True, **has})
    monkeypatch.setattr(MujocoBackend, "capabilities", lambda self, options: little)
    found = [one for one in validate_file(folder) if one.code.name == "NRP216"]
    assert {one.level for one in found} <= {Level.ERROR}
    assert all(one.line is not None for one in found)
    return [one.message for one in found]


def test_joints_that_the_world_does_not_drive_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = Path(nrp_experiments.__path__[0])
    walker, head = shipped / "walking_hexapod", shipped / "following_head"
    *sent, held = refused(walker, monkeypatch)
    assert (
        held
        == "'hexapod' holds front_left_delta: the world backend 'mujoco' lacks the capability 'joint_control'"
    )
    assert all(told.startswith("nothing reacts to messages on '/hexapod/") for told in sent)
    assert len(sent) == 12
    (told, *_) = refused(walker, monkeypatch, joint_control=True, dynamics=False)
    assert told == "'hexapod' could not move: the world backend 'mujoco' lacks the capability 'dynamics'"
    told = "; ".join(refused(head, monkeypatch))
    assert "nothing reacts to messages on '/pan_tilt/" in told
    assert "lacks the capability 'joint_control'" in told


def test_joints_that_the_world_does_not_have_are_named(husky: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = husky / "husky.sdf"
    ends = "<parent>base_link</parent><child>bead</child>"
    string = f'<link name="bead"/><joint name="string" type="ball">{ends}</joint></model>'
    robot.write_text(robot.read_text().replace("</model>", string))
    (told,) = refused(husky, monkeypatch)
    assert (
        told == "'husky/string' could not move: the world backend 'mujoco' lacks the capability 'ball_joints'"
    )
    assert refused(husky, monkeypatch, ball_joints=True) == []


def test_changes_that_the_world_refuses_are_named(husky: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = husky / "experiment.yaml"
    request = "{model_state: {model_name: husky}}"
    file.write_text(
        file.read_text().replace(
            "events:",
            f"events:\n  moves: {{at: 1 s, publish: {{topic: /gazebo/set_model_state, value: {request}}}}}",
        )
    )
    told = refused(husky, monkeypatch)
    assert told == [
        "nothing reacts to '/gazebo/set_model_state': "
        "the world backend 'mujoco' lacks the capability 'changes'"
    ]
    assert refused(husky, monkeypatch, changes=True) == []
