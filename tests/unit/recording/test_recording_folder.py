"""A recorded run as a folder: what ran, with every file it used."""

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder import recording_folder
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import Role
from nrp_core.recording.recording import Recording

Open = Callable[..., Run]


@pytest.fixture
def experiment(fakes: None, drive_to_the_wall: Path) -> Path:
    """An experiment whose brain needs another file, with a variant."""
    folder = drive_to_the_wall
    (folder / "weights.csv").write_text("1,2\n")
    (folder / "unused.csv").write_text("1,2\n")
    brain = folder / "brain.py"
    read = "from pathlib import Path\nPath(__file__).with_name('weights.csv').read_text()\n"
    brain.write_text(read + brain.read_text())
    (folder / "variant.yaml").write_text("extends: experiment.yaml\nseed: 5\n")
    return folder


@pytest.fixture
def open_run(experiment: Path) -> Iterator[Open]:
    runs: list[Run] = []

    def opened(*overrides: str) -> Run:
        runs.append(Run(load_experiment(experiment / "variant.yaml", overrides)))
        return runs[-1]

    yield opened
    for run in runs:
        run.close()


def copies(folder: Path) -> set[str]:
    root = folder / "experiment"
    return {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}


def test_every_file_that_was_read_is_kept_and_no_other(
    open_run: Open, experiment: Path, tmp_path: Path
) -> None:
    with FilesRead() as files:
        run = open_run()
        RecordingFolder(run, tmp_path / "out", files=files).close("finished")
    assert copies(tmp_path / "out") == {
        "variant.yaml", "experiment.yaml", "brain.py", "drive.py", "husky.sdf", "room.sdf", "weights.csv",
    }  # fmt: skip


def test_a_recording_inside_the_folder_of_its_experiment_holds_no_copy_of_itself(
    open_run: Open, experiment: Path
) -> None:
    for name in ("first", "second"):
        with FilesRead() as files:
            run = open_run()
            RecordingFolder(run, experiment / "runs" / name, files=files).close("finished")
            assert copies(experiment / "runs" / name) == {
                "variant.yaml", "experiment.yaml", "brain.py", "drive.py", "husky.sdf", "room.sdf",
                "weights.csv",
            }  # fmt: skip


def test_without_a_listener_the_files_that_are_named_are_kept(open_run: Open, tmp_path: Path) -> None:
    RecordingFolder(open_run(), tmp_path / "out").close("finished")
    assert copies(tmp_path / "out") >= {"variant.yaml", "experiment.yaml", "brain.py", "drive.py", "room.sdf"}


def test_a_kept_run_can_be_repeated_with_the_same_result(open_run: Open, tmp_path: Path) -> None:
    run = open_run()
    with FilesRead() as files:
        open_run()
        recording_folder = RecordingFolder(run, tmp_path / "out", files=files)
        run.run()
        recording_folder.close("finished")
    told = Recording(tmp_path / "out").run
    with Run(load_experiment(tmp_path / "out" / told["file"])) as again:
        again.run()
        assert again.result().trajectory_digest == told["result"]["trajectory_digest"]


def test_the_description_says_what_a_result_depends_on(open_run: Open, tmp_path: Path) -> None:
    run = open_run("timestep=40 ms")
    recording_folder = RecordingFolder(run, tmp_path / "out")
    at_start = Recording(tmp_path / "out").run
    assert (at_start["state"], at_start["result"]) == ("running", None)
    run.run()
    recording_folder.close("finished")
    told = Recording(tmp_path / "out").run
    assert (told["format"], told["experiment"], told["seed"], told["state"]) == (
        4, "drive_to_the_wall", 5, "finished",
    )  # fmt: skip
    assert told["file"] == "experiment/variant.yaml"
    assert told["settings"]["timestep"] == 40_000_000
    assert told["brain"]["populations"] == {"circuit": {"size": 4, "cell_type": "IF_curr_exp"}}
    assert told["brain"]["views"]["actors"] == {"circuit": [[2, 4]]}
    assert told["brain"]["network"] == run.brain.network.digest
    assert told["world"]["scene"] == run.world.scene.digest
    assert told["aliases"] == {"/glass": "/wall/body/glass/color"}
    assert told["distributions"]["fakes"] == "1.0"
    assert told["machine"]["python"].endswith(".".join(map(str, sys.version_info[:3])))
    assert told["result"]["passed"] is True


def test_events_show_as_what_they_published(open_run: Open, tmp_path: Path) -> None:
    run = open_run()
    recording_folder = RecordingFolder(run, tmp_path / "out")
    run.run()
    recording_folder.close("finished")
    colours = list(Recording(tmp_path / "out").messages({"/wall/body/glass/color"}))
    assert [(one.t_ns, one.message.r, one.message.b) for one in colours] == [
        (500_000_000, 1.0, 0.0), (2_020_000_000, 0.0, 1.0),
    ]  # fmt: skip
    assert {topic.name for topic in Recording(tmp_path / "out").with_role(Role.PUBLISHED)} == {
        "/speed", "/husky/cmd_vel", "/wall/body/glass/color",
    }  # fmt: skip


def test_recording_changes_nothing(open_run: Open, tmp_path: Path) -> None:
    recorded, plain = open_run(), open_run()
    recording_folder = RecordingFolder(recorded, tmp_path / "out")
    for run in (recorded, plain):
        run.run()
    recording_folder.close("finished")
    varying = ("wall_time_s", "real_time_factor", "time_share")
    results = [
        {k: v for k, v in run.result().to_dict().items() if k not in varying} for run in (recorded, plain)
    ]
    assert results[0] == results[1]


def test_a_folder_that_is_not_empty_is_not_touched(open_run: Open, tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "out").mkdir()
    RecordingFolder(open_run(), tmp_path / "out").close("finished")
    before = (tmp_path / "out" / "run.json").read_text()
    with golden.raises(ExperimentError):
        RecordingFolder(open_run(), tmp_path / "out")
    assert (tmp_path / "out" / "run.json").read_text() == before


def test_of_two_runs_that_begin_to_record_at_one_moment_one_is_refused(
    open_run: Open, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    folder = tmp_path / "out"
    monkeypatch.setattr(
        recording_folder, "check_folder", lambda folder: None
    )  # nothing was there when they looked
    run = open_run()
    first = RecordingFolder(run, folder)
    with golden.raises(ExperimentError):
        RecordingFolder(open_run(), folder)
    run.run()
    first.close("finished")
    assert Recording(folder).complete
    assert Recording(folder).run["result"]["steps"] == run.loop.steps


def test_an_interrupt_before_the_first_message_leaves_no_recording(
    open_run: Open, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    run, folder = open_run(), tmp_path / "recording"
    with monkeypatch.context() as patch:
        patch.setattr(recording_folder, "McapRecorder", interrupted)
        with pytest.raises(KeyboardInterrupt):
            RecordingFolder(run, folder)
    assert not folder.exists()
    RecordingFolder(run, folder).close("finished")
    assert Recording(folder).run["state"] == "finished"


def test_a_folder_that_cannot_be_made_is_one_clear_error(
    open_run: Open, tmp_path: Path, golden: Golden
) -> None:
    (tmp_path / "file").touch()
    with golden.raises(ExperimentError):
        RecordingFolder(open_run(), tmp_path / "file" / "out")


def test_the_description_is_json_without_nan(open_run: Open, tmp_path: Path) -> None:
    recording_folder = RecordingFolder(open_run(), tmp_path / "out")
    recording_folder.close("finished")
    text = (tmp_path / "out" / "run.json").read_text()

    def refuse(constant: str) -> Any:
        raise AssertionError(constant)

    assert json.loads(text, parse_constant=refuse)["result"]["passed"] is None


def test_installed_software_below_a_folder_is_not_part_of_an_experiment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed, own = tmp_path / "venv" / "package.py", tmp_path / "own.py"
    for path in (installed, own):
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "venv"))
    with FilesRead() as files:
        for path in (installed, own):
            path.read_text()
        (tmp_path / "written.txt").write_text("")
    assert files.below([tmp_path]) == [own]
    assert files.below([installed.parent]) == [installed]


def test_a_compiled_module_stands_for_its_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "helper_of_a_brain.py").write_text("VALUE = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    for _ in range(2):
        sys.modules.pop("helper_of_a_brain", None)
        with FilesRead() as files:
            import helper_of_a_brain  # noqa: F401
        assert files.below([tmp_path]) == [tmp_path / "helper_of_a_brain.py"]
