"""The interface of an executor. Other packages add theirs by an entry point in ``nrp_core.executors``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.registry import Registry
from nrp_lab.sweep.record import Record, Task

_ADDRESSES = {"tcp": "dask", "tls": "dask"}
"""Executors by the kind of address that they take."""


class Executor(AbstractContextManager["Executor"], ABC):
    """Performs runs; it is opened and closed as a context.

    Attributes:
        address: address of a running scheduler; empty: it starts one, or finds its own.
        workers: number of runs at once; None: as many as the machines have room for.
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
        :data:`~nrp_lab.sweep.executors.deaths.ATTEMPTS` workers that died.

        Raises:
            BackendError: a worker has another version of the code, no worker lives until a run begins, or the
                scheduler was lost.
        """

    def __exit__(self, *_: object) -> None:
        """Release what was opened."""


EXECUTORS: Registry[Executor] = Registry("nrp_core.executors", "executor", [Executor])


def executor(text: str, folder: Path, workers: int | None = None) -> Executor:
    """Return the executor of a name, such as ``local``, or of an address, such as ``tcp://host:8786``.

    Args:
        text: the name or the address.
        folder: the folder of the sweep.
        workers: number of runs at once; by default as many as the machines have room for.

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
