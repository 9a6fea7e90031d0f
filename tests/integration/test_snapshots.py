"""Going on from within a recording whose snapshots fit no longer."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_world_mujoco.engine import MujocoEngine

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import SnapshotError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import RUN_NAME, SNAPSHOTS
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayResult, ReplayVerdict
from nrp_core.recording.sealing import seal

MS = 10**6
FROM_NS = 500 * MS
SETTINGS = ("world.options.image_scale=0.05", "duration=0.6 s", "criteria=null")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with snapshots every 0.2 s."""
    folder = tmp_path_factory.mktemp("made") / "recording"
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", SETTINGS)) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=200 * MS)
        run.run()
        recording_folder.close("finished")
    return folder


@pytest.fixture
def recording(made: Path, tmp_path: Path) -> Path:
    return shutil.copytree(made, tmp_path / "recording")


@pytest.fixture
def continued(made: Path, tmp_path: Path) -> Path:
    """A recording that begins within another, with a snapshot."""
    replayed(made, ReplayRequest(from_ns=FROM_NS, record=tmp_path / "continued"))
    return tmp_path / "continued"


def replayed(folder: Path, request: ReplayRequest) -> ReplayResult:
    with FilesRead() as files, Replay(Recording(folder), request, files=files) as again:
        return again.go()


def changed(folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """Change what ``run.json`` says, as if it had always said so."""
    told = json.loads((folder / RUN_NAME).read_text())
    change(told)
    (folder / RUN_NAME).write_bytes(seal(told))
    return folder


def of_other_code(told: dict[str, Any]) -> None:
    told["dependencies"]["packages"]["nrp_brain_event"] = "0" * 16


@pytest.fixture
def made_of_two_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A world whose state is made of other things than it was."""

    def restore(world: MujocoEngine, saved: Any) -> None:
        _one, _other = saved, *saved

    monkeypatch.setattr(MujocoEngine, "_do_restore", restore)


def test_a_recording_names_the_code_that_made_it(recording: Path) -> None:
    code = Recording(recording).run["dependencies"]["packages"]
    assert set(code) >= {"nrp_brain_event", "nrp_core", "nrp_world_mujoco"}
    assert all(len(digest) == 16 for digest in code.values())


def test_snapshots_that_fit_are_used_silently(recording: Path) -> None:
    outcome = replayed(recording, ReplayRequest(from_ns=FROM_NS))
    assert (outcome.verdict, outcome.from_ns, outcome.warnings) == (ReplayVerdict.SAME, 400 * MS, [])


@pytest.mark.parametrize(
    ("change", "whose"),
    [
        (of_other_code, "other code of nrp_brain_event"),
        (lambda told: told.pop("dependencies"), "unknown code"),
    ],
)
def test_snapshots_of_other_code_are_not_touched(
    recording: Path, change: Callable[..., object], whose: str
) -> None:
    outcome = replayed(changed(recording, change), ReplayRequest(from_ns=FROM_NS))
    assert (outcome.identical, outcome.from_ns, outcome.until_ns) == (True, 0, 600 * MS)
    assert outcome.warnings.messages == [f"the snapshots were made by {whose}; the run starts at 0 instead"]


@pytest.mark.usefixtures("made_of_two_numbers")
def test_a_snapshot_that_an_engine_cannot_use_does_not_stop_the_run(recording: Path) -> None:
    outcome = replayed(recording, ReplayRequest(from_ns=FROM_NS))
    assert (outcome.identical, outcome.from_ns, outcome.until_ns) == (True, 0, 600 * MS)
    (warning,) = outcome.warnings.messages
    assert warning.startswith("MujocoEngine failed to restore at 0.4 s: ")
    assert warning.endswith("; the run starts at 0 instead")


def test_a_snapshot_of_another_scene_is_none_of_this_one(recording: Path) -> None:
    (room,) = recording.rglob("room.sdf")
    room.write_text(room.read_text().replace("</world>", '<light name="more" type="point"/></world>'))
    outcome = replayed(recording, ReplayRequest(from_ns=FROM_NS))
    assert outcome.from_ns == 0
    assert outcome.warnings.messages[0].startswith("experiment/room.sdf (world.scene) was changed or damaged")
    assert "the snapshot was taken with scene " in outcome.warnings.messages[1]


def test_a_snapshot_at_the_start_of_a_recording_is_used_with_a_message(continued: Path) -> None:
    assert replayed(continued, ReplayRequest()).warnings == []
    outcome = replayed(changed(continued, of_other_code), ReplayRequest())
    assert (outcome.identical, outcome.from_ns) == (True, FROM_NS)
    assert outcome.warnings.messages == [
        "the snapshots were made by other code of nrp_brain_event; they may not fit"
    ]


@pytest.mark.usefixtures("made_of_two_numbers")
def test_where_it_does_not_fit_the_error_says_why_and_what_can_be_done(continued: Path) -> None:
    with pytest.raises(SnapshotError) as refused:
        replayed(changed(continued, of_other_code), ReplayRequest())
    message = str(refused.value)
    assert message.startswith("MujocoEngine failed to restore at 0.5 s: ")
    assert "it was made by other code of nrp_brain_event" in message
    assert message.endswith("continue again from 'recording' at 0.5 s, from which this run started")


@pytest.mark.parametrize(
    "saved", [b"", b"no pickle", b"\x80\x05N.", b"cnrp_core.no_such\nThing\n.", b"\x80\x05]."]
)
def test_bytes_that_are_not_a_snapshot_are_refused_in_one_sentence(
    recording: Path, saved: bytes, golden: Golden
) -> None:
    with Run(load_experiment(recording)) as run, golden.raises(SnapshotError):
        run.restore(saved)


def test_a_cut_snapshot_is_refused(recording: Path, golden: Golden) -> None:
    taken = bytes(next(Recording(recording).messages({SNAPSHOTS})).message.data)
    with Run(load_experiment(recording)) as run:
        for length in (10, len(taken) // 2, len(taken) - 1):
            with golden.raises(SnapshotError):
                run.restore(taken[:length])


def test_a_result_says_where_robots_are_after_a_restore_or_reset_without_a_step() -> None:
    with Run(load_experiment("braitenberg_husky", [*SETTINGS, "transfer_functions=[]"])) as run:
        start = run.result().final_pose
        run.run_until(0.04)
        snapshot, there = run.snapshot(), run.result().final_pose
        run.run_until(0.1)
        assert run.result().final_pose != there
        run.restore(snapshot)
        assert run.result().final_pose == there
        run.reset("robot")
        assert run.result().final_pose["husky"] == pytest.approx(start["husky"])
        assert there["husky"] != pytest.approx(start["husky"])


def test_a_function_that_was_stopped_before_a_snapshot_is_missing_after_it(tmp_path: Path) -> None:
    (tmp_path / "wrong.py").write_text("@nrp.Neuron2Robot()\ndef wrong(t):\n    1 / 0\n")
    functions = f"transfer_functions=[{tmp_path / 'wrong.py'}]"
    experiment = load_experiment("braitenberg_husky", [*SETTINGS, functions, "on_error=quarantine"])
    with Run(experiment) as run:
        run.run_until(0.1)
        snapshot = run.snapshot()
    with Run(experiment) as again:
        assert again.result().complete
        again.restore(snapshot)
        again.run()
        result = again.result()
        assert [problem.code.name for problem in result.problems] == ["NRP272", "NRP248"]
        assert (result.complete, result.failures) == (False, [])
        again.loop.reset()
        assert again.result().complete
