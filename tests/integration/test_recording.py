"""Recordings of the shipped experiment on real engines."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import Golden
from rosbags.highlevel import AnyReader

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError
from nrp_core.recording.figures import plot
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.images import pixels_of
from nrp_core.recording.layout import MCAP_NAME, Images, Role
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

SETTINGS = ("world.options.image_scale=0.2", "events.left_red.at=0.1 s", "duration=0.4 s")
CAMERA = "/husky/camera"


@pytest.fixture(params=["mujoco", "pybullet"])
def run(request: pytest.FixtureRequest) -> Iterator[Run]:
    with Run(load_experiment("braitenberg_husky", [*SETTINGS, f"world.backend={request.param}"])) as run:
        yield run


def test_a_recording_of_real_engines_is_read_by_anybody(run: Run, tmp_path: Path) -> None:
    recording_folder = RecordingFolder(run, tmp_path / "out", images=Images.JPEG)
    run.run()
    recording_folder.close("finished")
    assert recording_folder.warnings == []
    with AnyReader([tmp_path / "out" / MCAP_NAME]) as reader:
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
    assert types[f"{CAMERA}/compressed"] == "sensor_msgs/msg/CompressedImage"
    assert types["/brain/circuit/spikes"] == "nrp_msgs/msg/Spikes"
    assert counts["/gazebo/model_states"] == 21
    assert counts["/husky/cmd_vel"] == 20
    assert counts[f"{CAMERA}/compressed"] == 13
    spikes = Recording(tmp_path / "out").messages({"/brain/circuit/spikes"})
    assert sum(len(one.message.ids) for one in spikes) == run.result().spikes["circuit"]


def test_exact_images_are_what_the_camera_gave(run: Run, tmp_path: Path) -> None:
    camera = run.world.subscribe(CAMERA, depth=100)
    recording_folder = RecordingFolder(run, tmp_path / "out")
    run.run()
    recording_folder.close("finished")
    seen = {stamped.t_ns: stamped.message.data for stamped in camera.messages}
    recorded = list(Recording(tmp_path / "out").messages({CAMERA}))
    assert [one.t_ns for one in recorded] == list(seen)
    assert all((pixels_of(one.message) == seen[one.t_ns]).all() for one in recorded)


def test_the_figure_of_real_engines_is_drawn_from_the_recording(run: Run, tmp_path: Path) -> None:
    recording_folder = RecordingFolder(run, tmp_path / "out")
    run.run()
    recording_folder.close("finished")
    recording = Recording(tmp_path / "out")
    assert len(recording.with_role(Role.SINK)) == 2
    plot(recording, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_a_recording_leaves_populations_out_and_adds_sensors(tmp_path: Path, golden: Golden) -> None:
    scope = "recording={exclude: [circuit], topics: [/husky/joint_states]}"
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", [*SETTINGS, scope])) as run:
        recording_folder = RecordingFolder(run, tmp_path / "out", images=Images.OFF, files=files)
        run.run()
        recording_folder.close("finished")
    recording = Recording(tmp_path / "out")
    assert "/brain/circuit/spikes" not in recording.topics
    assert len(list(recording.messages({"/husky/joint_states"}))) == 21
    with Replay(recording, ReplayRequest()) as replay:
        assert replay.verify().identical
    with golden.raises(ExperimentError):
        Replay(recording, ReplayRequest(recorded=frozenset({"brain"})))


@pytest.mark.parametrize(
    ("scope", "code"), [("exclude: [circit]", "NRP211"), ("topics: [/husky/joint_stat]", "NRP212")]
)
def test_a_scope_of_what_does_not_exist_is_an_error(scope: str, code: str) -> None:
    with pytest.raises(InvalidExperimentError) as refused:
        Run(load_experiment("braitenberg_husky", [f"recording={{{scope}}}"]))
    assert [finding.code.name for finding in refused.value.findings if finding.level == "error"] == [code]
