"""The commands on recordings, with engines that simulate nothing and have no snapshots."""

import json
import shutil
import threading
import time
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from mcap.reader import make_reader

from nrp_core.experiment.running.control import ControlServer, send_command
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import read_sealed, seal

Nrp = Callable[..., Any]
PLAIN = Path(__file__).parents[2] / "recordings" / "plain_0.1.0"


@pytest.fixture
def recorded(nrp: Nrp, experiment: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "recorded"
    done = nrp("run", experiment, "--until", "1s", "--record", folder, "--snapshots", "0.2s")
    assert done.code == 0
    assert done.out.count("no snapshots are recorded: CountingBrain cannot save and restore its state") == 1
    return folder


@pytest.fixture
def slower(recorded: Path, tmp_path: Path) -> Path:
    """The recorded transfer function, changed."""
    edited = tmp_path / "edited" / "drive.py"
    edited.parent.mkdir()
    source = (recorded / "experiment" / "drive.py").read_text()
    edited.write_text(source.replace("Vector3(forward", "Vector3(0.5 * forward"))
    return edited


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("raster", "--panels", "map"), "note: --panels has no effect on 'raster', which is one part"),
        (("-o", "run.svg", "--dpi", 300), "note: --dpi has no effect on a figure that is not a PNG file"),
        (("-o", "run.png", "--dpi", 50, "--panels", "timeline"), ""),
    ],
)
def test_options_of_figures_without_effect_are_reported(
    nrp: Nrp, recorded: Path, options: tuple[str, ...], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(recorded.parent)
    done = nrp("plot", recorded, *options)
    assert done.code == 0
    assert [line for line in done.err.splitlines() if "no effect" in line] == [words] * bool(words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--eye", "1,2,3"), "has no effect with --view follow"),
        (("--view", "above", "--robot", "husky"), "has no effect with --view above"),
        (("--camera", "eye", "--view", "above"), "shows recorded images: leave out --view"),
        (("--camera", "eye", "--size", "100x100"), "shows recorded images: leave out --view, --size"),
        (
            ("--view", "free", "--eye", "nan,2,3"),
            "a point is three numbers in m, such as 1,2.5,0.3, not 'nan",
        ),
        (("--from", "-1s"), "must be 0 or more, not -1s"),
        (("--view", "free", "--eye", "1,2,3", "--target", "1,2,3.0"), "there is no direction to look in"),
    ],
)
def test_an_option_of_another_view_of_a_video_is_refused(
    nrp: Nrp, options: tuple[str, ...], words: str
) -> None:
    done = nrp("video", PLAIN, *options)
    assert done.code == 2
    assert words in " ".join(done.err.split())


def test_an_option_beside_a_check_or_a_format_that_it_contradicts_is_refused(
    nrp: Nrp, experiment: Path, tmp_path: Path
) -> None:
    for arguments, words in (
        (("inspect", PLAIN, "--check", "--image", "a.png"), "it has no effect with --check"),
        (("validate", experiment, "--format", "sarif", "--json"), "--json and --format sarif contradict"),
        (("export", PLAIN, "--format", "csv", "-o", tmp_path / "out.csv"), "csv is written as a folder of"),
    ):
        done = nrp(*arguments)
        assert done.code == 2
        assert words in " ".join((done.out + done.err).split())
    assert not list(tmp_path.glob("out*"))
    assert nrp("inspect", PLAIN, "--check").code == 0
    assert nrp("validate", experiment, "--format", "json", "--json").code == 0


def test_settings_of_a_recording_and_its_difference_from_itself_are_refused(nrp: Nrp) -> None:
    inspected = nrp("inspect", PLAIN, "--check", "-s", "seed=4")
    assert inspected.code == 2
    assert "a recording has the settings of its run; omit this option" in " ".join(inspected.err.split())
    compared = nrp("diff", PLAIN, PLAIN.parent / "." / PLAIN.name)
    assert compared.code == 2
    assert "it is the first recording, which has no difference" in " ".join(compared.err.split())


def test_a_page_too_small_for_its_texts_is_noted(nrp: Nrp, tmp_path: Path, golden: Golden) -> None:
    done = nrp("plot", PLAIN, "--size", "90x60mm", "-o", tmp_path / "page.png")
    assert "150x100mm" in done.err
    golden(done.err)
    assert "overlap" not in nrp("plot", PLAIN, "raster", "--size", "90x60mm", "-o", tmp_path / "r.png").err


def test_a_recording_is_verified(nrp: Nrp, recorded: Path) -> None:
    done = nrp("replay", recorded, "--verify")
    assert (done.code, done.out) == (0, "identical: 0 s to 1 s, 50 steps\n")


def test_functions_changed_before_the_first_step_are_changed_again(
    nrp: Nrp, experiment: Path, slower: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The request waits at the socket from its first moment on; the first step waits for its answer."""
    socket, folder = tmp_path / "run.sock", tmp_path / "changed"
    changed: list[str] = []

    def change() -> None:
        while not socket.exists():
            time.sleep(0.001)
        (drive,) = send_command(socket, "functions", add=[str(slower)], remove=[], activate=[], deactivate=[])
        changed.append(drive["place"])

    client = threading.Thread(target=change, daemon=True)
    answer = ControlServer.answer

    def answer_at_once(server: ControlServer) -> None:
        answer(server)
        client.join(60)

    monkeypatch.setattr(ControlServer, "answer", answer_at_once)
    client.start()
    assert nrp("run", experiment, "--until", "0.4s", "--record", folder, "--control", socket).code == 0
    assert changed[0].startswith(str(slower))
    commands = [one.message.linear.x for one in Recording(folder).messages({"/husky/cmd_vel"})]
    assert set(commands) == {0.5}
    done = nrp("replay", folder, "--verify")
    assert (done.code, done.out) == (0, "identical: 0 s to 0.4 s, 20 steps\n")


def test_a_recorded_brain_needs_no_brain_script(nrp: Nrp, experiment: Path, tmp_path: Path) -> None:
    ran, folder = tmp_path / "ran", tmp_path / "recorded"
    script = experiment / "brain.py"
    script.write_text(f"with open({str(ran)!r}, 'a') as ran:\n    ran.write('x')\n" + script.read_text())
    assert nrp("run", experiment, "--until", "1s", "--record", folder).code == 0
    before = ran.read_text()
    done = nrp("replay", folder, "--brain", "recorded", "--world", "recorded", "--verify")
    assert done.code == 0
    assert done.out.startswith(
        "the same: 0 s to 1 s, 50 steps; not compared: the brain, which was played back"
    )
    assert ran.read_text() == before
    assert nrp("replay", folder, "--verify").code == 0
    assert ran.read_text() > before


def test_the_first_difference_is_reported_and_fails_a_verification(
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
    nrp: Nrp, recorded: Path, slower: Path, tmp_path: Path, golden: Golden
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
    assert "0.5" in refused.err
    golden(refused.err)


def test_a_side_is_played_back(nrp: Nrp, recorded: Path, golden: Golden) -> None:
    for side in ("--world", "--brain"):
        assert nrp("replay", recorded, side, "recorded", "--verify").code == 0
        wrong = nrp("replay", recorded, side, "mujoco")
        assert wrong.code == 2
        assert "DIR" in wrong.err
        golden(wrong.err)


def test_a_wrong_request_is_refused_before_anything_runs(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    assert nrp("replay", tmp_path / "nowhere").code == 2
    assert nrp("replay", recorded, "--from", "soon").code == 2
    assert nrp("replay", recorded, "--record", recorded).code == 2
    assert nrp("replay", recorded, "--verify", "--record", tmp_path / "new").code == 2
    assert nrp("run", recorded, "--snapshots", "0s").code == 2
    back = nrp("replay", recorded, "--from", "0.5s", "--until", "0.2s")
    assert (back.code, back.err) == (3, "error: cannot continue from 0.5 s until 0.2 s\n")
    between = nrp("replay", recorded, "--until", "0.03s")
    assert (between.code, between.err) == (
        3,
        f"error: {recorded}: there is no step at 0.03 s; the next step is at 0.04 s\n",
    )
    assert "not a recording" in nrp("replay", recorded / RUN_NAME).err
    assert "did you mean 'raster'" in nrp("plot", recorded, "rasta").err
    assert "did you mean 'nwb'" in nrp("export", recorded, "-f", "nwbb").err


def test_a_recording_is_an_experiment(nrp: Nrp, recorded: Path) -> None:
    assert json.loads(nrp("run", recorded, "--until", "1s", "--json").out)["steps"] == 50


def test_inspect_lists_the_contents_of_a_recording(nrp: Nrp, recorded: Path) -> None:
    done = nrp("inspect", recorded)
    assert done.code == 0
    assert done.out.startswith("drive_to_the_wall: counting and disc, seed 7\n")
    size_kb = (recorded / MCAP_NAME).stat().st_size / 1000
    assert f"\n  0 s to 1 s, 50 steps, {size_kb:.1f} kB\n" in done.out
    assert "/husky/cmd_vel" in done.out
    assert done.out.splitlines()[-1].endswith("(criteria judged up to 1 s of 3 s: 2 open)")
    bare = nrp("inspect", recorded / MCAP_NAME, "--json")
    assert json.loads(bare.out)["topics"]["/husky/cmd_vel"]["messages"] == 50


def test_a_cut_recording_is_reported_recovered_and_verified_up_to_the_cut(nrp: Nrp, recorded: Path) -> None:
    file = recorded / MCAP_NAME
    file.write_bytes(file.read_bytes()[:-1])
    assert "nrp recover" in nrp("inspect", recorded).err
    cut = nrp("replay", recorded, "--verify")
    flaw = "recording.mcap (all messages are intact, the data around them is not) was changed or damaged"
    assert (cut.code, cut.out) == (1, f"not identical: {flaw} since it was written\n")
    assert "all messages are intact" in nrp("replay", recorded).err
    done = nrp("recover", recorded)
    assert done.code == 0
    assert (recorded / "recording.damaged.mcap").is_file()
    assert "nothing to recover" in nrp("recover", recorded).out
    assert nrp("replay", recorded, "--verify").code == 1


def test_without_a_description_of_the_run_it_is_never_identical(
    nrp: Nrp, recorded: Path, golden: Golden
) -> None:
    (recorded / RUN_NAME).unlink()
    flaw = "run.json (the description of the run, and the digests of all other files) is missing"
    done = nrp("replay", recorded, "--verify")
    assert (done.code, done.out) == (1, f"not identical: {flaw}\n")
    again = nrp("replay", recorded)
    assert again.out == f"not identical: {flaw}\n"
    golden(again.err)


def test_a_recording_without_its_messages_is_one_that_lost_them(nrp: Nrp, recorded: Path) -> None:
    (recorded / MCAP_NAME).unlink()
    done = nrp("inspect", "--check", recorded)
    assert (done.code, "recording.mcap (every message) is missing" in done.err) == (1, True)
    shown = nrp("inspect", recorded)
    assert (shown.code, "'recording.mcap'" in shown.err) == (3, True)


def test_messages_that_do_not_belong_to_the_run_are_noticed(nrp: Nrp, recorded: Path) -> None:
    assert nrp("inspect", recorded).err == ""
    run = read_sealed(recorded / RUN_NAME)
    run["result"]["sim_time_s"] += 1.0
    (recorded / RUN_NAME).write_bytes(seal(run))
    done = nrp("inspect", recorded)
    assert (done.code, "they may be those of another run" in done.err) == (0, True)
    (recorded / RUN_NAME).unlink()
    assert "run.json is missing: the experiment, its seed and its verdict" in nrp("inspect", recorded).err


def test_steps_beyond_the_end_of_a_recording_are_not_called_the_same(nrp: Nrp, recorded: Path) -> None:
    done = nrp("replay", recorded, "--until", "1.2s", "--verify")
    assert done.out.startswith("the same: 0 s to 1 s, 50 steps; not compared: the steps after 1 s")


def test_a_run_that_was_killed_is_compared_as_far_as_it_went(
    nrp: Nrp, experiment: Path, recorded: Path, tmp_path: Path
) -> None:
    killed, page = tmp_path / "killed", tmp_path / "page.html"
    nrp("run", experiment, "--until", "2s", "--record", killed)
    told = json.loads((killed / RUN_NAME).read_text())
    told |= {"result": None, "state": "running"}
    del told["files"][MCAP_NAME]
    (killed / RUN_NAME).write_bytes(seal(told))
    file = killed / MCAP_NAME
    file.write_bytes(file.read_bytes()[:-1])
    done = nrp("diff", killed, recorded, "--html", page)
    assert done.code == 0
    assert done.out.splitlines()[-2] == "identical: 51 steps"
    said = " ".join(done.out.split())
    assert f"{killed} is truncated or damaged: only its intact part is compared" in said
    assert f"compared from 0 s to 1 s; {killed} goes from 0 s to 2 s" in said
    assert "goes from 0 s to 2 s" in page.read_text()
    other = json.loads(nrp("diff", killed, recorded, "--json").out)
    assert len(other["reservations"]) == 2
    same = shutil.copytree(recorded, tmp_path / "same")
    assert json.loads(nrp("diff", recorded, same, "--json").out)["reservations"] == []


def flipped(recording: Path, copy: Path, *, among_messages: bool) -> str:
    """Flip a bit of a copy, in the first chunk of its messages or behind the last; return its flaw."""
    shutil.copytree(recording, copy)
    data = bytearray((copy / MCAP_NAME).read_bytes())
    summary = make_reader(BytesIO(data)).get_summary()
    assert summary is not None
    first, last = summary.chunk_indexes[0], summary.chunk_indexes[-1]
    middle = first.chunk_start_offset + first.chunk_length // 2
    behind = last.chunk_start_offset + last.chunk_length + last.message_index_length
    data[middle if among_messages else (behind + len(data)) // 2] ^= 1
    (copy / MCAP_NAME).write_bytes(data)
    return f"{copy}: {Recording(copy).check().flaws[0]}"


def test_two_recordings_of_which_one_is_damaged_are_never_identical(
    nrp: Nrp, recorded: Path, tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    flaw = flipped(recorded, tmp_path / "damaged", among_messages=False)
    done = nrp("diff", recorded, tmp_path / "damaged", "--html", page)
    assert done.code == 1
    assert "".join(done.out.split()).startswith("".join(flaw.split()))
    assert "not identical: a recording was changed or damaged" in done.out
    assert "was changed or damaged</h1>" in page.read_text()
    assert nrp("diff", recorded, tmp_path / "damaged", "--engines").code == 1
    told = json.loads(nrp("diff", recorded, tmp_path / "damaged", "--json").out)
    assert (told["identical"], told["flaws"]) == (False, [flaw])


def test_a_recording_of_which_no_step_can_be_read_is_not_compared(
    nrp: Nrp, recorded: Path, tmp_path: Path
) -> None:
    flaw = flipped(recorded, tmp_path / "damaged", among_messages=True)
    done = nrp("diff", recorded, tmp_path / "damaged")
    assert done.code == 3
    assert f"has no step in common with {tmp_path / 'damaged'}; {flaw}" in done.err


def test_a_recording_is_exported(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    done = nrp("export", recorded, "-f", "csv", "-o", tmp_path / "tables", "--json")
    assert len(json.loads(done.out)["files"]) == len(list((tmp_path / "tables").iterdir()))


@pytest.mark.one_of(8)
@pytest.mark.parametrize("what", ["raster", "trajectory", "devices", "camera"])
def test_each_part_of_the_figure_is_drawn_by_itself(
    nrp: Nrp, recorded: Path, tmp_path: Path, what: str, golden: Golden
) -> None:
    done = nrp("plot", recorded, what, "-o", tmp_path / "figure.png")
    if what == "camera":
        assert done.code == 3
        assert "'camera'" in done.err
        golden(done.err)
    else:
        assert done.code == 0
        assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_a_figure_is_named_after_its_contents(
    nrp: Nrp, recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for what in ("run", "raster"):
        assert nrp("plot", recorded, what).out == f"{what}.png\n"
        assert (tmp_path / f"{what}.png").is_file()


def test_the_intact_part_of_a_cut_recording_is_drawn_with_a_warning(
    nrp: Nrp, recorded: Path, tmp_path: Path, golden: Golden
) -> None:
    file, figure = recorded / MCAP_NAME, tmp_path / "figure.svg"
    file.write_bytes(file.read_bytes()[:-1])
    done = nrp("plot", recorded, "-o", figure)
    assert (done.code, done.out) == (0, f"{figure}\n")
    golden(done.err)
    figure.unlink()
    file.write_bytes(b"")
    nothing = nrp("plot", recorded, "-o", figure)
    assert nothing.code == 3
    golden(nothing.err)
    assert not figure.exists()


def test_a_file_that_is_not_a_recording_stays_unchanged(nrp: Nrp, tmp_path: Path, golden: Golden) -> None:
    file = tmp_path / "letters.mcap"
    file.write_text("dear reader\n" * 99)
    done = nrp("recover", file)
    assert (done.code, done.out) == (3, "")
    golden(done.err)
    assert [each.name for each in tmp_path.iterdir()] == ["letters.mcap"]
    assert file.read_text().startswith("dear reader")


def test_a_figure_that_cannot_be_written_is_named(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    done = nrp("plot", recorded, "-o", tmp_path / "folder.png")
    assert done.code != 0
    assert "folder.png" in done.err
    assert "Errno" not in done.err


@pytest.mark.parametrize(
    ("command", "options"), [("export", ("-f", "csv")), ("plot", ()), ("recover", ()), ("replay", ())]
)
def test_a_file_of_another_kind_is_refused_and_nothing_is_written(
    nrp: Nrp, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, options: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "anything.txt").write_text("anything\n")
    done = nrp(command, "anything.txt", *options)
    assert done.code == 2
    assert "anything.txt: not a recording" in " ".join(done.err.replace("\u2502", " ").split())
    assert [path.name for path in tmp_path.iterdir()] == ["anything.txt"]


def test_an_export_of_a_file_of_which_nothing_is_whole_is_refused(
    nrp: Nrp, tmp_path: Path, golden: Golden
) -> None:
    (tmp_path / "noise.mcap").write_bytes(bytes(range(256)))
    done = nrp("export", tmp_path / "noise.mcap", "-f", "csv", "-o", tmp_path / "tables")
    assert done.code == 3
    golden(done.err)
    assert not (tmp_path / "tables").exists()


def test_a_check_names_a_damaged_file_and_ends_with_1(nrp: Nrp, recorded: Path) -> None:
    done = nrp("inspect", recorded, "--check")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith(f"{recorded}: intact: ")
    (recorded / "notes.txt").touch()
    listing = recorded / "experiment" / "drive.py"
    listing.write_bytes(listing.read_bytes().replace(b" ", b"\t", 1))
    done = nrp("inspect", recorded, "--check")
    assert (done.code, done.out) == (1, f"{recorded}: not intact\n")
    assert done.err.splitlines() == [
        "note: notes.txt is not part of the recording",
        "error: experiment/drive.py (transfer_functions) was changed or damaged since it was written",
    ]
    data = json.loads(nrp("inspect", recorded, "--check", "--json").out)
    assert (data["intact"], [flaw["file"] for flaw in data["flaws"]]) == (False, ["experiment/drive.py"])
    verified = nrp("replay", recorded, "--verify")
    assert (verified.code, verified.out.startswith("not identical: experiment/drive.py")) == (1, True)


def test_only_a_recording_can_be_checked(nrp: Nrp, experiment: Path) -> None:
    assert nrp("inspect", experiment / "husky.sdf", "--check").code == 2


def test_a_replay_of_an_incomplete_run_says_that_it_is(
    nrp: Nrp, experiment: Path, tmp_path: Path, raising: Callable[[str], str]
) -> None:
    folder = tmp_path / "incomplete"
    settings = ("-s", raising("1 / 0"), "-s", "on_error=quarantine")
    assert nrp("run", experiment, *settings, "--record", folder).code == 1
    done = nrp("replay", folder)
    assert "the run is not complete:" in done.out
    assert "✗ the transfer function 'wrong' raised ZeroDivisionError" in done.out
    told = json.loads(nrp("replay", folder, "--json").out)["result"]
    assert (told["complete"], told["problems"][0]["code"]) == (False, "NRP272")
