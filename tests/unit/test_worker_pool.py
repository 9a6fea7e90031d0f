"""Tasks in several processes of this machine."""

import os
import signal
import subprocess
import sys
from importlib import import_module
from operator import truediv
from pathlib import Path

import pytest

from nrp_core._support.worker_pool import WorkerDiedError, WorkerPool

PATIENCE_S = 60.0
PROGRAM = """
import os, signal
from nrp_core._support.worker_pool import WorkerPool

pool = WorkerPool(2)
outcomes = pool.perform(eval, ["__import__('os').getpid()", "__import__('signal').pause()"])
print(next(outcomes).value, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
ONCE = """
import os
from pathlib import Path

if os.getpid() != {pid} and not Path("{mark}").exists():
    Path("{mark}").touch()
    os._exit(1)

def end(task):
    os._exit(2)
"""


def half_of(number: float) -> float:
    """Return half of a number, or end the process at 13."""
    if number == 13:
        os.kill(os.getpid(), signal.SIGKILL)
    return truediv(number, 2)


def test_processes_end_with_the_one_that_started_them_also_within_a_task(tmp_path: Path) -> None:
    """All hold the pipe, so that its end is that of all; the program has no guard of its main part."""
    (tmp_path / "program.py").write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "program.py"], cwd=tmp_path, stdout=subprocess.PIPE, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == -9
    assert int(done.stdout)


def test_a_process_that_is_killed_loses_its_own_task_only_and_is_replaced() -> None:
    with WorkerPool(2) as pool:
        outcomes = {one.task: one for one in pool.perform(half_of, range(30))}
        pids = pool.pids()
    died = outcomes.pop(13)
    assert isinstance(died.error, WorkerDiedError)
    assert str(died.error) == "signal 9"
    assert {task: one.value for task, one in outcomes.items()} == {n: n / 2 for n in range(30) if n != 13}
    for pid in pids:  # the block ended them
        assert not Path(f"/proc/{pid}").exists()


def test_an_error_of_a_task_is_returned_in_its_outcome() -> None:
    with WorkerPool(1) as pool:
        (outcome,) = pool.perform(half_of, ["a text"])  # type: ignore[list-item]
    assert isinstance(outcome.error, TypeError)


def test_a_process_that_dies_at_its_start_differs_from_one_that_dies_in_its_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = tmp_path / "died"
    (tmp_path / "once.py").write_text(ONCE.format(pid=os.getpid(), mark=str(mark)))
    monkeypatch.syspath_prepend(tmp_path)
    end = import_module("once").end
    with WorkerPool(1) as pool:
        errors = [one.error for one in pool.perform(end, ["first", "second", "third"])]
    assert [isinstance(error, WorkerDiedError) and error.has_begun for error in errors] == [False, True, True]
    assert mark.exists()
