"""Runs on workers of Dask, of an existing cluster or of one started on this machine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from itertools import count, islice
from typing import Any

from nrp_core.errors import BackendLoadError
from nrp_core.utilities import cores, require_extra
from nrp_lab.sweep.executor import ATTEMPTS, Deaths, Executor
from nrp_lab.sweep.measuring import perform, require_code
from nrp_lab.sweep.record import Record, Task

_TASKS_PER_WORKER = 4
"""Runs per worker that the scheduler holds at once, so that it need not hold a million."""
_TIMEOUT_S = 10
_LONG_S = 100_000_000
_STARTS = 20
"""Number of times in a row that each worker may take runs and die before one begins."""


class DaskExecutor(Executor):
    """A client of a scheduler; without an address it starts workers on this machine."""

    def __init__(self) -> None:
        self._client: Any = None
        self._cluster: Any = None
        self._settings: Any = nullcontext()
        self._begun = Counter[str]()
        self._numbers = count()

    def __enter__(self) -> DaskExecutor:
        require_extra("distributed", "nrp-lab[sweep]", "the executor dask")
        from distributed import Client, LocalCluster

        if not self.address:
            self._settings = _settings()
            self._cluster = LocalCluster(
                n_workers=self.workers or cores(), threads_per_worker=1, dashboard_address="127.0.0.1:0"
            )
        try:
            self._client = Client(self._cluster or self.address, timeout=_TIMEOUT_S)
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
        self._client.subscribe_topic(self._topic, self._note_begun)
        waiting, size = iter(tasks), self.size
        deaths = Deaths(_STARTS * size)
        ahead = size if self.workers else size * _TASKS_PER_WORKER
        given = {self._submit(task): task for task in islice(waiting, ahead)}
        done = as_completed(given)
        for future in done:
            task = given.pop(future)
            times = self._begun.pop(task.id, 0)
            try:
                following = replace(future.result(), attempts=task.attempt + max(times, 1) - 1)
                deaths.workers_live()
            except KilledWorker as error:
                following = _after_deaths(deaths, task, times, str(error))
            except (CancelledError, OSError) as error:
                cause = str(error) or type(error).__name__
                message = f"the connection to the Dask scheduler was lost ({cause}); finished runs are kept"
                raise BackendLoadError(message) from error
            future.release()
            if isinstance(following, Record):
                yield following
                following = next(waiting, None)
            if following is not None:
                given[another := self._submit(following)] = following
                done.add(another)

    def __exit__(self, *_: object) -> None:
        for one in (self._client, self._cluster):
            if one is not None:
                one.close()
        self._client = self._cluster = None
        self._settings.__exit__(None, None, None)
        self._settings = nullcontext()

    def _submit(self, task: Task) -> Any:
        key = f"{task.id}-{next(self._numbers)}"  # of its own each time, because Dask counts deaths by it
        return self._client.submit(_announced, task, self._topic, key=key, pure=False)

    @property
    def _topic(self) -> str:
        return f"nrp-runs-of-{self._client.id}"  # events of the scheduler itself have the name of the client

    def _note_begun(self, event: tuple[float, str]) -> None:
        self._begun[event[1]] += 1

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


def _settings() -> Any:
    """Return a context, already entered, with the settings of a cluster of this machine.

    It keeps its workers: otherwise it removes one that is just starting 15 s after an earlier death, and
    never replaces it. It does not watch its processes: profiling them and polling the interpreter's lock a
    thousand times a second took a tenth of the time of runs, and its result is not used.
    Its processes do not import modules of the working directory instead of Python's.
    """
    from dask import config

    return config.set(
        {
            "distributed.deploy.lost-worker-timeout": _LONG_S,
            "distributed.worker.profile.enabled": False,
            "distributed.admin.system-monitor.gil.enabled": False,
            "distributed.admin.tick.interval": "500ms",
            "distributed.nanny.pre-spawn-environ.PYTHONSAFEPATH": "1",
        }
    )


def _after_deaths(deaths: Deaths, task: Task, times: int, cause: str) -> Task | Record:
    """Return the next attempt of a run, or its record.

    Dask gives a run up when several workers that held it have died, even if they never began it.
    """
    if times:
        return deaths.in_run(task, cause, times)
    deaths.in_vain(cause)
    return task


def _announced(task: Task, topic: str) -> Record:
    """Perform a run after notifying the scheduler, and so the client, even if it then fails."""
    from distributed import get_worker
    from distributed.utils import sync

    worker = get_worker()
    with suppress(OSError):  # no reason not to perform it
        sync(worker.loop, worker.scheduler.log_event, topic=topic, msg=task.id)  # it waits
    return perform(task)


def _allow_attempts(dask_scheduler: Any) -> None:
    dask_scheduler.allowed_failures = ATTEMPTS - 1
