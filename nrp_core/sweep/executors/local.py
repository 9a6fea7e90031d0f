"""Runs in processes of this machine."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence

from nrp_core._support.machine import cores
from nrp_core._support.worker_pool import WorkerDiedError, WorkerPool
from nrp_core.sweep.executors.interface import ATTEMPTS, Executor
from nrp_core.sweep.kept import KEPT
from nrp_core.sweep.measuring import perform
from nrp_core.sweep.record import Record, Task


class LocalExecutor(Executor):
    """As many processes as processors or as requested; if it is one, runs are performed in this process."""

    def __init__(self) -> None:
        self._pool: WorkerPool | None = None

    @property
    def size(self) -> int:
        return self.workers or cores()

    def perform(self, tasks: Sequence[Task]) -> Iterator[Record]:
        if self.size == 1:
            yield from map(perform, tasks)
            return
        if self._pool is None:
            self._pool = WorkerPool(self.size)
        queue = _Queue(tasks)
        for outcome in self._pool.perform(perform, queue):
            if not isinstance(outcome.error, WorkerDiedError):
                if outcome.error is not None:
                    raise outcome.error
                assert outcome.value is not None
                yield outcome.value
            elif outcome.task.attempt < ATTEMPTS:
                queue.append(outcome.task.again())
            else:
                yield Record.died(outcome.task, str(outcome.error))

    def pids(self) -> list[int]:
        """Return the operating system's numbers of the processes."""
        return [] if self._pool is None else self._pool.pids()

    def __exit__(self, *_: object) -> None:
        KEPT.close()
        if self._pool is not None:
            self._pool.__exit__()


class _Queue(deque[Task]):
    """An iterator over tasks, to which tasks may be added even after it was exhausted."""

    def __iter__(self) -> Iterator[Task]:
        return self

    def __next__(self) -> Task:
        if not self:
            raise StopIteration
        return self.popleft()
