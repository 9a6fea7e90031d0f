"""Search: ask the optimiser for a generation, run it, and tell it the values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.model.tree import Tree
from nrp_core.seeds import Seeds
from nrp_lab.evolve.best import write_best
from nrp_lab.evolve.history import History
from nrp_lab.evolve.model import EvolveFile
from nrp_lab.evolve.objective import Objective
from nrp_lab.evolve.optimisers.interface import Space, optimiser
from nrp_lab.sweep.executors.interface import Executor
from nrp_lab.sweep.mistakes import Mistakes
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.record import INVALID
from nrp_lab.sweep.running import Progress, SweepRun

Tell = Callable[[Progress], None]
TellGeneration = Callable[[History], None]


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
        self.name, self.keys, self.remarks, self.ended = plan.name, keys, plan.remarks, ""
        self.files: list[Path] = []

    @property
    def plan(self) -> Plan:
        """All runs so far."""
        return self._made.plan

    @property
    def runs(self) -> int:
        """The largest number of runs."""
        return self.file.generations * self.file.population * self.file.seeds

    def run(
        self,
        executor: Executor,
        tell: Tell = lambda _: None,
        tell_generation: TellGeneration = lambda _: None,
    ) -> History:
        """Search to the end and write the best candidates as experiments.

        Args:
            executor: the open executor.
            tell: called after every run.
            tell_generation: called after every generation.

        Raises:
            ExperimentError: the objective needs a measure that does not exist, or no run succeeds.
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        shares: list[list[float]] = []
        for _ in range(self.file.generations):
            shares += self._optimiser.ask().tolist()
            self._made.extend(self.plan.with_points(shares))
            self._run_generation(executor, tell)
            history = self._history()
            latest = history.values[-self.file.population :]
            self._require_one(latest)
            history.write(self.folder)
            self.files = write_best(self._made, history)
            self._optimiser.tell(latest)
            tell_generation(history)
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
        """Return that all of several candidates have one value, so that there was nothing to go by."""
        values = history.values[np.isfinite(history.values).all(axis=1)]
        if len(values) < 2 or np.ptp(values, axis=0).any():
            return ""
        shown = ", ".join(f"{value:.5g}" for value in values[0])
        return f"all {len(values)} candidates have the value {shown}: nothing that was searched changes it"

    def _run_generation(self, executor: Executor, tell: Tell) -> None:
        pending = self._made.pending
        if pending and not self._made.records:  # a mistake costs one run, not a generation
            self._made.run(executor, tasks=pending[:1])
            (row,) = self._made.rows
            if row["state"] == INVALID:
                raise ExperimentError(f"the first run cannot begin: {row['error']}")
            self._objective.values([row], 1)
        self._made.run(executor, lambda progress: tell(replace(progress, total=self.runs)))

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
        InvalidExperimentError: there is one; the error carries all of them.
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
