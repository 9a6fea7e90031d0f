"""Every byte of a recording counts: whatever is flipped, missing or added is found and named."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from nrp_core._support import machine
from nrp_core.cli.session import RunRequest, Session
from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import EXPERIMENT_NAME, MCAP_NAME, RUN_NAME, RUNNING, Images
from nrp_core.recording.reading.integrity import MISSING
from nrp_core.recording.reading.recover import recover
from nrp_core.recording.reading.steps import steps_of
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict
from nrp_core.recording.sealing import DAMAGED, seal
from nrp_core.recording.writing import writer

MOST_BYTES = 30 * 1024
STEPS = 3
END_NS = STEPS * 20_000_000


@pytest.fixture
def folder(fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording of engines that simulate nothing, a chunk for each step, without what is installed here."""
    monkeypatch.setattr(writer, "FLUSH_S", 0.0)
    monkeypatch.setattr(machine, "distributions", dict)
    folder = tmp_path / "recording"
    request = RunRequest(str(drive_to_the_wall), ["criteria=null"], "0.06s", folder, Images.EXACT, "off")
    assert Session(request).run(as_json=False) == 0
    return folder


@pytest.fixture
def killed(folder: Path) -> Path:
    """The recording as a kill leaves it: without its last digests and without the end of its messages."""
    run = dict(Recording(folder).run)
    files = {name: digest for name, digest in run["files"].items() if name != MCAP_NAME}
    (folder / RUN_NAME).write_bytes(seal(run | {"state": RUNNING, "result": None, "files": files}))
    data = (folder / MCAP_NAME).read_bytes()
    (folder / MCAP_NAME).write_bytes(data[: _end_of_messages(folder) - 20])  # within the index of a chunk
    return folder


def _end_of_messages(folder: Path) -> int:
    from mcap.reader import make_reader

    with (folder / MCAP_NAME).open("rb") as file:
        last = make_reader(file).get_summary().chunk_indexes[-1]
    return last.chunk_start_offset + last.chunk_length + last.message_index_length


def files_of(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def flips(path: Path, every: int) -> Iterator[int]:
    """Flip one bit after the other, each in another byte, and put it right again."""
    data = path.read_bytes()
    with path.open("r+b", buffering=0) as file:
        for place in range(0, len(data), every):
            os.pwrite(file.fileno(), bytes([data[place] ^ 1 << place % 8]), place)
            yield place
            os.pwrite(file.fileno(), data[place : place + 1], place)


def check_flips(folder: Path, every: int) -> int:
    count = 0
    for path in files_of(folder):
        name = path.relative_to(folder).as_posix()
        for place in flips(path, every):
            found = [flaw.file for flaw in Recording(folder).check().flaws]
            assert found == [name], f"byte {place} of {name}"
            count += 1
    return count


def test_a_recording_is_intact_as_it_was_written(folder: Path) -> None:
    check = Recording(folder).check()
    assert check.intact
    assert check.notes == []
    assert check.size + (folder / RUN_NAME).stat().st_size == sum(p.stat().st_size for p in files_of(folder))


def test_a_flipped_bit_is_found_in_every_file(folder: Path) -> None:
    assert check_flips(folder, every=31) > 600


@pytest.mark.heavy
def test_a_flipped_bit_is_found_in_every_byte(folder: Path) -> None:
    size = sum(path.stat().st_size for path in files_of(folder))
    assert size <= MOST_BYTES
    assert check_flips(folder, every=1) == size


Change = Callable[[bytes], bytes]
CHANGES: list[Change] = [lambda data: data[:-1], lambda data: data[1:], lambda data: data + b"\0"]


@pytest.mark.parametrize("change", CHANGES, ids=["last byte missing", "first byte missing", "one byte more"])
def test_a_byte_that_is_missing_or_added_is_found_in_every_file(folder: Path, change: Change) -> None:
    for path in files_of(folder):
        data = path.read_bytes()
        path.write_bytes(change(data))
        assert [flaw.file for flaw in Recording(folder).check().flaws] == [
            path.relative_to(folder).as_posix()
        ]
        path.write_bytes(data)
    assert Recording(folder).check().intact


def test_a_file_that_is_missing_is_named_with_its_part_in_the_experiment(folder: Path) -> None:
    (folder / "experiment" / "drive.py").unlink()
    (folder / EXPERIMENT_NAME).unlink()
    assert [str(flaw) for flaw in Recording(folder).check().flaws] == [
        f"experiment/drive.py (transfer_functions) {MISSING}",
        f"{EXPERIMENT_NAME} (the experiment as it was run) {MISSING}",
    ]


def test_a_flaw_says_from_where_on_the_messages_are_lost(folder: Path) -> None:
    third = [step.t_ns for step in steps_of(Recording(folder))][2]
    data = bytearray((folder / MCAP_NAME).read_bytes())
    places = [at for at in range(len(data)) if data.startswith(b"\x04\x22\x4d\x18", at)]
    data[places[3] + 20] ^= 1
    (folder / MCAP_NAME).write_bytes(data)
    (flaw,) = Recording(folder).check().flaws
    assert str(flaw) == f"{MCAP_NAME} (messages after {third * 1e-9:g} s) {DAMAGED}"


def test_a_file_that_the_recording_does_not_list_is_reported_and_is_not_a_failure(folder: Path) -> None:
    (folder / "experiment" / "notes.txt").write_text("seen on Tuesday\n")
    check = Recording(folder).check()
    assert check.intact
    assert check.notes == ["experiment/notes.txt is not part of the recording"]


def verdict(folder: Path, request: ReplayRequest | None = None) -> ReplayVerdict:
    with Replay(Recording(folder), request or ReplayRequest()) as again:
        return again.verify().verdict


@pytest.mark.parametrize("places", [8, pytest.param(60, marks=pytest.mark.heavy)])
def test_a_recording_with_a_flaw_is_never_identical(folder: Path, places: int) -> None:
    assert verdict(folder) is ReplayVerdict.IDENTICAL
    path, refused = folder / MCAP_NAME, 0
    for _ in flips(path, every=path.stat().st_size // places):
        try:
            assert verdict(folder) is ReplayVerdict.UNPROVED
        except ExperimentError as error:
            assert "without an intact step" in error.message  # noqa: PT017  which is as clear
            refused += 1
    assert refused < places / 3


def test_less_than_was_recorded_is_never_identical(folder: Path) -> None:
    assert verdict(folder, ReplayRequest(until_ns=40_000_000)) is ReplayVerdict.SAME
    assert verdict(folder, ReplayRequest(until_ns=END_NS)) is ReplayVerdict.IDENTICAL
    assert verdict(folder, ReplayRequest(frozenset({"brain"}))) is ReplayVerdict.SAME
    assert verdict(folder, ReplayRequest(until_ns=0)) is ReplayVerdict.UNPROVED


def test_the_recording_of_a_killed_run_is_unfinished_and_checked_as_far_as_it_goes(killed: Path) -> None:
    check = Recording(killed).check()
    assert (check.finished, check.intact, check.flaws) == (False, False, ())
    assert check.chain is not None
    assert (check.chain.steps, check.chain.until_ns) == (STEPS, END_NS)
    assert check.notes[0].startswith("the recording is unfinished")
    with Replay(Recording(killed), ReplayRequest()) as again:
        outcome = again.verify()
    assert (outcome.verdict, outcome.steps) == (ReplayVerdict.IDENTICAL, STEPS)
    assert outcome.warnings[0].message.startswith("the recording is unfinished")


def test_a_recording_that_is_being_written_is_not_called_damaged(
    fakes: None, drive_to_the_wall: Path, tmp_path: Path
) -> None:
    with Run(load_experiment(drive_to_the_wall)) as run:
        written = RecordingFolder(run, tmp_path / "recording")
        run.run(0.5)
        with (tmp_path / "recording" / MCAP_NAME).open("ab") as file:
            file.write(b"half of a chunk")
        check = Recording(tmp_path / "recording").check()
        written.close("finished")
    assert (check.is_growing, check.flaws) == (True, ())
    assert check.notes[0].startswith("the recording is being written")


@pytest.mark.parametrize("every", [37, pytest.param(1, marks=pytest.mark.heavy)])
def test_damage_to_the_messages_of_a_killed_run_is_not_taken_for_its_end(killed: Path, every: int) -> None:
    """Whatever bit is flipped: every step that is in the file is read, or the file has a flaw."""
    path = killed / MCAP_NAME
    counts = {True: 0, False: 0}
    for place in flips(path, every):
        check = Recording(killed).check()
        assert check.chain is not None
        assert check.flaws or check.chain.steps == STEPS, place
        counts[bool(check.flaws)] += 1
    assert counts[True] > 0.5 * sum(counts.values())


def test_a_recovered_recording_is_checked_by_the_hashes_of_its_steps(killed: Path) -> None:
    recover(Recording(killed))
    check = Recording(killed).check()
    assert (check.flaws, check.finished) == ((), False)
    assert check.chain is not None
    assert check.chain.steps == STEPS
    assert check.unlisted == ("recording.damaged.mcap",)


def test_messages_that_do_not_match_their_hash_are_found_without_a_digest(killed: Path) -> None:
    """Written anew as a whole: a forged command, then a step that is left out."""
    whole = killed.parent / "whole"
    shutil.copytree(killed, whole)
    forged = [
        (lambda name, number, data: data[:-1] + bytes([data[-1] ^ 1]) if name == "/husky/cmd_vel" else data),
        (lambda name, number, data: None if (name, number) == ("/nrp/steps", 2) else data),
    ]
    problems = ["the messages of the outputs do not match their hash", "step 2 is missing"]
    for forge, problem in zip(forged, problems, strict=True):
        _rewrite(whole / MCAP_NAME, killed / MCAP_NAME, forge)
        (flaw,) = Recording(killed).check().flaws
        assert problem in flaw.holds


def _rewrite(source: Path, target: Path, forge: Callable[[str, int, bytes], bytes | None]) -> None:
    from nrp_core.messages.cdr import Codec
    from nrp_core.recording.writing.writer import McapFile

    recording, numbers = Recording(source), dict[str, int]()
    file = McapFile(target, Codec({}))
    for topic, message in recording.raw():
        if not file.knows(topic.name):
            recording.define(file.codec, topic)
            file.announce(topic.name, topic.type_name, topic.about)
        number = numbers[topic.name] = numbers.get(topic.name, -1) + 1
        data = forge(topic.name, number, message.data)
        if data is not None:
            file.write(topic.name, message.log_time, (data,))
    file.close()
