"""Whether backends agree on a task: the verdict of ``nrp diff``, from the rows of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from nrp_core.benchmark.tasks import MEASURES
from nrp_core.comparison.grid import GridCell, RunGrid
from nrp_core.comparison.judgement import Answer, Judgement, combined, corrected
from nrp_core.comparison.measuring import parts_of_numbers
from nrp_core.comparison.metrics.base import Margins, ScalarMetric
from nrp_core.comparison.signals import RunSignals
from nrp_core.sweep.measuring import scalar_metric
from nrp_core.sweep.record import INVALID
from nrp_core.sweep.table import Row


def answer_of(grid: RunGrid, rows: Sequence[Row]) -> Answer:
    """Return what the finding of an experiment depends on; NONE for a single pair of backends.

    Backends that cannot begin the task with any partner are left out.

    Args:
        grid: the grid of runs.
        rows: the rows of those that have ended.
    """
    begun = {_cell(row): row for row in rows if row["state"] != INVALID}
    brains = tuple(name for name in grid.brains if any(cell.brain == name for cell in begun))
    worlds = tuple(name for name in grid.worlds if any(cell.world == name for cell in begun))
    if len(brains) * len(worlds) < 2:
        return Answer.NONE
    able = replace(grid, brains=brains, worlds=worlds)
    resolution = RunSignals({"settings": {"timestep": grid.load(grid.cells[0]).timestep}})
    judged = []
    for metric in filter(lambda one: one.is_finding, map(scalar_metric, MEASURES)):
        measured = {cell: _values(row, metric) for cell, row in begun.items()}
        parts = parts_of_numbers(able, metric, measured, Margins(), metric.resolution(resolution))
        judged.append(Judgement(metric, tuple(parts)))
    return combined(one.answer for one in corrected(judged))


def _cell(row: Row) -> GridCell:
    return GridCell(row["brain.backend"], row["world.backend"], row["seed"])


def _values(row: Row, metric: ScalarMetric) -> Mapping[str, float | None]:
    """Return the values of a metric by part, as it returned them in the worker."""
    prefix = f"{metric.name}."
    return {name.removeprefix(prefix): row[name] for name in row if name.startswith(prefix)}
