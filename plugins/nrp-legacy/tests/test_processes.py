"""Processes, threads and programs that code starts wait in simulated time, and end with the run."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

_START = """
import {module}, rospy, time
said = []
def work(first, last=0):
    said.append((first, rospy.get_time()))
    rospy.sleep(0.1)
    said.append((last, rospy.get_time()))
    while True:
        time.sleep(1.0)
one = {kind}(target=work, args=(1,), kwargs={{"last": 2}})
one.start()
@nrp.Robot2Neuron()
def f(t):
    pass
"""


@pytest.fixture
def opened(written: Callable[..., Path]) -> Callable[[str], Run]:
    return lambda code: Run(read_exc(written("circuit = sim.Population(1, sim.IF_curr_exp())", code)))


def _names(run: Run) -> dict[str, Any]:
    return dict(vars(run.experiment.maker.names.module))  # type: ignore[union-attr]


@pytest.mark.parametrize("kind", ["multiprocessing.Process", "threading.Thread"])
def test_threads_and_processes_wait_in_simulated_time_and_end(
    opened: Callable[[str], Run], kind: str
) -> None:
    with opened(_START.format(module=kind.partition(".")[0], kind=kind)) as run:
        run.run_until(0.3)
        (first, begun_s), (last, woken_s) = _names(run)["said"]
        assert (first, last) == (1, 2)
        assert woken_s - begun_s == pytest.approx(0.1)
        assert _names(run)["one"].is_alive()
    assert not _names(run)["one"].is_alive()


def test_a_thread_that_waits_for_something_else_does_not_hold_the_run(
    opened: Callable[[str], Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nrp_legacy.shims.processes._PATIENCE_S", 0.25)
    queue = "import threading, Queue\nasked, answers = Queue.Queue(), []\n"
    code = (
        "def serve():\n    while True: answers.append(asked.get())\nthreading.Thread(None, serve).start()\n"
    )
    function = "@nrp.Robot2Neuron()\ndef f(t): asked.put(t)\n"
    with opened(queue + code + function) as run:
        run.run_until(0.3)
        time.sleep(0.1)
        assert len(_names(run)["answers"]) >= 10


def test_an_error_is_reported_and_a_class_of_a_user_runs(opened: Callable[[str], Run]) -> None:
    code = """
import threading
class Own(threading.Thread):
    def __init__(self):
        threading.Thread.__init__(self, name="own")
        self.daemon = True
    def run(self):
        raise ValueError("no")
Own().start()
@nrp.Robot2Neuron()
def f(t): pass
"""
    with opened(code) as run:
        run.run_until(0.1)
        (told,) = [one.message for one in run.problems if one.code is Code.NRP280]
        assert told == "'own' was stopped by ValueError: no"


_FUNCTION = "@nrp.Robot2Neuron()\ndef f(t): pass\n"


def _is_running(pid: int) -> bool:
    """Return whether a process is there and has not ended; one that has may wait for its parent."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    "start",
    [
        "import subprocess\nsubprocess.Popen('sleep 60 & echo $! > {file}; wait', shell=True)",
        "import os\nos.system('sleep 60 & echo $! > {file}')",
        "import os\nos.system('trap \"\" TERM; sleep 60 & echo $! > {file}')",
        "import os, time\npid = os.fork()\nif pid == 0:\n    import signal\n    signal.pause()\n"
        "with open('{file}', 'w') as file: file.write(str(pid))",
    ],
)
def test_processes_of_programs_and_forks_end_with_the_run(
    opened: Callable[[str], Run], tmp_path: Path, start: str
) -> None:
    file = tmp_path / "pid"
    with opened(f"{start.format(file=file)}\n{_FUNCTION}") as run:
        run.run_until(0.04)
        deadline = time.monotonic() + 60.0
        while not (file.exists() and file.read_text().strip()) and time.monotonic() < deadline:
            time.sleep(0.01)
        pid = int(file.read_text())
        assert _is_running(pid)
    assert not _is_running(pid)


def test_a_fork_in_a_function_is_not_a_second_run(opened: Callable[[str], Run], tmp_path: Path) -> None:
    """Its exit, and its return from the function, end it; it is there until its parent looks."""
    file = tmp_path / "steps"
    code = f"""
import os, sys
@nrp.Robot2Neuron()
def f(t):
    if t == 0.0:
        f.pids = [os.fork(), os.fork()] if os.getpid() == {os.getpid()} else []
        if 0 in f.pids:
            sys.exit()
    os.system('exit 3') == 3 << 8 or 1 / 0
    with open("{file}", "a") as steps:
        steps.write(f"{{os.getpid()}} ")
"""
    with opened(code) as run:
        run.run_until(0.1)
        time.sleep(0.2)
        assert not run.loop.failures
        assert file.read_text().split() == [str(os.getpid())] * 5


def test_a_program_ends_with_the_run(opened: Callable[[str], Run]) -> None:
    code = (
        "import subprocess\nchild = subprocess.Popen(['sleep', '60'])\n@nrp.Robot2Neuron()\ndef f(t): pass\n"
    )
    with opened(code) as run:
        run.run_until(0.04)
        assert _names(run)["child"].poll() is None
    assert _names(run)["child"].poll() is not None
