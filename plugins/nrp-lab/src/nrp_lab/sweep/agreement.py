"""What a finding depends on, by the verdict of ``nrp diff``, from the rows of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nrp_lab.comparison.grid import ORIGINAL, GridCell, RunGrid
from nrp_lab.comparison.judgement import Judgement, Relation, controls_of, corrected
from nrp_lab.comparison.measuring import parts_of_numbers
from nrp_lab.comparison.metrics.base import Margins, ScalarMetric
from nrp_lab.comparison.signals import RunSignals
from nrp_lab.sweep.measuring import scalar_metric
from nrp_lab.sweep.summary import SweepTable
from nrp_lab.sweep.table import CONTROLS, Row


def controls(table: SweepTable) -> dict[str, Relation]:
    """Return the relation of each control of the wiring to the original, seed by seed.

    Empty unless the sweep varies nothing but the controls and the seed, and has the original among them.
    """
    wirings = tuple(dict.fromkeys(str(row[CONTROLS]) for row in table.rows if CONTROLS in row))
    if table.keys != (CONTROLS,) or ORIGINAL not in wirings or len(wirings) < 2:
        return {}
    row = table.rows[0]
    seeds = tuple(dict.fromkeys(row["seed"] for row in table.rows))
    others = (name for name in wirings if name != ORIGINAL)
    grid = RunGrid(
        table.source, (row["brain.backend"],), (row["world.backend"],), seeds, table.settings,
        wirings=(ORIGINAL, *others),
    )  # fmt: skip
    measures = dict.fromkeys(name.partition(".")[0] for name in table.measures)
    return controls_of(judged_rows(grid, table.rows, [*measures]))


def judged_rows(grid: RunGrid, rows: Sequence[Row], measures: Sequence[str]) -> list[Judgement]:
    """Return the judgements of the metrics of the finding, from the rows of the grid's runs.

    Args:
        grid: the grid of runs.
        rows: the rows of those that have ended.
        measures: names of metrics that the sweep measured; those outside the finding are left out.
    """
    resolution = RunSignals({"settings": {"timestep": grid.load(grid.cells[0]).timestep}})
    judged = []
    for metric in filter(lambda one: one.is_finding, map(scalar_metric, measures)):
        measured = {cell_of(row): _values(row, metric) for row in rows}
        parts = parts_of_numbers(grid, metric, measured, Margins(), metric.resolution(resolution))
        judged.append(Judgement(metric, tuple(parts)))
    return corrected(judged)


def cell_of(row: Row) -> GridCell:
    """Return the run of a row."""
    wiring = str(row.get(CONTROLS, ORIGINAL))
    return GridCell(row["brain.backend"], row["world.backend"], row["seed"], wiring)


def _values(row: Row, metric: ScalarMetric) -> Mapping[str, float | None]:
    """Return the values of a metric by part, as it returned them in the worker."""
    prefix = f"{metric.name}."
    return {name.removeprefix(prefix): row[name] for name in row if name.startswith(prefix)}
