"""The values of candidates, from the rows of their runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_lab.sweep.table import Row

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
