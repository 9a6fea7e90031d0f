"""The summary of a sweep as text and as data, and the factors that affect its outcome."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from nrp_lab.comparison import report as comparison_report
from nrp_lab.comparison.grid import ORIGINAL, GridCell, RunGrid
from nrp_lab.comparison.judgement import Judgement, Relation, controls_of, corrected
from nrp_lab.comparison.measuring import parts_of_numbers
from nrp_lab.comparison.metric import Margins, ScalarMetric
from nrp_lab.comparison.signals import RunSignals
from nrp_lab.sweep.measuring import scalar_metric
from nrp_lab.sweep.model import SEED
from nrp_lab.sweep.table import CONTROLS, Group, Row, SweepTable, short_key, unit_of


def controls(table: SweepTable) -> dict[str, Relation]:
    """Return the relation of each control of the wiring to the original, seed by seed.

    Empty unless the sweep varies only the controls and the seed, and includes the original.
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
        rows: the rows of the ended runs.
        measures: names of metrics that the sweep measured; those outside the finding are omitted.
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


_MAX_ROWS = 40
_MAX_MEASURES = 6
_MAX_ERRORS = 3


def report(table: SweepTable, console: Console) -> None:
    """Print the problems and errors of all runs, then a line for each combination."""
    for line in (*remarks(table), *without_effect(table)):
        console.print(line, markup=False)
    groups, measures = table.groups, table.measures[:_MAX_MEASURES]
    shown = Table(box=None, pad_edge=False, header_style="bold")
    for key in table.keys:
        shown.add_column(short_key(key, table.keys), overflow="fold")
    for name in ("runs", "passed", *measures):
        metric, dot, part = name.partition(".")  # on two lines, so that neither is broken
        unit = unit_of(name)
        heading = (f"{metric}{dot}\n{part}" if dot else name) + (f"\n({unit})" if unit else "")
        shown.add_column(heading, justify="right", overflow="fold")
    for group in groups[:_MAX_ROWS]:
        shown.add_row(*_cells(group, table.keys, measures))
    console.print(shown)
    rest = {"combinations": len(groups) - _MAX_ROWS, "measures": len(table.measures) - len(measures)}
    for line in comparison_report.controls(controls(table)):
        console.print(line, markup=False)
    if left_out := [f"{number} more {what}" for what, number in rest.items() if number > 0]:
        console.print(f"and {' and '.join(left_out)} in the table")


def report_data(table: SweepTable, folder: Path, figure: Path | None) -> dict[str, Any]:
    """Return the summary as plain data."""
    return {
        "experiment": table.name,
        "folder": folder,
        "runs": len(table.rows),
        "failed": sum(row["error"] is not None for row in table.rows),
        "incomplete": sum(not row["complete"] for row in table.rows),
        "keys": table.keys,
        "controls": controls(table),
        "measures": table.measures,
        "units": {name: unit_of(name) for name in table.measures},
        "groups": [
            {
                "values": group.values,
                "runs": len(group.rows),
                "passed": sum(row["passed"] is True for row in group.rows),
                "measured": {
                    name: {"mean": group.mean(name), "sd": group.spread(name), "n": len(group.numbers(name))}
                    for name in table.measures
                },
            }
            for group in table.groups
        ],
        "figure": figure,
    }


def remarks(table: SweepTable) -> list[str]:
    """Return the lines about failed and incomplete runs, to be printed before the results."""
    errors = Counter(str(row["error"]) for row in table.rows if row["error"] is not None)
    incomplete = [row for row in table.rows if not row["complete"] and row["error"] is None]
    codes = Counter(code for row in incomplete for code in str(row["problems"] or "").split())
    most = errors.most_common(_MAX_ERRORS)
    lines = [f"{count} failed: {error}" for error, count in most]
    if others := errors.total() - sum(count for _, count in most):
        lines.append(f"{others} failed with other errors")
    if incomplete:
        named = ", ".join(f"{code} in {count}" for code, count in codes.most_common(_MAX_ERRORS))
        lines.append(f"{len(incomplete)} runs are not complete ({named}; nrp explain CODE)")
    return lines


def without_effect(table: SweepTable) -> Iterator[str]:
    """Yield a line for each setting, and for the seed, of which all values gave the same results."""
    ended = [row for row in table.rows if row["error"] is None]
    for key in (*table.keys, SEED):
        others = [one for one in (*table.keys, SEED) if one != key]
        found: dict[tuple[str, ...], dict[str, tuple[str, ...]]] = {}
        for row in ended:
            alike = found.setdefault(tuple(str(row[one]) for one in others), {})
            alike[str(row[key])] = tuple(str(row[one]) for one in ("trajectory_digest", *table.measures))
        compared = [alike for alike in found.values() if len(alike) > 1]
        if compared and all(len(set(alike.values())) == 1 for alike in compared):
            yield f"'{key}' changed nothing: all its values gave the same trajectories and measures"


def _cells(group: Group, keys: tuple[str, ...], measures: tuple[str, ...]) -> list[str]:
    passed = [row["passed"] for row in group.rows]
    decided = [one for one in passed if one is not None]
    share = f"{sum(one is True for one in passed)} of {len(passed)}" if decided else "-"
    return [
        *(_short(group.values[key]) for key in keys),
        str(len(group.rows)),
        share,
        *(_with_spread(group, name) for name in measures),
    ]


def _with_spread(group: Group, name: str) -> str:
    if not group.numbers(name):
        return "-"
    spread = group.spread(name)
    return f"{group.mean(name):.4g}" + (f" ± {spread:.2g}" if spread else "")


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
