"""Processes, threads and programs that code starts wait in simulated time, and end with the run."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

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


def _names(run: Run) -> dict[str, object]:
    names: dict[str, object] = vars(run.experiment.maker.names.module)  # type: ignore[union-attr]
    return names


@pytest.mark.parametrize("kind", ["multiprocessing.Process", "threading.Thread"])
def test_what_is_started_waits_in_simulated_time_and_ends(opened: Callable[[str], Run], kind: str) -> None:
    with opened(_START.format(module=kind.partition(".")[0], kind=kind)) as run:
        run.run_until(0.3)
        (first, begun_s), (last, woken_s) = _names(run)["said"]  # type: ignore[misc]
        assert (first, last) == (1, 2)
        assert woken_s - begun_s == pytest.approx(0.1)
        assert _names(run)["one"].is_alive()  # type: ignore[attr-defined]
    assert not _names(run)["one"].is_alive()  # type: ignore[attr-defined]


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
        assert len(_names(run)["answers"]) >= 10  # type: ignore[arg-type]


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
        (told,) = [one.message for one in run.problems if one.code is Code.NRP281]
        assert told == "'own' was stopped by ValueError: no"


def test_a_program_ends_with_the_run(opened: Callable[[str], Run]) -> None:
    code = (
        "import subprocess\nchild = subprocess.Popen(['sleep', '60'])\n@nrp.Robot2Neuron()\ndef f(t): pass\n"
    )
    with opened(code) as run:
        run.run_until(0.04)
        assert _names(run)["child"].poll() is None  # type: ignore[attr-defined]
    assert _names(run)["child"].poll() is not None  # type: ignore[attr-defined]
