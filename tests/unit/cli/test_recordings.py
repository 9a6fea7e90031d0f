"""The commands on recordings, with engines that simulate nothing and have no snapshots."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nrp_core.recording.layout import MCAP_NAME, RUN_NAME
from nrp_core.recording.reading.recording import DIGEST, digest_of

Nrp = Callable[..., Any]


@pytest.fixture
def recorded(nrp: Nrp, experiment: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "recorded"
    done = nrp("run", experiment, "--until", "1s", "--record", folder, "--snapshots", "0.2s")
    assert done.code == 0
    assert done.err.count("no snapshots are recorded: CountingBrain cannot save and restore its state") == 1
    return folder


@pytest.fixture
def slower(recorded: Path, tmp_path: Path) -> Path:
    """The recorded transfer function, changed."""
    edited = tmp_path / "edited" / "drive.py"
    edited.parent.mkdir()
    source = (recorded / "experiment" / "drive.py").read_text()
    edited.write_text(source.replace("Vector3(forward", "Vector3(0.5 * forward"))
    return edited


def test_a_recording_is_verified(nrp: Nrp, recorded: Path) -> None:
    done = nrp("replay", recorded, "--verify")
    assert (done.code, done.out) == (0, "identical: 0 s to 1 s, 50 steps\n")


def test_the_first_difference_is_told_and_fails_what_is_to_be_verified(
    nrp: Nrp, recorded: Path, slower: Path
) -> None:
    done = nrp("replay", recorded, "--transfer-functions", slower, "--verify")
    assert done.code == 1
    assert done.out == (
        "differs first at step 1, 0.02 s: /husky/cmd_vel (outputs) was linear.x 1.0, now is linear.x 0.5\n"
    )
    assert nrp("replay", recorded, "--transfer-functions", slower).code == 0


def test_the_difference_is_data_too(nrp: Nrp, recorded: Path, slower: Path) -> None:
    told = json.loads(nrp("replay", recorded, "--transfer-functions", slower, "--json").out)
    assert told["identical"] is False
    assert told["difference"]["step"] == 1
    assert told["difference"]["signal"] == "/husky/cmd_vel"
    assert told["result"]["sim_time_s"] == 1.0


def test_without_snapshots_it_goes_on_from_within_all_the_same(
    nrp: Nrp, recorded: Path, slower: Path, tmp_path: Path
) -> None:
    future = tmp_path / "future"
    done = nrp(
        "replay",
        recorded,
        "--from",
        "0.5s",
        "--until",
        "2s",
        "--transfer-functions",
        slower,
        "--record",
        future,
    )
    assert "step 26, 0.52 s: /husky/cmd_vel (outputs) was linear.x 1.0, now is linear.x 0.5" in done.out
    told = json.loads(nrp("inspect", future, "--json").out)
    assert (told["begin_s"], told["end_s"], told["steps"]) == (0.5, 2.0, 75)
    assert told["continues"]["recording"] == "recorded"
    refused = nrp("replay", future)
    assert refused.code == 3
    assert "begins at 0.5 s, and there is no snapshot" in refused.err


def test_a_side_is_played_back(nrp: Nrp, recorded: Path) -> None:
    for side in ("--world", "--brain"):
        assert nrp("replay", recorded, side, "recorded", "--verify").code == 0
        wrong = nrp("replay", recorded, side, "mujoco")
        assert wrong.code == 2
        assert "for another backend, use nrp run DIR" in wrong.err


def test_what_is_asked_for_wrongly_is_refused_before_anything_runs(
    nrp: Nrp, recorded: Path, tmp_path: Path
) -> None:
    assert nrp("replay", tmp_path / "nowhere").code == 2
    assert nrp("replay", recorded, "--from", "soon").code == 2
    assert nrp("replay", recorded, "--record", recorded).code == 2
    assert nrp("replay", recorded, "--verify", "--record", tmp_path / "new").code == 2
    assert nrp("run", recorded, "--snapshots", "0s").code == 2
    back = nrp("replay", recorded, "--from", "0.5s", "--until", "0.2s")
    assert (back.code, back.err) == (3, "error: cannot go on from 0.5 s until 0.2 s\n")
    between = nrp("replay", recorded, "--until", "0.03s")
    assert (between.code, between.err) == (
        3,
        f"error: {recorded}: there is no step at 0.03 s; the next is at 0.04 s\n",
    )
    assert "no recording of a run" in nrp("replay", recorded / RUN_NAME).err
    assert "did you mean 'raster'" in nrp("plot", recorded, "rasta").err
    assert "did you mean 'nwb'" in nrp("export", recorded, "-f", "nwbb").err


def test_a_recording_is_an_experiment(nrp: Nrp, recorded: Path) -> None:
    assert json.loads(nrp("run", recorded, "--until", "1s", "--json").out)["steps"] == 50


def test_inspect_tells_what_a_recording_holds(nrp: Nrp, recorded: Path) -> None:
    done = nrp("inspect", recorded)
    assert done.code == 0
    assert done.out.startswith("drive_to_the_wall: counting and disc, seed 7\n  0 s to 1 s, 50 steps, ")
    assert "/husky/cmd_vel" in done.out
    bare = nrp("inspect", recorded / MCAP_NAME, "--json")
    assert json.loads(bare.out)["topics"]["/husky/cmd_vel"]["messages"] == 50


def test_a_cut_recording_is_told_recovered_and_verified_as_far_as_it_goes(nrp: Nrp, recorded: Path) -> None:
    file = recorded / MCAP_NAME
    file.write_bytes(file.read_bytes()[:-1])
    assert "nrp recover" in nrp("inspect", recorded).err
    cut = nrp("replay", recorded, "--verify")
    assert (cut.code, cut.out) == (0, "identical: 0 s to 1 s, 50 steps\n")
    assert "only its beginning is available" in cut.err
    done = nrp("recover", recorded)
    assert done.code == 0
    assert (recorded / "recording.damaged.mcap").is_file()
    assert "nothing to recover" in nrp("recover", recorded).out
    assert nrp("replay", recorded, "--verify").err.count("warning") == 0


def test_without_what_tells_what_ran_it_is_verified_and_that_is_said(nrp: Nrp, recorded: Path) -> None:
    (recorded / RUN_NAME).unlink()
    done = nrp("replay", recorded, "--verify")
    assert done.out == "identical: 0 s to 1 s, 50 steps\n"
    assert done.err == "warning: there is no run.json: what ran, and with which files, is not known\n"


def test_a_run_that_was_killed_is_compared_as_far_as_it_went(
    nrp: Nrp, experiment: Path, recorded: Path, tmp_path: Path
) -> None:
    killed, page = tmp_path / "killed", tmp_path / "page.html"
    nrp("run", experiment, "--until", "2s", "--record", killed)
    told = json.loads((killed / RUN_NAME).read_text())
    told |= {"result": None, "state": "running"}
    (killed / RUN_NAME).write_text(json.dumps(told | {DIGEST: digest_of(told)}))
    file = killed / MCAP_NAME
    file.write_bytes(file.read_bytes()[:-1])
    done = nrp("diff", killed, recorded, "--html", page)
    assert done.code == 0
    assert done.out.splitlines()[-2] == "identical: 51 steps"
    said = " ".join(done.out.split())
    assert f"{killed} was cut or damaged: only its intact part is compared" in said
    assert f"compared from 0 s to 1 s; {killed} goes from 0 s to 2 s" in said
    assert "goes from 0 s to 2 s" in page.read_text()
    other = json.loads(nrp("diff", killed, recorded, "--json").out)
    assert len(other["reservations"]) == 2
    assert json.loads(nrp("diff", recorded, recorded, "--json").out)["reservations"] == []


def test_a_recording_is_exported(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    done = nrp("export", recorded, "-f", "csv", "-o", tmp_path / "tables", "--json")
    assert len(json.loads(done.out)["files"]) == len(list((tmp_path / "tables").iterdir()))


@pytest.mark.parametrize("what", ["raster", "trajectory", "devices", "camera"])
def test_each_part_of_the_figure_is_drawn_by_itself(
    nrp: Nrp, recorded: Path, tmp_path: Path, what: str
) -> None:
    done = nrp("plot", recorded, what, "-o", tmp_path / "figure.png")
    if what == "camera":
        assert done.code == 3
        assert "there is nothing to draw for 'camera'" in done.err
    else:
        assert done.code == 0
        assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_a_figure_is_named_after_what_it_shows(
    nrp: Nrp, recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for what in ("run", "raster"):
        assert nrp("plot", recorded, what).out == f"{what}.png\n"
        assert (tmp_path / f"{what}.png").is_file()


def test_of_a_cut_recording_what_is_whole_is_drawn_and_said(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    file, figure = recorded / MCAP_NAME, tmp_path / "figure.svg"
    file.write_bytes(file.read_bytes()[:-1])
    done = nrp("plot", recorded, "-o", figure)
    assert (done.code, done.out) == (0, f"{figure}\n")
    assert done.err == "warning: the recording is truncated or damaged: only its intact part is drawn\n"
    figure.unlink()
    file.write_bytes(b"")
    nothing = nrp("plot", recorded, "-o", figure)
    assert nothing.code == 3
    assert "nothing was recorded, or nothing of it is whole" in nothing.err
    assert not figure.exists()


def test_a_file_that_is_no_recording_is_left_as_it_is(nrp: Nrp, tmp_path: Path) -> None:
    file = tmp_path / "letters.mcap"
    file.write_text("dear reader\n" * 99)
    done = nrp("recover", file)
    assert (done.code, done.out) == (3, "")
    assert done.err == f"error: {file}: not one whole message of a recording is in it\n"
    assert [each.name for each in tmp_path.iterdir()] == ["letters.mcap"]
    assert file.read_text().startswith("dear reader")


def test_a_figure_that_cannot_be_written_is_named(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    done = nrp("plot", recorded, "-o", tmp_path / "folder.png")
    assert done.code != 0
    assert "folder.png" in done.err
    assert "Errno" not in done.err
