"""Robots in the scene's own file, and scenes without a file."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

import nrp_core
from nrp_core.errors import ExperimentError
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

BRAIN = "import pyNN.nest as sim\nsim.setup()\ncells = sim.Population(1, sim.IF_curr_exp())\n"
ARM = """<mujoco model="arm"><worldbody><geom type="plane" size="5 5 .1"/>
<body name="base" pos="0 0 1"><geom size=".05" mass="1"/><body name="fore" pos=".1 0 0">
<joint name="elbow" axis="0 1 0"/><geom size=".02" pos=".2 0 0" mass=".5"/></body></body>
</worldbody></mujoco>"""


@pytest.fixture
def experiment(tmp_path: Path):
    """Write an experiment with the given lines of its world, in a folder with an arm in MJCF."""
    (tmp_path / "brain.py").write_text(BRAIN)
    (tmp_path / "arm.xml").write_text(ARM)

    def write(world: str) -> Path:
        file = tmp_path / "experiment.yaml"
        brain = "brain: {backend: event, model: brain.py}"
        start = f"name: arm\nduration: 0.1 s\ntimestep: 20 ms\n{brain}\n"
        file.write_text(f"{start}world:\n  backend: mujoco\n{world}")
        return file

    return write


def test_a_robot_of_the_scene_gets_commands_and_a_start(experiment):
    robots = "  robots: {base: {joints: {elbow: 0.4}, control: {elbow: {mode: position, p: 50, d: 5}}}}\n"
    with nrp_core.open_run(experiment("  scene: arm.xml\n" + robots)) as run:
        assert run.world.joint_states("base").positions[0] == pytest.approx(0.4)
        assert any("elbow" in topic and "cmd" in topic for topic in run.world.topics)
        assert sum(model.name == "base" for model in run.world.scene.models) == 1


def test_a_robot_that_the_scene_lacks_needs_a_file(experiment, golden: Golden):
    with golden.raises(ExperimentError, match="'bas'"):
        nrp_core.open_run(experiment("  scene: arm.xml\n  robots: {bas: {fixed: true}}\n"))


def test_a_robot_stands_in_an_empty_scene_and_its_recording_has_its_own_files_only(
    experiment, tmp_path: Path
):
    world = "  scene: empty\n  robots: {arm: {model: arm.xml, pose: [0, 0, 0.5, 0, 0, 0]}}\n"
    with nrp_core.open_run(experiment(world)) as run:
        assert {model.name for model in run.world.scene.models} == {"ground_plane", "arm"}
        folder = RecordingFolder(run, tmp_path / "recorded")
        run.run()
        folder.close("finished")
    files = tmp_path / "recorded" / "experiment"
    assert {path.name for path in files.iterdir()} == {"experiment.yaml", "arm.xml", "brain.py"}
    with Replay(Recording(tmp_path / "recorded"), ReplayRequest()) as replay:
        assert replay.verify().identical
