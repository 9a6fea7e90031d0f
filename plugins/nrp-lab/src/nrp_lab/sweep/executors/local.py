"""Runs in processes of this machine."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence

from nrp_core._support.machine import cores
from nrp_core._support.worker_pool import WorkerDiedError, WorkerPool
from nrp_lab.sweep.executors.deaths import Deaths
from nrp_lab.sweep.executors.interface import Executor
from nrp_lab.sweep.measuring import perform
from nrp_lab.sweep.record import Record, Task
from nrp_lab.sweep.run_cache import KEPT

_STARTS = 20
"""Number of times in a row that each process may die as it starts."""


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
        queue, deaths = _Queue(tasks), Deaths(_STARTS * self.size)
        for outcome in self._pool.perform(perform, queue):
            task, error = outcome.task, outcome.error
            if isinstance(error, WorkerDiedError) and not error.has_begun:
                deaths.in_vain(str(error))
                queue.append(task)
            elif isinstance(error, WorkerDiedError):
                following = deaths.in_run(task, str(error))
                if isinstance(following, Record):
                    yield following
                else:
                    queue.append(following)
            elif error is not None:
                raise error
            else:
                assert outcome.value is not None
                deaths.workers_live()
                yield outcome.value

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
