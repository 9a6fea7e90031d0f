"""Search by generations: the optimiser proposes candidates, a sweep runs them, the objective rates them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML

from nrp_core.brain import FloatArray
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Tree, load_experiment, tree_of
from nrp_core.paths import path_of
from nrp_core.seeds import Seeds
from nrp_core.utilities import checks_arguments, writing
from nrp_lab.evolve.history import History, Objective
from nrp_lab.evolve.model import EvolveFile, evolve_of, read_evolve
from nrp_lab.evolve.optimisers import Space, optimiser
from nrp_lab.sweep.executor import Executor, executor
from nrp_lab.sweep.plan import Mistakes, Plan, PlannedRun
from nrp_lab.sweep.record import INVALID
from nrp_lab.sweep.running import Progress, SweepRun, require_workers
from nrp_lab.sweep.table import data_frame

if TYPE_CHECKING:
    import pandas as pd

BEST = "best"


def write_best(made: SweepRun, history: History) -> list[Path]:
    """Write ``best.yaml``, or with several objectives ``best_1.yaml`` and so on; return the files.

    Raises:
        ExperimentError: a file cannot be written.
    """
    best, several = history.best, history.values.shape[1] > 1
    files = []
    for place, candidate in enumerate(best, 1):
        file = made.folder / (f"{BEST}_{place}.yaml" if several else f"{BEST}.yaml")
        run = made.plan.runs[candidate * history.seeds]
        with writing(file):
            file.write_text(_header(history, candidate) + _text(made.plan, run, made.folder), "utf-8")
        files.append(file)
    for path in made.folder.glob(f"{BEST}_*.yaml"):  # of an earlier, longer front
        if path not in files:
            path.unlink()
    return files


def _header(history: History, candidate: int) -> str:
    values = ", ".join(f"{value:.6g}" for value in history.values[candidate])
    number = f"candidate {candidate % history.population} of generation {candidate // history.population}"
    return f"# Written by nrp evolve: {number}. Objective: {values}, over {history.seeds} seeds.\n"


def _text(plan: Plan, run: PlannedRun, folder: Path) -> str:
    shipped = not Path(plan.experiment).is_absolute()
    above = plan.experiment if shipped else os.path.relpath(plan.experiment, folder.resolve())
    content: dict[str, Any] = {"extends": above}
    tree = load_experiment(run.task.experiment, run.task.overrides).source
    for key in (*plan.sweep.settings, *plan.sweep.sampled):  # but not those drawn with the seed
        _set(content, tree, key.split("."))
    written = StringIO()
    yaml = YAML()
    yaml.dump(content, written)
    return written.getvalue()


def _set(content: dict[str, Any], tree: Tree, keys: list[str]) -> None:
    """Copy the value under keys; a list is copied as a whole, because files replace lists."""
    key, *rest = keys
    below = tree.value[key]
    if rest and isinstance(below.value, Mapping):
        _set(content.setdefault(key, {}), below, rest)
    else:
        content[key] = _plain(below)


def _plain(tree: Tree) -> Any:
    if isinstance(tree.value, dict):
        return {key: _plain(child) for key, child in tree.value.items()}
    return [_plain(child) for child in tree.value] if isinstance(tree.value, list) else tree.value


OnProgress = Callable[[Progress], None]
OnGeneration = Callable[[History], None]


class Evolution:
    """A search in its folder.

    A search that was stopped is repeated from its beginning. Since the optimiser gives the same candidates
    again, and the journal has their runs, this takes no time, and the sequence is that of an uninterrupted
    search.

    Args:
        file: the search.
        source: its file, for the places of errors.
        folder: its folder; created, or reused if it contains the same search.

    Raises:
        ExperimentError: the file or the folder is not valid.
    """

    def __init__(self, file: EvolveFile, source: Tree | None, folder: Path) -> None:
        plan = replace(Plan.of(file.as_sweep(), source), search=file.search)
        _require_measured(file, plan, source or Tree({}))
        self.file, self.folder = file, folder
        self._made = SweepRun(plan.with_points(()), folder)
        self._objective = Objective(file.objective, dict(file.missing), file.over_seeds)
        keys, seeds = tuple(plan.sweep.sampled), Seeds(file.optimiser_seed).child("evolve")
        space = Space(keys, len(file.objective), file.population, seeds, folder)
        self._optimiser = optimiser(file.optimiser, space)
        self.name, self.keys, self.ended = plan.name, keys, ""
        self.files: list[Path] = []

    @property
    def plan(self) -> Plan:
        """All runs so far."""
        return self._made.plan

    @property
    def news(self) -> str:
        """A sentence on the changes that make earlier runs outdated; empty if none do."""
        return self._made.news

    @property
    def runs(self) -> int:
        """The largest number of runs."""
        return self.file.generations * self.file.population * self.file.seeds

    def run(
        self,
        executor: Executor,
        on_progress: OnProgress = lambda _: None,
        on_generation: OnGeneration = lambda _: None,
    ) -> History:
        """Search to the end and write the best candidates as experiments.

        Args:
            executor: the open executor.
            on_progress: called after every run.
            on_generation: called after every generation.

        Raises:
            ExperimentError: the objective needs a measure that does not exist, or no run succeeds.
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        shares: list[list[float]] = []
        for _ in range(self.file.generations):
            shares += self._optimiser.ask().tolist()
            self._made.extend(self.plan.with_points(shares))
            self._run_generation(executor, on_progress)
            history = self._history()
            latest = history.values[-self.file.population :]
            self._require_one(latest)
            history.write(self.folder)
            self.files = write_best(self._made, history)
            self._optimiser.tell(latest)
            on_generation(history)
            if reason := self._reason_to_end(latest):
                self.ended = self._nothing_found(history) or reason
                return history
        self.ended = self._nothing_found(history)
        if not self.ended and self.file.goal is not None:
            self.ended = (
                f"the goal {self.file.goal:g} is not reached; the best is {np.nanmax(history.values):.5g}"
            )
        return history

    @staticmethod
    def _nothing_found(history: History) -> str:
        """Return a sentence if all of several candidates have one value, which gives no direction."""
        values = history.values[np.isfinite(history.values).all(axis=1)]
        if len(values) < 2 or np.ptp(values, axis=0).any():
            return ""
        shown = ", ".join(f"{value:.5g}" for value in values[0])
        return f"all {len(values)} candidates have the value {shown}: nothing that was searched changes it"

    def _run_generation(self, executor: Executor, on_progress: OnProgress) -> None:
        pending = self._made.pending
        if pending and not self._made.records:  # a mistake costs one run, not a generation
            self._made.run(executor, tasks=pending[:1])
            (row,) = self._made.rows
            if row["state"] == INVALID:
                raise ExperimentError(f"the first run cannot begin: {row['error']}")
            self._objective.values([row], 1)
        self._made.run(executor, lambda progress: on_progress(replace(progress, total=self.runs)))

    def _history(self) -> History:
        return History.of(
            self.name, self.keys, self.file.population, self.file.seeds, self._made.rows, self._objective
        )

    def _require_one(self, values: FloatArray) -> None:
        if not np.isfinite(values).all(axis=1).any():
            errors = [str(row["error"]) for row in self._made.rows if row["error"] is not None]
            raise ExperimentError(f"all candidates of a generation failed; the last error: {errors[-1]}")

    def _reason_to_end(self, latest: FloatArray) -> str:
        if self.file.goal is not None and np.nanmax(latest) >= self.file.goal:
            return f"the goal {self.file.goal:g} is reached"
        if reason := self._optimiser.finished:
            return f"the search has converged ({reason})"
        return ""


def _require_measured(file: EvolveFile, plan: Plan, source: Tree) -> None:
    """Refuse an objective that no run will have, before the first run.

    Raises:
        InvalidExperimentError: one was found; the error carries all of them.
    """
    mistakes = Mistakes(source)
    for place, weights in enumerate(file.objective):
        for name in weights:
            known = plan.parts[name.partition(".")[0]]
            with mistakes.at("objective", place, name):
                if known is not None and name not in known:
                    raise ExperimentError(f"objective: '{name}' is not measured{did_you_mean(name, known)}")
    for name in file.missing:
        with mistakes.at("missing", name):
            if name not in file.names:
                raise ExperimentError(
                    f"missing: '{name}' is not in the objective{did_you_mean(name, file.names)}"
                )
    mistakes.raise_errors()


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
    on_progress: OnProgress = lambda _: None,
    on_generation: OnGeneration = lambda _: None,
) -> Evolved:
    """Search for the best settings of an experiment.

    The findings of ``nrp validate`` about it are a Python warning before the first run.

    Args:
        description: the file of the search, or its contents.
        out: the folder of the results; a search that it holds is continued.
        on: ``local``, ``dask``, ``slurm`` or ``tcp://scheduler:8786``.
        workers: number of runs at once.
        on_progress: called after every run with the progress.
        on_generation: called after every generation with all generations so far.

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
    if made.news:
        warnings.warn(made.news, stacklevel=4)
    made.plan.report_warnings(partial(warnings.warn, stacklevel=4))
    with executor(on, made.folder, workers) as where:
        history = made.run(where, on_progress, on_generation)
    return Evolved(history, tuple(made.files), made.ended)
