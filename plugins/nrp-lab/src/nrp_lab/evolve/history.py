"""The generations of a search so far, derived from the rows of its runs."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError
from nrp_lab.evolve.objective import Objective
from nrp_lab.sweep.folder import read_about
from nrp_lab.sweep.summary import read_table
from nrp_lab.sweep.table import Row

CSV = "generations.csv"


@dataclass(frozen=True)
class History:
    """All candidates of the complete generations.

    Args:
        name: name of the experiment.
        keys: the searched settings.
        population: number of candidates in a generation.
        seeds: number of runs of a candidate.
        values: their values, shape ``(candidates, objectives)``; larger is better, NaN: a run failed.
        rows: their runs, those of a candidate in a row.
    """

    name: str
    keys: tuple[str, ...]
    population: int
    seeds: int
    values: FloatArray
    rows: tuple[Row, ...]

    @classmethod
    def of(
        cls, name: str, keys: Sequence[str], population: int, seeds: int, rows: Sequence[Row], goal: Objective
    ) -> History:
        """Return the history of rows in the order of their runs."""
        whole = len(rows) // (population * seeds) * population * seeds
        complete = tuple(rows[:whole])
        return cls(name, tuple(keys), population, seeds, goal.values(complete, seeds), complete)

    @classmethod
    def read(cls, folder: Path) -> History:
        """Return the history of a folder.

        Raises:
            ExperimentError: it does not contain a search, or no generation is complete.
        """
        identity = read_about(folder)["identity"]
        search = identity.get("search")
        if not search:
            raise ExperimentError("the folder contains a sweep, not a search", path=folder)
        table = read_table(folder)
        objective = Objective(tuple(search["objective"]), search["missing"], search["over_seeds"])
        history = cls.of(table.name, table.keys, search["population"], search["seeds"], table.rows, objective)
        if not len(history):
            raise ExperimentError("no generation is complete yet", path=folder)
        return history

    def __len__(self) -> int:
        return len(self.values) // self.population

    @property
    def generations(self) -> FloatArray:
        """The values by generation, shape ``(generations, population, objectives)``."""
        return self.values.reshape(len(self), self.population, -1)

    @property
    def best(self) -> list[int]:
        """The best candidate; with several objectives those that no other one surpasses in all of them.

        They are in the order of the first objective; of equal ones only the first counts.
        """
        known = np.flatnonzero(np.isfinite(self.values).all(axis=1))
        front: list[int] = []
        for one in known:
            others = self.values[known]
            as_good = (others >= self.values[one]).all(axis=1)
            better = as_good & (others > self.values[one]).any(axis=1)
            if not better.any() and not (as_good & (known < one)).any():
                front.append(int(one))
        return sorted(front, key=lambda one: -self.values[one, 0])

    def settings(self, candidate: int) -> dict[str, object]:
        """Return the values of the searched settings of a candidate."""
        return {key: self.rows[candidate * self.seeds][key] for key in self.keys}

    @property
    def course(self) -> dict[str, FloatArray]:
        """Statistics of each generation, shape ``(generations, objectives)``; NaN if all failed."""
        known = np.ma.masked_invalid(self.generations)
        best = known.max(axis=1).filled(np.nan)
        return {
            "best": best,
            "mean": known.mean(axis=1).filled(np.nan),
            "sd": known.std(axis=1).filled(np.nan),
            "failed": known.mask.sum(axis=1) if np.ma.is_masked(known) else np.zeros(best.shape),
            "best_so_far": np.fmax.accumulate(best),
        }

    def write(self, folder: Path) -> None:
        """Write a row for each generation and objective."""
        course = self.course
        with writing(folder / CSV), (folder / CSV).open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["generation", "objective", *course])
            for place in np.ndindex(course["best"].shape):
                writer.writerow([*place, *(f"{values[place]:.9g}" for values in course.values())])
