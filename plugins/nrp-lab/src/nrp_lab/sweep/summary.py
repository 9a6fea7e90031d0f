"""Summarize a sweep: one line for the runs of each combination of values, over all seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_lab.sweep.folder import read_about
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.table import CSV, Row


@dataclass(frozen=True, slots=True)
class Group:
    """The runs of one combination.

    Args:
        values: the values, without the seed and the settings drawn with it.
        rows: its runs.
    """

    values: Mapping[str, Any]
    rows: tuple[Row, ...]

    def numbers(self, name: str) -> list[float]:
        """Return the values of a measure in the runs that have it."""
        return [float(row[name]) for row in self.rows if row.get(name) is not None]

    def mean(self, name: str) -> float:
        """Return the mean of a measure; NaN if no run has it."""
        found = self.numbers(name)
        return float(np.mean(found)) if found else float("nan")

    def spread(self, name: str) -> float:
        """Return the standard deviation of a measure between seeds; 0 for one run."""
        found = self.numbers(name)
        return float(np.std(found, ddof=1)) if len(found) > 1 else 0.0

    def error(self, name: str) -> float:
        """Return the standard error of the mean."""
        return self.spread(name) / sqrt(max(len(self.numbers(name)), 1))


@dataclass(frozen=True, slots=True)
class SweepTable:
    """The finished runs of a sweep.

    Args:
        name: name of the experiment.
        keys: the varying settings that the design combines.
        measures: names of the measured numbers.
        rows: the runs.
        source: the experiment, by which it can be read again.
        settings: the overrides of every run.
    """

    name: str
    keys: tuple[str, ...]
    measures: tuple[str, ...]
    rows: tuple[Row, ...]
    source: str = ""
    settings: tuple[str, ...] = ()

    @classmethod
    def of(cls, plan: Plan, rows: Sequence[Row]) -> SweepTable:
        """Return the table of a plan."""
        settings = tuple(plan.identity["settings"].values())
        measures = _measures(rows, plan.sweep.measure)
        return cls(plan.name, tuple(plan.sweep.sampled), measures, tuple(rows), plan.experiment, settings)

    @property
    def groups(self) -> list[Group]:
        """The runs by their combination, in the order of the table."""
        found: dict[tuple[str, ...], list[Row]] = {}
        for row in self.rows:
            found.setdefault(tuple(str(row[key]) for key in self.keys), []).append(row)
        return [Group({key: rows[0][key] for key in self.keys}, tuple(rows)) for rows in found.values()]

    def measure(self, name: str | None) -> str:
        """Return the full name of a measure, by default the first.

        Raises:
            ExperimentError: it was not measured, or nothing was.
        """
        if name is None and self.measures:
            return self.measures[0]
        if name not in self.measures:
            wanted = name or "a measure"
            raise ExperimentError(f"'{wanted}' was not measured{did_you_mean(wanted, self.measures)}")
        return name


def short_key(key: str, keys: Sequence[str]) -> str:
    """Return the shortest end of a dotted key that distinguishes it from the others."""
    parts = key.split(".")
    names = (".".join(parts[-length:]) for length in range(1, len(parts)))
    others = [other for other in keys if other != key]
    return next((name for name in names if not any(one.endswith(f".{name}") for one in others)), key)


def _measures(rows: Sequence[Row], metrics: Sequence[str]) -> tuple[str, ...]:
    columns = list(rows[0]) if rows else []
    return tuple(name for name in columns if name.partition(".")[0] in metrics and "." in name)


def read_table(folder: Path) -> SweepTable:
    """Return the table of a folder, from its journals.

    Raises:
        ExperimentError: the folder does not contain a sweep, or no run has ended.
    """
    import csv

    about = read_about(folder)
    path = folder / CSV
    if not path.is_file():
        raise ExperimentError("no run has ended yet", path=folder)
    with path.open(encoding="utf-8", newline="") as file:
        rows = [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]
    identity = about["identity"]
    return SweepTable(
        identity["experiment"], tuple(about["keys"]), _measures(rows, identity["measure"]), tuple(rows),
        about["source"], tuple(identity["settings"].values()),
    )  # fmt: skip


def _value(text: str) -> Any:
    """Return a cell as a number, a Boolean or a string; None if it is empty."""
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    try:
        return float(text) if not text.lstrip("-").isdecimal() else int(text)
    except ValueError:
        return text
