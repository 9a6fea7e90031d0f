"""Processes, threads and programs that code starts: they run beside the loop and end with the run.

A process or a thread waits in simulated time, as a state machine does. A process is not one of the system, so
that it sees the topics of the run. Programs, and copies of the run by ``os.fork``, lead groups of processes,
so that what they start ends too. Such a copy also ends after the step: the run is that of its parent.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from itertools import count
from multiprocessing import dummy
from types import ModuleType
from typing import Any, Final

from nrp_core.cle.loop import ClosedLoop
from nrp_core.clock import from_seconds
from nrp_core.experiment import Run, RunObserver
from nrp_core.findings import Code
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import bound, overlay
from nrp_legacy.shims.steps import Task

_PATIENCE_S: Final = 5.0
"""Wall time for which the loop waits until code waits; code that does not then goes on beside it."""
_GRACE_S: Final = 1.0
_POLL_S: Final = 0.01
_PROBE: Final = 0
"""The signal that only asks whether there is a process."""
_OF_THREADS = (
    "Array", "Barrier", "BoundedSemaphore", "Condition", "Event", "JoinableQueue", "Lock", "Manager", "Pipe",
    "Pool", "Queue", "RLock", "Semaphore", "Value",
)  # fmt: skip
"""Names of ``multiprocessing`` for threads of one process."""


class Started(RunObserver[Run]):
    """All that the code of one experiment has started.

    Args:
        graph: the graph of the run.

    Attributes:
        workers: its processes and threads.
        groups: the leaders of other processes, each with what removes it once it has ended.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.workers: list[Worker] = []
        self.groups: list[tuple[int, Callable[[], object]]] = []
        self._own_pid = os.getpid()

    def begin(self, run: Run) -> None:
        """Connect to a run."""
        run.loop.hooks.after_step.append(self._advance)
        run.loop.hooks.after_reset.append(lambda _loop: self.end())
        run.observers.append(self)

    def closing(self, run: Run) -> None:
        self.end()

    def end(self) -> None:
        """End everything."""
        for worker in self.workers:
            worker.terminate()
        for leader, reap in self.groups:
            _end_group(leader, reap)
        self.workers.clear()
        self.groups.clear()

    def fork(self) -> int:
        """Fork as ``os.fork`` does."""
        pid = os.fork()
        with suppress(PermissionError, ProcessLookupError):  # both sides do it, as either may be first
            os.setpgid(pid, pid)
        if pid:
            self.groups.append((pid, partial(os.waitpid, pid, os.WNOHANG)))
        return pid

    def system(self, command: str) -> int:
        """Execute a command in a shell as ``os.system`` does."""
        program = subprocess.Popen(command, shell=True, start_new_session=True)
        self.groups.append((program.pid, program.poll))
        code = program.wait()
        if not _reach(program.pid, _PROBE):
            self.groups.pop()
        return code << 8 if code >= 0 else -code

    def _advance(self, loop: ClosedLoop) -> None:
        if os.getpid() != self._own_pid:
            os._exit(0)  # a forked copy: the run is that of its parent
        for worker in list(self.workers):
            worker.advance()
            if not worker.is_alive():
                self.workers.remove(worker)


def _end_group(leader: int, reap: Callable[[], object]) -> None:
    """End a group of processes, those that do not end within a second by force."""
    for sent in (signal.SIGTERM, signal.SIGKILL):
        _reach(leader, sent)
        deadline_s = time.monotonic() + _GRACE_S
        while time.monotonic() < deadline_s:
            with suppress(ChildProcessError):
                reap()
            if not _reach(leader, _PROBE):
                return
            time.sleep(_POLL_S)


def _reach(leader: int, sent: int) -> bool:
    """Send a signal to a group of processes; return whether it has any."""
    try:
        os.killpg(leader, sent)
    except (ProcessLookupError, PermissionError):
        return False
    return True


class Worker:
    """A process or a thread; users derive classes from it, and override :meth:`run`.

    Args:
        started: holds it.
        target: the function that it calls, with ``args`` and ``kwargs``.
    """

    pid = ident = 1
    daemon = False
    exitcode: int | None = None
    _numbers = count(1)

    def __init__(
        self,
        started: Started,
        group: None = None,
        target: Callable[..., Any] | None = None,
        name: str | None = None,
        args: Any = (),
        kwargs: Mapping[str, Any] | None = None,
        **_more: Any,
    ) -> None:
        self.name = name or f"{type(self).__name__}-{next(self._numbers)}"
        self._started, self._call = started, target and partial(target, *args, **(kwargs or {}))
        self._task: Task | None = None
        self._patience_s = _PATIENCE_S

    def run(self) -> None:
        """Call the function."""
        if self._call is not None:
            self._call()

    def start(self) -> None:
        """Begin after this step."""
        self._task = Task(self.run, lambda: self._started.graph.now_ns)
        self._started.workers.append(self)

    def is_alive(self) -> bool:
        """Return whether it runs or waits."""
        return self._task is not None and not self._task.is_over

    isAlive = is_alive

    def join(self, timeout: float | None = None) -> None:
        """Wait for its end; code that cannot wait continues at once."""
        graph = self._started.graph
        end_ns = None if timeout is None else graph.now_ns + from_seconds(timeout)
        while self.is_alive() and graph.can_wait and (end_ns is None or graph.now_ns < end_ns):
            graph.wait_until(0)

    def terminate(self) -> None:
        """End it where it is."""
        if self._task is not None and self._task is not Task.here():
            self._task.stop()

    kill = terminate

    def setDaemon(self, daemon: bool) -> None:  # noqa: N802 - the name of Python 2
        """Do nothing, because everything ends with the run."""

    def advance(self) -> None:
        """Let it run until it waits; if it does not, let it go on beside the loop until it does."""
        assert self._task is not None
        self._patience_s = _PATIENCE_S if self._task.waits_within(self._patience_s) else 0.0
        if self._task.error is not None:
            error, self._task.error = self._task.error, None
            self.exitcode = 1
            self._started.graph.warn(
                Code.NRP280,
                f"'{self.name}' was stopped by {type(error).__name__}: {error}",
                subject=self.name,
            )
        elif self._task.is_over:
            self.exitcode = 0


def process_modules(started: Started) -> dict[str, ModuleType]:
    """Return the modules by which code starts processes, threads and programs."""
    process, thread = bound(Worker, started), bound(Worker, started)
    process.__name__, thread.__name__ = "Process", "Thread"

    class Timer(thread):  # type: ignore[misc,valid-type]
        def __init__(
            self, interval: float, function: Callable[..., Any], args: Any = (), kwargs: Any = None
        ) -> None:
            super().__init__(None, function, None, args or (), kwargs)
            self._interval_ns = from_seconds(interval)

        def run(self) -> None:
            started.graph.wait_until(started.graph.now_ns + self._interval_ns)
            super().run()

        cancel = Worker.terminate

    class Popen(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *values: Any, **options: Any) -> None:
            super().__init__(*values, **{**options, "start_new_session": True})
            started.groups.append((self.pid, self.poll))

    def start_new_thread(function: Callable[..., Any], args: Any, kwargs: Any = None) -> int:
        thread(None, function, None, args, kwargs).start()
        return 1

    ours = {name: getattr(dummy, name) for name in _OF_THREADS}
    threads = {"start_new_thread": start_new_thread, "start_new": start_new_thread}
    return {
        "multiprocessing": overlay("multiprocessing", {"Process": process, **ours}),
        "threading": overlay("threading", {"Thread": thread, "Timer": Timer}),
        "thread": overlay("thread", threads, real="_thread"),
        "_thread": overlay("_thread", threads),
        "subprocess": overlay("subprocess", {"Popen": Popen}),
    }
