"""A search in one call."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.experiment.model.tree import tree_of
from nrp_core.paths import path_of
from nrp_lab.evolve.evolution import Evolution, Tell, TellGeneration
from nrp_lab.evolve.history import History
from nrp_lab.evolve.reading import evolve_of, read_evolve
from nrp_lab.sweep.executors.interface import executor
from nrp_lab.sweep.python import require_workers
from nrp_lab.sweep.table import data_frame

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Evolved:
    """The outcome of a search.

    Args:
        history: all candidates with their values.
        files: the best candidate as an experiment file, or the best ones of several objectives.
        ended: why it ended before the last generation, or that its goal is not reached; empty otherwise.
    """

    history: History
    files: tuple[Path, ...]
    ended: str

    @property
    def best(self) -> dict[str, object]:
        """The settings of the best candidate."""
        return self.history.settings(self.history.best[0])

    @property
    def value(self) -> float:
        """The first objective of the best candidate."""
        return float(self.history.values[self.history.best[0], 0])

    @property
    def runs(self) -> pd.DataFrame:
        """The table of all runs.

        Raises:
            BackendLoadError: pandas is not installed.
        """
        return data_frame(self.history.rows)


@checks_arguments("description", "workers")
def evolve(
    description: str | Path | Mapping[str, Any],
    out: str | Path,
    *,
    on: str = "local",
    workers: int | None = None,
    tell: Tell = lambda _: None,
    tell_generation: TellGeneration = lambda _: None,
) -> Evolved:
    """Search for the best settings of an experiment.

    What ``nrp validate`` says about it is a Python warning before the first run.

    Args:
        description: the file of the search, or its contents.
        out: the folder of the results; a search that it holds is continued.
        on: ``local``, ``dask``, ``slurm`` or ``tcp://scheduler:8786``.
        workers: number of runs at once.
        tell: called after every run with the progress.
        tell_generation: called after every generation with all generations so far.

    Raises:
        ExperimentError: the search or the folder is not valid.
        BackendError: a requirement is not installed or cannot be reached.
    """
    require_workers(workers)
    if isinstance(description, Mapping):
        file, source = evolve_of(tree_of(description)), None
    else:
        file, source = read_evolve(path_of(description))
    made = Evolution(file, source, path_of(out))
    made.plan.tell_doubts(partial(warnings.warn, stacklevel=4))
    with executor(on, made.folder, workers) as where:
        history = made.run(where, tell, tell_generation)
    return Evolved(history, tuple(made.files), made.ended)
