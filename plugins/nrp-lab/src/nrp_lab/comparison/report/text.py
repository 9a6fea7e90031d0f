"""A comparison for terminals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from nrp_lab.comparison.divergence import Divergence
from nrp_lab.comparison.engines.verdict import EngineVerdict
from nrp_lab.comparison.judgement import Answer, JudgedPart, Judgement
from nrp_lab.comparison.report import words
from nrp_lab.comparison.result import GridDiff, Measured, PairDiff

_MOST_PARTS = 4
_MOST_SIGNALS = 12
_MOST_ROWS = 6
_STYLES = {Answer.OPEN: "yellow", Answer.NONE: "dim"}


def tell_grid(diff: GridDiff, console: Console) -> None:
    """Write both verdicts, then every metric with its largest difference, then where runs diverge."""
    _tell_incomplete(console, diff.incomplete)
    style = f"bold {_style(diff.answer)}"
    console.print(Text.assemble((words.headline(diff), style)))
    for line in words.controls(diff.controls):
        console.print(Text(f"  {line}"))
    if not diff.grid.compares_wirings:
        _tell_engines(console, diff.engines)
    console.print(Text(f"{diff.name}, {words.subject(diff)}; {words.finding(diff)}", style="dim"))
    if (advice := words.advice(diff)) is not None:
        console.print(Text(advice, style="yellow"))
    table = _table("metric", "answer", "largest difference [90 %]")
    for judged in diff.judgements:
        _add(table, judged)
    console.print(table)
    for one in diff.divergences:
        _print_divergence(console, one)


def tell_pair(diff: PairDiff, console: Console) -> None:
    """Write the common part of two recordings and their divergence."""
    _tell_incomplete(console, [*diff.flaws, *diff.incomplete])
    for said in diff.reservations:
        console.print(Text(said, style="yellow"))
    if diff.is_identical:
        console.print(Text(f"identical: {diff.divergence.steps} steps", style="bold green"))
        return
    if diff.flaws:
        console.print(Text("not identical: a recording was changed or damaged", style="bold red"))
    experiments = [str(run.run.get("experiment", "?")) for run in (diff.one, diff.other)]
    if experiments[0] != experiments[1]:
        console.print(Text(f"two experiments: {' and '.join(experiments)}", style="yellow"))
    _tell_engines(console, diff.engines)
    _print_divergence(console, diff.divergence)
    signals = _table("signal", "apart by", "at", "RMS", "range")
    for one in [one for one in diff.deviations if one.largest][:_MOST_SIGNALS]:
        numbers = (f"{one.largest:.3g}", f"{one.t_s:g} s", f"{one.rms:.3g}", f"{one.span:.3g}")
        signals.add_row(one.signal, *numbers)
    metrics = _table("metric", "part", "one", "other", "apart")
    apart = [row for row in diff.measured if row.apart or row.one != row.other]
    for title, rows in groupby(apart, lambda row: row.metric.title):
        _add_measured(metrics, title, sorted(rows, key=_apart))
    for table in (signals, metrics):
        if table.row_count:
            console.print(table)


def _tell_incomplete(console: Console, reasons: Sequence[str]) -> None:
    for reason in reasons:
        console.print(Text(reason, style="bold red"))


def _tell_engines(console: Console, verdict: EngineVerdict) -> None:
    """Write the verdict on the engines, and the known differences in one line."""
    style = "green" if verdict.agrees else "red" if verdict.new else "yellow"
    console.print(Text(verdict.headline, style=f"bold {style}"))
    if verdict.new and verdict.known:
        console.print(Text(f"known already: {', '.join(one.key for one in verdict.known)}", style="dim"))


def _add(table: Table, judged: Judgement) -> None:
    """Add a metric: one row, and under it the parts that have another answer or differ."""
    answer, style = judged.answer, _style(judged.answer)
    parts = sorted(judged.parts, key=_weight)
    worst = parts[0] if parts else None
    said = "" if worst is None else f"{worst.name}: {words.largest(worst, judged.metric)}"
    table.add_row(Text(judged.metric.title, style="bold"), Text(answer, style=style), Text(said))
    telling = [
        part for part in parts[1:] if part.answer not in (Answer.AGREES, Answer.KEPT) and answer.is_dependent
    ]
    for part in telling[: _MOST_PARTS - 1]:
        detail = f"{part.name}: {words.largest(part, judged.metric)}"
        table.add_row("", Text(part.answer, style=_style(part.answer)), Text(detail))
    if len(telling) >= _MOST_PARTS:
        table.add_row("", "", Text(f"and {len(telling) - _MOST_PARTS + 1} more", style="dim"))


def _add_measured(table: Table, title: str, rows: Sequence[Measured]) -> None:
    """Add the parts of a metric that are farthest apart."""
    for row in rows[:_MOST_ROWS]:
        values = (words.number(value) for value in (row.one, row.other))
        table.add_row(title, row.part, *values, words.number(row.apart, row.metric.unit))
        title = ""
    if len(rows) > _MOST_ROWS:
        table.add_row("", Text(f"and {len(rows) - _MOST_ROWS} more", style="dim"))


def _apart(row: Measured) -> tuple[bool, float]:
    """Return the sort key of a part: single neurons last, then by relative difference."""
    is_neuron = row.part.endswith("]")
    if row.one is None or row.other is None:
        return is_neuron, -abs(row.apart or 0.0)
    return is_neuron, -abs(row.one - row.other) / max(abs(row.one), abs(row.other))


def _weight(part: JudgedPart) -> tuple[int, float]:
    """Return the sort key of a part: dependent ones first, large effects first."""
    rank = 0 if part.answer.is_dependent else {Answer.OPEN: 1, Answer.NONE: 3}.get(part.answer, 2)
    found = part.largest
    return rank, 0.0 if found is None else -abs(found.estimate.mean) / (part.margin or 1.0)


def _print_divergence(console: Console, one: Divergence) -> None:
    console.print(Text(f"{one.one} and {one.other}", style="bold"))
    if one.first is None:
        how = "to the last bit" if one.is_identical else "but for rounding"
        console.print(f"  the same {how} in {one.steps} steps")
        return
    first = one.first
    line = f"  diverge in step {first.step}, {first.t_ns * 1e-9:g} s, with {first.signal} ({first.group}): "
    console.print(Text(f"{line}{first.recorded}; {first.now}"))
    if one.visible is not None:
        console.print(Text(f"  visibly at {one.visible}"))


def _style(answer: Answer) -> str:
    return "green" if answer.is_independent else _STYLES.get(answer, "red")


def _table(*titles: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for title in titles:
        table.add_column(title, overflow="fold")
    return table
