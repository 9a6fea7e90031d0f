"""Perform tasks in several processes of this machine.

A process that dies is replaced, and only the task that it was at is concerned. Processes are started anew
rather than forked, because engines have threads and libraries that do not survive a fork; they do not import
the script that started them.
"""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

T = TypeVar("T")
R = TypeVar("R")
_STANDARD_ERROR = 2


class WorkerDiedError(Exception):
    """A process ended while it was at a task: it was killed, or an engine crashed in it.

    Args:
        cause: how it ended.
        has_begun: whether it had started and imported the function before, so that the task may be the cause.
    """

    def __init__(self, cause: str, has_begun: bool) -> None:
        super().__init__(cause)
        self.has_begun = has_begun


@dataclass(frozen=True, slots=True)
class TaskOutcome(Generic[T, R]):
    """What came of a task.

    Args:
        task: the task.
        value: the return value of its function.
        error: its exception, or a :class:`WorkerDiedError`.
    """

    task: T
    value: R | None
    error: BaseException | None = None


class WorkerPool:
    """Processes that perform tasks; they are ended with the block.

    Args:
        size: their number; each starts with its first task.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._idle: list[Worker] = []
        self._busy: dict[Worker, Any] = {}
        self._starting: set[Worker] = set()

    def perform(self, function: Callable[[T], R], tasks: Iterable[T]) -> Iterator[TaskOutcome[T, R]]:
        """Perform tasks and yield their outcomes, in the order in which they end.

        Args:
            function: at the top level of a module that can be imported.
            tasks: are taken when a process is free for them, so that they may depend on earlier outcomes.
        """
        waiting = iter(tasks)
        while True:
            while len(self._busy) < self._size and (given := next(waiting, self)) is not self:
                self._give(function, given)
            if not self._busy:
                return
            for connection in wait([worker.connection for worker in self._busy]):
                worker = next(one for one in self._busy if one.connection is connection)
                if not self._begins(worker):
                    yield self._outcome(worker, self._busy.pop(worker))

    def _give(self, function: Any, task: Any) -> None:
        while self._idle:
            worker = self._idle.pop()
            try:
                worker.connection.send((function, task))
            except OSError:  # it died while it was idle
                worker.end()
            else:
                self._busy[worker] = task
                return
        self._start(function, task)

    def _start(self, function: Any, task: Any) -> None:
        """Start a process; before it answers the task, it reports that it has imported the function."""
        worker = Worker()
        with suppress(OSError):  # it died at once, which is noticed when it does not answer
            worker.connection.send((callable, function))
            worker.connection.send((function, task))
        self._busy[worker] = task
        self._starting.add(worker)

    def _begins(self, worker: Worker) -> bool:
        """Take the first answer of a new process; return False if it answers the task, or is missing."""
        if worker not in self._starting:
            return False
        try:
            worker.connection.recv()
        except (EOFError, OSError):
            return False
        self._starting.remove(worker)
        return True

    def _outcome(self, worker: Worker, task: Any) -> TaskOutcome[Any, Any]:
        try:
            value, error = worker.connection.recv()
        except (EOFError, OSError):
            has_begun = worker not in self._starting
            self._starting.discard(worker)
            return TaskOutcome(task, None, WorkerDiedError(worker.end(), has_begun))
        self._idle.append(worker)
        return TaskOutcome(task, value, error)

    def pids(self) -> list[int]:
        """Return the operating system's numbers of the processes."""
        return [worker.process.pid for worker in (*self._idle, *self._busy)]

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in (*self._idle, *self._busy):  # unfinished tasks would be repeated anyway
            worker.end()
        self._idle.clear()
        self._busy.clear()
        self._starting.clear()


class Worker:
    """One process and the socket to it; its output goes to standard error.

    It takes pairs of an importable function and its argument, and returns pairs of value and error.

    Args:
        has_our_path: whether it looks for modules where this process does; otherwise, where a new interpreter
            does.
    """

    def __init__(self, *, has_our_path: bool = True) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            command = [sys.executable, "-P", "-m", "nrp_core._support.worker", str(theirs.fileno())]
            self.process = subprocess.Popen(
                command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=_STANDARD_ERROR
            )
        self.connection: Connection[Any, Any] = Connection(ours.detach())
        with suppress(OSError):  # it died at once, which is noticed when it does not answer
            self.connection.send(sys.path if has_our_path else None)

    def end(self) -> str:
        """End the process, and return how it had ended."""
        self.connection.close()
        self.process.kill()
        code = self.process.wait()
        return f"signal {-code}" if code < 0 else f"exit code {code}"
