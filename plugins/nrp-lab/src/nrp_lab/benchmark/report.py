"""The standings as a table, as text and as data."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from nrp_core._support.writing import writing
from nrp_lab.benchmark.standings import Standing
from nrp_lab.benchmark.tasks import TASKS
from nrp_lab.comparison.judgement import Answer

CSV = "benchmark.csv"
_HEADS = ("task", "brain", "world", "score", "95 %", "passed", "real time", "spikes/s", "synaptic events/s")
_TEXTS = 3


def report(standings: Sequence[Standing], console: Console) -> None:
    """Print the runs that failed, the table, and for each task whether the backends agree."""
    for error, count in Counter(one.error for one in standings if one.error).items():
        console.print(f"{count} {'pair' if count == 1 else 'pairs'} of backends: {error}", markup=False)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, head in enumerate(_HEADS):
        table.add_column(head, justify="left" if place < _TEXTS else "right")
    for one in standings:
        table.add_row(*_cells(one))
    console.print(table)
    for name, agreement in {one.task: one.agreement for one in standings}.items():
        console.print(f"{name} ({TASKS[name].asks}): {_agreement(agreement)}", markup=False)


def report_data(standings: Sequence[Standing], folder: Path) -> dict[str, Any]:
    """Return the standings as plain data."""
    return {"folder": folder, "standings": [asdict(one) for one in standings]}


def write_csv(standings: Sequence[Standing], folder: Path) -> Path:
    """Write the standings into the folder of the benchmark, and return the file.

    Raises:
        ExperimentError: it cannot be written.
    """
    path, rows = folder / CSV, [_row(one) for one in standings]
    with writing(path), path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return path


def _row(one: Standing) -> dict[str, Any]:
    row = asdict(one)
    low, high = row.pop("interval") or (None, None)
    return {**row, "score_low": low, "score_high": high}


def _cells(one: Standing) -> list[str]:
    if one.score is None or one.interval is None:
        return [one.task, one.brain, one.world, "cannot run", *[""] * (len(_HEADS) - _TEXTS - 1)]
    low, high = one.interval
    speed = "-" if one.real_time_factor is None else f"{one.real_time_factor:.1f} x"
    return [
        one.task, one.brain, one.world, f"{one.score:.2f}", f"{low:.2f} to {high:.2f}",
        f"{one.passed} of {one.runs}", speed, _count(one.spikes_hz), _count(one.synaptic_events_hz),
    ]  # fmt: skip


def _count(number: float | None) -> str:
    return "-" if number is None else f"{number:,.0f}"


def _agreement(answer: Answer) -> str:
    return "one pair of backends, nothing to compare" if answer is Answer.NONE else f"the finding: {answer}"
