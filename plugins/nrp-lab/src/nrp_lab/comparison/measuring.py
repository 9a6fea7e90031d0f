"""Apply metrics to all runs and compare the backends, or the wirings, seed by seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from math import sqrt
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_lab.comparison.grid import Condition, GridCell, RunGrid
from nrp_lab.comparison.judgement import (
    ConditionValues,
    Contrast,
    Estimate,
    Factor,
    JudgedPart,
    Judgement,
    corrected,
    excess_of_shift,
    excess_values,
    pooled_sd,
    shift_of_excess,
)
from nrp_lab.comparison.metric import DistanceMetric, Margin, Margins, Metric, ScalarMetric
from nrp_lab.comparison.signals import RunSignals

Runs = Mapping[GridCell, RunSignals]

_FEWEST_SEEDS = 3
"""The spread of distances needs three seeds."""


def judge(grid: RunGrid, runs: Runs, metrics: Sequence[Metric], margins: Margins) -> list[Judgement]:
    """Measure everything and judge the dependence of each metric.

    A failed run is used only for the finding, because its end is arbitrary.

    Raises:
        ExperimentError: a margin was set for a part that no run has.
    """
    whole = {cell: run for cell, run in runs.items() if not run.failed}
    judged = [
        Judgement(metric, tuple(_parts(grid, runs if metric.is_finding else whole, metric, margins)))
        for metric in metrics
        if metric.is_compared
    ]
    margins.require_parts(f"{j.metric.name}/{part.name}" for j in judged for part in j.parts)
    return corrected(judged)


def _parts(grid: RunGrid, runs: Runs, metric: Metric, margins: Margins) -> list[JudgedPart]:
    resolution = max((metric.resolution(run) for run in runs.values()), default=0.0)
    if isinstance(metric, ScalarMetric):
        return _judge_values(grid, runs, metric, margins, resolution)
    assert isinstance(metric, DistanceMetric)
    return _judge_distances(grid, runs, metric, margins, resolution)


# -- numbers


def _judge_values(
    grid: RunGrid, runs: Runs, metric: ScalarMetric, margins: Margins, resolution: float
) -> list[JudgedPart]:
    measured = {cell: metric.values(runs[cell]) for cell in grid.cells if cell in runs}
    return parts_of_numbers(grid, metric, measured, margins, resolution)


def parts_of_numbers(
    grid: RunGrid, metric: ScalarMetric, measured: Mapping[GridCell, Mapping[str, float | None]],
    margins: Margins, resolution: float,
) -> list[JudgedPart]:  # fmt: skip
    """Compare the values of a metric.

    Args:
        grid: the grid.
        metric: the metric.
        measured: its values by part, of each run that has some.
        margins: the margins.
        resolution: the smallest difference that the metric can resolve in these runs.

    Returns:
        Its parts, not yet corrected for their number.
    """
    nothing: Mapping[str, float | None] = {}
    measured = {cell: measured.get(cell, nothing) for cell in grid.cells}
    tables = {
        name: np.array([
            _number(measured[condition.cell(seed)].get(name))
            for condition in grid.conditions
            for seed in grid.seeds
        ]).reshape(len(grid.brains), len(grid.worlds), len(grid.variants), len(grid.seeds))
        for name in dict.fromkeys(name for values in measured.values() for name in values)
    }  # fmt: skip
    return [
        _judge_value_table(
            grid, metric, name, table, margins.of(metric, name), resolution,
            _cells(grid, {cell: values.get(name) for cell, values in measured.items()}),
        )
        for name, table in tables.items()
    ]  # fmt: skip


def _judge_value_table(
    grid: RunGrid, metric: ScalarMetric, name: str, table: FloatArray, margin: Margin, resolution: float,
    cells: tuple[ConditionValues, ...],
) -> JudgedPart:  # fmt: skip
    sd = _spread(table, is_share=metric.is_share)
    estimated = Estimate.from_matched_shares if metric.is_share else Estimate.of
    differences = list(_differences(grid, table))
    contrasts = []
    for factor, one, other, values in differences:
        if len(values):
            estimate = estimated(values)
            effect = _ratio(estimate.mean, sd)
            contrasts.append(Contrast(factor, one, other, estimate, effect, estimate.p_different))
    reach, n_seeds = max(margin.within(sd), resolution), min(len(values) for *_, values in differences)
    varies = _spread(table) > resolution
    return JudgedPart(name, reach, margin.in_sd, resolution, sd, varies, n_seeds, tuple(contrasts), cells)


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _cells(grid: RunGrid, values: Mapping[GridCell, float | None]) -> tuple[ConditionValues, ...]:
    """Return the values of each condition in the order of the seeds, without missing ones."""
    return tuple(
        ConditionValues(
            *condition,
            [float(value) for seed in grid.seeds if (value := values[condition.cell(seed)]) is not None],
        )
        for condition in grid.conditions
    )


def _mean_of_seeds(values: FloatArray) -> FloatArray:
    """Return the mean for each seed, the last axis, without missing values and seeds."""
    values = values.reshape(-1, values.shape[-1])
    present = np.isfinite(values)
    counts = present.sum(axis=0)
    means: FloatArray = np.where(present, values, 0.0).sum(axis=0)[counts > 0] / counts[counts > 0]
    return means


def _spread(table: FloatArray, *, is_share: bool = False) -> float:
    """Return the standard deviation from seed to seed, pooled over the conditions.

    For yes and no it follows from their share, with two of each added (Agresti and Coull 1998, Am. Stat.
    52:119): the agreement of a few runs does not mean that every run would agree.
    """
    if is_share:
        share = (np.nansum(table) + 2) / (np.isfinite(table).sum() + 4)
        return float(sqrt(share * (1 - share)))
    cells = [values[np.isfinite(values)] for values in table.reshape(-1, table.shape[-1])]
    return pooled_sd([float(values.std(ddof=1)) for values in cells if len(values) > 1])


def _differences(grid: RunGrid, table: FloatArray) -> Iterator[tuple[Factor, str, str, FloatArray]]:
    """Return every contrast with its value for each seed that has one."""
    brains, worlds = list(enumerate(grid.brains)), list(enumerate(grid.worlds))
    for (i, one), (j, other) in combinations(brains, 2):
        yield Factor.BRAIN, one, other, _mean_of_seeds(table[j] - table[i])
    for (k, one), (m, other) in combinations(worlds, 2):
        yield Factor.WORLD, one, other, _mean_of_seeds(table[:, m] - table[:, k])
    for (i, one), (j, other) in combinations(brains, 2):
        for (k, here), (m, there) in combinations(worlds, 2):
            moved = (table[j, m] - table[i, m] - table[j, k] + table[i, k]) / 2
            yield Factor.BOTH, f"{one} to {other} in {here}", f"in {there}", _mean_of_seeds(moved)
    original, *controls = grid.variants
    for index, control in enumerate(controls, 1):
        yield _factor(grid), original, control, _mean_of_seeds(table[:, :, index] - table[:, :, 0])


# -- distances


def _judge_distances(
    grid: RunGrid, runs: Runs, metric: DistanceMetric, margins: Margins, resolution: float
) -> list[JudgedPart]:
    nothing: Mapping[str, Any] = {}
    features = {cell: metric.features(runs[cell]) if cell in runs else nothing for cell in grid.cells}
    names = list(dict.fromkeys(name for found in features.values() for name in found))
    return [_judge_distance(grid, metric, name, features, margins, resolution) for name in names]


def _judge_distance(
    grid: RunGrid, metric: DistanceMetric, name: str, features: Mapping[GridCell, Mapping[str, Any]],
    margins: Margins, resolution: float,
) -> JudgedPart:  # fmt: skip
    conditions = grid.conditions
    seeds = [s for s in grid.seeds if all(name in features[condition.cell(s)] for condition in conditions)]
    margin = margins.of(metric, name)
    if len(seeds) < _FEWEST_SEEDS:
        return JudgedPart(name, resolution, margin.in_sd, resolution, 0.0, False, len(seeds), ())
    matrix = _Distances(metric, name, features, seeds)
    off = ~np.eye(len(seeds), dtype=bool)
    spread = float(np.mean([matrix.between(one, one)[off].mean() for one in conditions]))
    reach = max(excess_of_shift(margin.amount) * spread if margin.in_sd else margin.amount, margin.at_least)
    contrasts = tuple(
        Contrast(
            factor, one, other, estimate, shift_of_excess(_ratio(estimate.mean, spread)), estimate.p_different
        )
        for factor, one, other, values in _excesses(grid, matrix)
        for estimate in [Estimate.of(values)]
    )
    reach, varies = max(reach, resolution), spread > resolution
    return JudgedPart(name, reach, margin.in_sd, resolution, spread, varies, len(seeds), contrasts)


class _Distances:
    """Distances between the runs of two conditions, each computed once."""

    def __init__(
        self, metric: DistanceMetric, name: str, features: Mapping[GridCell, Mapping[str, Any]],
        seeds: Sequence[int],
    ) -> None:  # fmt: skip
        self._metric, self._name, self._features, self._seeds = metric, name, features, seeds
        self._known: dict[tuple[Condition, Condition], FloatArray] = {}

    def between(self, one: Condition, other: Condition) -> FloatArray:
        """Return the distances, shape ``(n_seeds, n_seeds)``, from the runs of one to the other's."""
        if (one, other) not in self._known:
            a, b = ([self._features[at.cell(s)][self._name] for s in self._seeds] for at in (one, other))
            if one == other:
                found = np.zeros((len(a), len(a)))
                for i, j in combinations(range(len(a)), 2):
                    found[i, j] = found[j, i] = self._metric.distance(a[i], a[j])
            else:
                found = np.array([[self._metric.distance(x, y) for y in b] for x in a])
            self._known[one, other] = found
        return self._known[one, other]

    def excess(self, one: Condition, other: Condition) -> FloatArray:
        """Return for each seed how much farther apart the two are than the runs within each."""
        return excess_values(self.between(one, one), self.between(one, other), self.between(other, other))


def _excesses(grid: RunGrid, matrix: _Distances) -> Iterator[tuple[Factor, str, str, FloatArray]]:
    """Return every contrast with its value for each seed, the mean over the backends of the other side."""
    for one, other in combinations(grid.brains, 2):
        excess = [matrix.excess(Condition(one, world), Condition(other, world)) for world in grid.worlds]
        yield Factor.BRAIN, one, other, np.mean(excess, axis=0)
    for one, other in combinations(grid.worlds, 2):
        excess = [matrix.excess(Condition(brain, one), Condition(brain, other)) for brain in grid.brains]
        yield Factor.WORLD, one, other, np.mean(excess, axis=0)
    original, *controls = grid.conditions if grid.compares_variants else grid.conditions[:1]
    for control in controls:
        yield _factor(grid), original.wiring, control.wiring, matrix.excess(original, control)


def _factor(grid: RunGrid) -> Factor:
    return Factor.TIMESTEP if grid.timesteps else Factor.WIRING


def _ratio(value: float, spread: float) -> float:
    """Return an effect in units of a spread; infinite for an effect without a spread."""
    return value / spread if spread else float(np.copysign(np.inf, value)) if value else 0.0
