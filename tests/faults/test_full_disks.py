"""A disk that becomes full while a run is recorded: seen on a real file system that is too small."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.recording.reading.steps import steps_of
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest
from nrp_core.recording.writing.writer import RESERVE_BYTES, GrowingFile

SIZE = 2 << 20


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 2 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("this user may not mount a file system")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk_ends_the_run_and_every_step_up_to_there_is_recorded(disk: Path) -> None:
    folder = disk / "run"
    command = [
        sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--until", "60s",
        "--record", str(folder), "--snapshots", "off", "--json",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 1
    result = json.loads(done.stdout)
    assert result["error"]["message"] == "the recording cannot be written: No space left on device"
    assert 0.5 < result["sim_time_s"] < 60
    recording = Recording(folder)
    last_s = [step.t_ns for step in steps_of(recording)][-1] * 1e-9
    assert last_s == pytest.approx(result["sim_time_s"])
    assert recording.check().intact
    with Replay(recording, ReplayRequest()) as again:
        assert again.verify().identical


@pytest.mark.heavy
def test_a_recording_is_complete_on_a_disk_that_was_nearly_full_at_its_start(disk: Path) -> None:
    (disk / "ballast").write_bytes(bytes(SIZE - 300_000))
    folder = disk / "run"
    command = [
        sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--until", "60s",
        "--record", str(folder), "--images", "off", "--json",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 1
    assert json.loads(done.stdout)["error"]["message"].endswith("No space left on device")
    recording = Recording(folder)
    assert json.loads((folder / "run.json").read_text())["state"] == "failed"
    assert recording.check().intact


@pytest.mark.heavy
def test_a_limited_file_size_ends_the_run_and_every_step_up_to_there_is_recorded(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    command = [
        sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--until", "60s",
        "--record", str(folder), "--snapshots", "off", "--json",
    ]  # fmt: skip
    limited = ["bash", "-c", 'ulimit -f 2000; exec "$@"', "bash", *command]
    done = subprocess.run(limited, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 1
    result = json.loads(done.stdout)
    assert result["error"]["message"] == "the recording cannot be written: File too large"
    recording = Recording(folder)
    assert [step.t_ns for step in steps_of(recording)][-1] * 1e-9 == pytest.approx(result["sim_time_s"])
    assert recording.check().intact


def test_a_recording_that_cannot_be_completed_makes_a_run_that_failed(disk: Path, tmp_path: Path) -> None:
    (tmp_path / "talk.py").write_text(
        "@nrp.MapCSVRecorder('rows', filename='rows.csv', headers=['text'])\n@nrp.Robot2Neuron()\n"
        "def talk(t, rows):\n    rows.record_entry('x' * 400_000)\n"
    )
    folder = disk / "run"
    command = [
        sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--until", "200ms", "--record",
        str(folder), "--images", "off", "-s", "criteria={here: {near: {model: husky, point: [0, 0], "
        "within: 5 m}}}", "-s", f"transfer_functions=[{tmp_path}/talk.py]",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 1
    assert "the recording cannot be completed: No space left on device" in done.stderr
    assert done.stdout.splitlines()[-1] == "failed at 0.2 s"
    assert "passed" not in done.stdout
    recording = Recording(folder)
    assert recording.check().intact
    assert (recording.run["state"], recording.run["result"]["passed"]) == ("failed", False)


def test_data_larger_than_the_reserve_leave_a_readable_recording(disk: Path, golden: Golden) -> None:
    file = GrowingFile(disk / "file")
    piece = bytes(range(256)) * 1024

    def fill() -> None:
        while True:
            file.append(piece)

    with golden.raises(OSError) as caught:
        fill()
    assert file.failed is caught.value
    assert file.full is not None
    with golden.raises(OSError):
        file.append(b"x")  # after a gap nothing may follow
    file.close()
    data = (disk / "file").read_bytes()
    assert data == piece * (len(data) // len(piece))
    assert len(data) == file.size > SIZE - len(piece)


def test_the_reserve_is_given_back_when_a_file_is_closed(disk: Path) -> None:
    for number in range(5):
        with GrowingFile(disk / f"{number}") as file:
            assert SIZE - RESERVE_BYTES - 200_000 < _free(disk) < SIZE - RESERVE_BYTES + 1
            file.append(b"whole")
        assert _free(disk) > SIZE - 100_000
    assert sorted(path.name for path in disk.iterdir()) == ["0", "1", "2", "3", "4"]


def _free(folder: Path) -> int:
    found = os.statvfs(folder)
    return found.f_bavail * found.f_frsize
