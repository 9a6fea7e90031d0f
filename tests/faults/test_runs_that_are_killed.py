"""What a run has reached is on disk a tenth of a second later: seen in the file while the run goes on."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import pytest

from nrp_core.recording.layout import MCAP_NAME
from nrp_core.recording.reading.steps import steps_of
from nrp_core.recording.recording import Recording

LOST_S = 0.1
PERIOD_S = 0.02
SAMPLES = 8
PATIENCE_S = 60.0
PROGRAM = """
import os, sys, time
from pathlib import Path
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder

folder, hangs_at_ns = Path(sys.argv[1]), int(sys.argv[2])


def stamp(run):
    os.write(1, f"{run.loop.now_ns} {time.monotonic_ns()}\\n".encode())


def hang(loop):
    if loop.now_ns == hangs_at_ns:
        time.sleep(1000)


with Run(load_experiment("braitenberg_husky", ["world.options.image_scale=0.2", "pace=realtime"])) as run:
    RecordingFolder(run, folder)
    run.on_step(stamp)
    run.loop.hooks.before_step.append(hang)
    run.run()
"""
Stamp = tuple[int, float]
"""The time that a step has reached, ns, and the wall time at which it was recorded, s."""


class Running:
    """A run in another process that stamps each step once it was handed to the recording."""

    def __init__(self, folder: Path, process: subprocess.Popen[bytes]) -> None:
        self.file, self._process = folder / MCAP_NAME, process
        self._said = b""
        assert process.stdout is not None
        os.set_blocking(process.stdout.fileno(), False)

    def stamps(self) -> list[Stamp]:
        """Return all stamps so far."""
        assert self._process.stdout is not None
        self._said += self._process.stdout.read() or b""
        whole = self._said[: self._said.rfind(b"\n") + 1].decode()
        pairs = (line.split() for line in whole.splitlines())
        return [(int(t_ns), int(wall_ns) * 1e-9) for t_ns, wall_ns in pairs]

    def wait_for(self, steps: int) -> list[Stamp]:
        """Return the stamps once there are so many."""
        deadline = time.monotonic() + PATIENCE_S
        while len(stamps := self.stamps()) < steps:
            assert time.monotonic() < deadline
            assert self._process.poll() is None
            time.sleep(0.01)
        return stamps

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()


@contextmanager
def running(folder: Path, *, hangs_at_s: float = -1.0) -> Iterator[Running]:
    command = [sys.executable, "-c", PROGRAM, str(folder), str(round(hangs_at_s * 1e9))]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    run = Running(folder, process)
    try:
        yield run
    finally:
        run.kill()
        assert process.stdout is not None
        process.stdout.close()


def reached_ns(recording: Path) -> int:
    return [step.t_ns for step in steps_of(Recording(recording))][-1]


def check(stamps: list[Stamp], recording: Path) -> None:
    """What was lost is young, but for the time in which the machine let nobody run."""
    kept_ns, (_, now_s) = reached_ns(recording), stamps[-1]
    lost = [wall_s for t_ns, wall_s in stamps if t_ns > kept_ns]
    stalled_s = max(b[1] - a[1] - PERIOD_S for a, b in pairwise(stamps))
    assert not lost or now_s - lost[0] <= LOST_S + max(0.0, stalled_s)


@pytest.mark.heavy
def test_whenever_a_run_is_killed_it_loses_at_most_a_tenth_of_a_second(tmp_path: Path) -> None:
    with running(tmp_path / "run") as run:
        samples = []
        for number in range(SAMPLES):
            stamps, copy = run.wait_for(20 + 7 * number), tmp_path / f"{number}.mcap"
            copy.write_bytes(run.file.read_bytes())  # a kill would leave just this
            samples.append((stamps, copy))
        last = run.stamps()
        run.kill()
    for stamps, copy in [*samples, (last, run.file)]:
        check(stamps, copy)


@pytest.mark.heavy
def test_steps_before_one_that_does_not_end_are_on_disk(tmp_path: Path) -> None:
    for hangs_at_s in (0.4, 0.42):  # wherever that is between two times of writing
        with running(tmp_path / f"{hangs_at_s}", hangs_at_s=hangs_at_s) as run:
            stamps = run.wait_for(round(hangs_at_s / PERIOD_S))
            until = time.monotonic() + PATIENCE_S
            while reached_ns(run.file) < stamps[-1][0] and time.monotonic() < until:
                time.sleep(0.05)
            run.kill()
        assert reached_ns(run.file) == stamps[-1][0] == round(hangs_at_s * 1e9)
