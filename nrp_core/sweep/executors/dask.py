"""Runs on workers of Dask, of an existing cluster or of one started on this machine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

from nrp_core._support.extras import require_extra
from nrp_core._support.machine import cores
from nrp_core.errors import BackendLoadError
from nrp_core.sweep.executors.interface import ATTEMPTS, Executor
from nrp_core.sweep.measuring import perform, require_code
from nrp_core.sweep.record import Record, Task

_AHEAD = 4
"""Runs per worker that the scheduler holds at once, so that it need not hold a million."""
_PATIENCE_S = 10


class DaskExecutor(Executor):
    """A client of a scheduler; without an address it starts workers on this machine."""

    def __init__(self) -> None:
        self._client: Any = None
        self._cluster: Any = None

    def __enter__(self) -> DaskExecutor:
        require_extra("distributed", "sweep", "the executor dask")
        from distributed import Client, LocalCluster

        if not self.address:
            self._cluster = LocalCluster(
                n_workers=self.workers or cores(), threads_per_worker=1, dashboard_address=None
            )
        try:
            self._client = Client(self._cluster or self.address, timeout=_PATIENCE_S)
        except (OSError, TimeoutError) as error:
            self.__exit__()
            message = f"there is no Dask scheduler at {self.address} ({error or type(error).__name__})"
            raise BackendLoadError(message, remedy="dask scheduler") from error
        if not self._threads():
            self.__exit__()
            message = f"the Dask scheduler at {self.address} has no workers"
            raise BackendLoadError(message, remedy=f"dask worker {self.address}")
        return self

    @property
    def size(self) -> int:
        return min(self._threads(), self.workers or self._threads())

    def perform(self, tasks: Sequence[Task]) -> Iterator[Record]:
        from distributed import CancelledError, KilledWorker, as_completed

        self._require_code(tasks[0].code if tasks else {})
        waiting, size = iter(tasks), self.size
        ahead = size if self.workers else size * _AHEAD
        given = {self._submit(task): task for task in islice(waiting, ahead)}
        done = as_completed(given)
        for future in done:
            task = given.pop(future)
            try:
                yield future.result()
            except KilledWorker as error:
                yield Record.died(task, str(error))
            except (CancelledError, OSError) as error:
                cause = str(error) or type(error).__name__
                message = f"the connection to the Dask scheduler was lost ({cause}); finished runs are kept"
                raise BackendLoadError(message) from error
            future.release()
            if (following := next(waiting, None)) is not None:
                given[another := self._submit(following)] = following
                done.add(another)

    def __exit__(self, *_: object) -> None:
        for one in (self._client, self._cluster):
            if one is not None:
                one.close()
        self._client = self._cluster = None

    def _submit(self, task: Task) -> Any:
        return self._client.submit(perform, task, key=f"{task.id}-{task.index}", pure=False)

    def _threads(self) -> int:
        return sum(self._client.nthreads().values())

    def _require_code(self, code: Mapping[str, str]) -> None:
        """Refuse workers with other code before the first run, and set the number of attempts of a run.

        Each run checks it again, so a worker that dies here is no obstacle.
        """
        for answer in self._client.run(require_code, dict(code), on_error="return").values():
            if isinstance(answer, BaseException) and not isinstance(answer, OSError):
                raise answer
        self._client.run_on_scheduler(_allow_attempts)


def _allow_attempts(dask_scheduler: Any) -> None:
    dask_scheduler.allowed_failures = ATTEMPTS - 1
