"""The generations of a search, derived from the rows of its runs: objectives, best candidates, figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nrp_core.brain import FloatArray
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.figures import check_target, save
from nrp_core.recording.figures.style import DPI, FAINT, colour, style
from nrp_lab.sweep.table import Row, read_about, read_table, write_rows

CRITERIA = "criteria"


@dataclass(frozen=True)
class Objective:
    """One or several weighted sums of measures; larger is better.

    Args:
        sums: weights by measure, ``metric.part``.
        missing: values of measures that a run does not have; an undecided criterion counts as not met.
        over_seeds: how the values of a candidate's runs become one.
    """

    sums: tuple[dict[str, float], ...]
    missing: dict[str, float] = field(default_factory=dict)
    over_seeds: Literal["mean", "worst"] = "mean"

    def values(self, rows: Sequence[Row], seeds: int) -> FloatArray:
        """Return the values of candidates.

        Args:
            rows: their runs, those of a candidate in a row.
            seeds: number of runs of a candidate.

        Returns:
            shape ``(candidates, objectives)``; NaN for a candidate with a run that failed.

        Raises:
            ExperimentError: a measure does not exist, or a run has no value of it.
        """
        runs = np.array([[self._value(row, one) for one in self.sums] for row in rows])
        by_seed = runs.reshape(-1, seeds, len(self.sums))
        values: FloatArray = by_seed.mean(axis=1) if self.over_seeds == "mean" else by_seed.min(axis=1)
        return values

    def _value(self, row: Row, weights: dict[str, float]) -> float:
        if row["error"] is not None:
            return float("nan")
        return sum(weight * self._measured(row, name) for name, weight in weights.items())

    def _measured(self, row: Row, name: str) -> float:
        if name not in row:
            known = [key for key in row if key.partition(".")[0] == name.partition(".")[0] and "." in key]
            raise ExperimentError(f"objective: '{name}' was not measured{did_you_mean(name, known)}")
        if row[name] is not None:
            return float(row[name])
        if name in self.missing:
            return self.missing[name]
        if name.partition(".")[0] == CRITERIA:
            return 0.0
        raise ExperimentError(
            f"objective: run {row['run']} has no value of '{name}'; "
            f"say which value it then has, as in 'missing: {{{name}: 0}}'"
        )


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
        places = np.ndindex(course["best"].shape)
        write_rows(folder / CSV, [
            {
                "generation": place[0],
                "objective": place[1],
                **{name: f"{values[place]:.9g}" for name, values in course.items()},
            }
            for place in places
        ])  # fmt: skip


_SIZE = (7.2, 4.2)


def draw(history: History, path: Path) -> None:
    """Draw a search into a file; the suffix chooses between PNG, SVG and PDF.

    Raises:
        ExperimentError: the file cannot be written.
    """
    check_target(path, overwrite=True)
    with style():
        figure = Figure(_SIZE, dpi=DPI, layout="constrained")
        axes = figure.subplots()
        if history.values.shape[1] == 1:
            _course(axes, history)
        else:
            _front(axes, history)
        names = axes.get_legend_handles_labels()
        figure.legend(*names, loc="outside lower center", ncols=3)  # where it covers nothing
        figure.suptitle(f"{history.name}: {len(history)} generations of {history.population} candidates")
        save(figure, path)


def _course(axes: Axes, history: History) -> None:
    """Draw all candidates, the mean with one standard deviation, and the best so far."""
    values = history.generations[:, :, 0]
    generations = np.arange(len(values))
    course = {name: numbers[:, 0] for name, numbers in history.course.items()}
    mean, sd = course["mean"], course["sd"]
    every = np.repeat(generations, values.shape[1])
    axes.plot(every, values.ravel(), ".", color=FAINT, markersize=3, label="candidates")
    axes.fill_between(generations, mean - sd, mean + sd, color=colour(0), alpha=0.15, linewidth=0)
    axes.plot(generations, mean, color=colour(0), linewidth=1.2, label="mean ± sd")
    axes.step(
        generations, course["best_so_far"], where="post", color=colour(1), linewidth=1.6, label="best so far"
    )
    axes.set(xlabel="generation", ylabel="objective")
    axes.grid(axis="y")


def _front(axes: Axes, history: History) -> None:
    """Draw the first two objectives of all candidates, and the front."""
    x, y = history.values[:, 0], history.values[:, 1]
    front = history.best
    axes.plot(x, y, ".", color=FAINT, markersize=3, label="candidates")
    axes.plot(x[front], y[front], "o-", color=colour(1), markersize=4, linewidth=1.2, label="best")
    axes.set(xlabel="objective 1", ylabel="objective 2")
    axes.grid()
