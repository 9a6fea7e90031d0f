"""The interface of an executor, and that of this machine; ``nrp_core.executors`` adds others."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from pathlib import Path

from nrp_core.errors import BackendLoadError, ExperimentError, did_you_mean
from nrp_core.experiment import load_experiment
from nrp_core.registry import Registry
from nrp_core.utilities import WorkerDiedError, WorkerPool, cores
from nrp_lab.copies import Queue, may_step_together, shares
from nrp_lab.sweep.measuring import RUN_CACHE, perform_list, perform_share
from nrp_lab.sweep.record import Record, Task

ATTEMPTS = 5
"""Number of attempts of a run whose worker dies in it; after that the run itself is the likely cause."""


class Deaths:
    """Decides how to go on when workers have died.

    Args:
        most_in_vain: number of deaths before a run begins that end the sweep, if no worker lives in between.
    """

    def __init__(self, most_in_vain: int) -> None:
        self._most_in_vain, self._in_vain = most_in_vain, 0

    def workers_live(self) -> None:
        """Note that a run has ended or begun, so that workers are able to start."""
        self._in_vain = 0

    def in_run(self, task: Task, cause: str, times: int = 1) -> Task | Record:
        """Return the next attempt of a run that had begun, or its record after the last one.

        Args:
            task: the attempt, or the first of several.
            cause: how the worker ended.
            times: number of workers that died in this run.
        """
        self.workers_live()
        last = replace(task, attempt=task.attempt + times - 1)
        return last.again() if last.attempt < ATTEMPTS else Record.died(last, cause)

    def in_vain(self, cause: str) -> None:
        """Record that a worker died before a run began, so that no run caused it.

        Raises:
            BackendLoadError: all workers die before a run begins.
        """
        self._in_vain += 1
        if self._in_vain >= self._most_in_vain:
            raise BackendLoadError(f"workers die before a run begins ({cause}); finished runs are kept")


_ADDRESSES = {"tcp": "dask", "tls": "dask"}
"""Executors by the kind of address that they take."""


class Executor(AbstractContextManager["Executor"], ABC):
    """Performs runs; it is opened and closed as a context.

    Attributes:
        address: address of a running scheduler; empty: it starts one, or finds its own.
        workers: number of runs at once; None: the capacity of the machines.
        folder: the folder of the sweep, which all machines can read and write.
    """

    address: str = ""
    workers: int | None = None
    folder: Path = Path()

    @property
    @abstractmethod
    def size(self) -> int:
        """The number of runs at once, for the expected time."""

    @abstractmethod
    def perform(self, tasks: Sequence[Task]) -> Iterator[Record]:
        """Perform runs and yield their records in the order in which they end.

        A worker that dies is replaced. Its run is repeated, and has failed when it had begun on
        :data:`~nrp_lab.sweep.executor.ATTEMPTS` workers that died.

        Raises:
            BackendError: a worker has another version of the code, no worker lives until a run begins, or the
                scheduler was lost.
        """

    def __exit__(self, *_: object) -> None:
        """Release all opened resources."""


EXECUTORS: Registry[Executor] = Registry("nrp_core.executors", "executor", [Executor])


def executor(text: str, folder: Path, workers: int | None = None) -> Executor:
    """Return the executor of a name, such as ``local``, or of an address, such as ``tcp://host:8786``.

    Args:
        text: the name or the address.
        folder: the folder of the sweep.
        workers: number of runs at once; by default the capacity of the machines.

    Raises:
        ExperimentError: the executor does not exist.
        BackendError: it does not load.
    """
    kind, is_address, _ = text.partition("://")
    name = _ADDRESSES.get(kind, kind) if is_address else text
    if name not in EXECUTORS.names():
        raise ExperimentError(f"there is no executor '{name}'{did_you_mean(name, EXECUTORS.names())}")
    made = EXECUTORS.load(name)
    made.address, made.workers, made.folder = text if is_address else "", workers, folder
    return made


_STARTS = 20
"""Number of times in a row that each process may die as it starts."""


class LocalExecutor(Executor):
    """As many processes as processors or as requested; if it is one, runs are performed in this process.

    Each process steps its runs side by side if Python is not called for each of them.
    """

    def __init__(self) -> None:
        self._pool: WorkerPool | None = None

    @property
    def size(self) -> int:
        return self.workers or cores()

    def perform(self, tasks: Sequence[Task]) -> Iterator[Record]:
        if self.size == 1:
            yield from perform_share(tasks)
            return
        if self._pool is None:
            self._pool = WorkerPool(self.size)
        queue, deaths = Queue(self._shares(tasks)), Deaths(_STARTS * self.size)
        for outcome in self._pool.perform(perform_list, queue):
            share, error = outcome.task, outcome.error
            if isinstance(error, WorkerDiedError) and not error.has_begun:
                deaths.in_vain(str(error))
                queue.append(share)
            elif isinstance(error, WorkerDiedError) and len(share) > 1:  # one of them is the cause
                deaths.workers_live()
                queue.extend((task,) for task in share)
            elif isinstance(error, WorkerDiedError):
                following = deaths.in_run(share[0], str(error))
                if isinstance(following, Record):
                    yield following
                else:
                    queue.append((following,))
            elif error is not None:
                raise error
            else:
                assert outcome.value is not None
                deaths.workers_live()
                yield from outcome.value

    def _shares(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, ...]]:
        """Return what a process performs side by side; one at a time if the first task steps alone."""
        if not tasks:
            return iter(())
        first = partial(load_experiment, tasks[0].experiment, tasks[0].overrides)
        return shares(tasks, self.size) if may_step_together(first) else ((task,) for task in tasks)

    def pids(self) -> list[int]:
        """Return the operating system's numbers of the processes."""
        return [] if self._pool is None else self._pool.pids()

    def __exit__(self, *_: object) -> None:
        RUN_CACHE.close()
        if self._pool is not None:
            self._pool.__exit__()
