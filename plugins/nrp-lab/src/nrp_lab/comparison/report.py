"""A comparison as text for terminals and as plain data for JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from nrp_core.clock import milliseconds
from nrp_core.recording import Difference
from nrp_core.utilities import join_with_limit
from nrp_lab.comparison.divergence import Divergence
from nrp_lab.comparison.engine_verdict import EngineVerdict
from nrp_lab.comparison.evidence import MOST_SEEDS, Doing, Evidence
from nrp_lab.comparison.grid import ORIGINAL, SILENCE
from nrp_lab.comparison.judgement import Answer, Contrast, Factor, JudgedPart, Judgement, Relation
from nrp_lab.comparison.metric import DistanceMetric, Metric
from nrp_lab.comparison.old_records import RecordsDiff
from nrp_lab.comparison.result import GridDiff, Measured, PairDiff
from nrp_lab.comparison.timesteps import ABOUT, columns, convergence, differing

_MANY = 1000
_MAX_NAMED = 4
_DEPENDS_ON = {
    Answer.BRAIN: "the brain",
    Answer.WORLD: "the world",
    Answer.BOTH: "the brain and on the world",
    Answer.WIRING: "the wiring",
    Answer.TIMESTEP: "the loop's time step",
}
_KINDS = {
    "rewire": "rewired synapses",
    SILENCE: "silenced cells",
    "animal": "the wiring of another animal",
    "brain": "another brain simulator",
    "world": "another physics engine",
    "timestep": "another time step of the loop",
}
VERDICTS = {
    Relation.DIFFERENT: "changes the finding",
    Relation.EQUIVALENT: "keeps the finding",
    Relation.OPEN: "may change the finding: take more seeds",
}


def question(diff: GridDiff) -> str:
    """Return the question that the grid answers."""
    return f"does it depend on the {_compared(diff)}?"


def headline(diff: GridDiff) -> str:
    """Return the verdict on the finding."""
    if on := _DEPENDS_ON.get(diff.answer):
        return f"The finding depends on {on}"
    if diff.answer is Answer.OPEN:
        return f"Whether the finding depends on the {_compared(diff)} is not decided: take more seeds"
    if diff.answer is Answer.NONE:
        return "There is nothing to compare"
    return f"The finding does not depend on the {_compared(diff)}"


def controls(relations: Mapping[str, Relation]) -> Iterator[str]:
    """Yield the effect of each control of the wiring on the finding."""
    for name, relation in relations.items():
        yield f"{name} {VERDICTS[relation]}"


def _compared(diff: GridDiff) -> str:
    if diff.grid.timesteps:
        return "loop's time step"
    return "wiring" if diff.grid.compares_wirings else "simulator"


def subject(diff: GridDiff) -> str:
    """Describe the runs."""
    grid = diff.grid
    first, last = grid.seeds[0], grid.seeds[-1]
    failed = f", {len(diff.failures)} of them not complete" if diff.failures else ""
    return (
        f"{len(diff.runs)} runs{failed}: {', '.join(grid.brains)} x {', '.join(grid.worlds)}, "
        + (f"seed {first}" if first == last else f"{len(grid.seeds)} seeds ({first} to {last})")
        + (f", {len(grid.wirings)} wirings" if grid.compares_wirings else "")
        + (f", the loop in steps of {join_with_limit(grid.timesteps[::-1], _MANY)}" if grid.timesteps else "")
        + (f", the world in steps of {milliseconds(grid.world_step_ns):g} ms" if grid.world_step_ns else "")
        + "".join(f", {key}={values}" for key, values in grid.varied.items())
    )


def evidence_subject(found: Evidence) -> str:
    """Describe the runs of an experiment and its controls."""
    grid, failures = found.diff.grid, len(found.diff.failures)
    failed = f", {failures} of them not complete" if failures else ""
    seeds = f"{len(grid.seeds)} seeds, {grid.seeds[0]} to {grid.seeds[-1]}"
    return (
        f"{len(found.diff.runs)} runs{failed}: the original and {len(found.controls)} controls, each from "
        f"the same {seeds}; brain simulator {grid.brains[0]}, physics engine {grid.worlds[0]}"
        + "".join(f"; {key} is drawn from {values} with each seed" for key, values in grid.varied.items())
    )


def seeds_advice(found: Evidence) -> str:
    """Say how many seeds would decide an open question; empty if it is decided."""
    if found.doing is not Doing.OPEN:
        return ""
    if (seeds := found.seeds_to_decide) is None:
        return f"Not even {MOST_SEEDS} seeds like these would decide it"
    runs = seeds * (1 + len(found.controls))
    return f"About {seeds} seeds ({runs} runs) would decide it, if the others are like these"


def untried(found: Evidence) -> list[str]:
    """Return the kinds of controls that were not tried."""
    tried = {name.partition(":")[0] for name in found.controls}
    return [words for kind, words in _KINDS.items() if kind not in tried]


def finding(diff: GridDiff | Evidence) -> str:
    """Name the metrics of the finding."""
    return "the finding: " + (", ".join(one.metric.title.lower() for one in diff.finding) or "none")


def advice(judgements: Iterable[Judgement]) -> str | None:
    """Return advice for metrics without a spread between seeds."""
    without = [judged for judged in judgements if any(map(_lacks_spread, judged.parts))]
    if not without:
        return None
    names = join_with_limit([judged.metric.title.lower() for judged in without], _MAX_NAMED)
    first = without[0].metric
    unit = f" (in {first.unit})" if first.unit else ""
    return (
        f"Seeds have no effect on {names}: there is no spread to compare a difference with, so "
        "any difference counts. Draw a setting with each seed: --vary 'events.NAME.at=LOW..HIGH s'; or set "
        f"the difference that does not matter: --margin {first.name}=VALUE{unit}."
    )


def _lacks_spread(part: JudgedPart) -> bool:
    """Whether a part depends on a backend only because the seeds have no spread."""
    return part.answer.is_dependent and part.in_sd and part.is_flat


def number(value: float | None, unit: str = "") -> str:
    """Return a number with its unit."""
    if value is None:
        return "-"
    return f"{value:.3g} {unit}".strip()


def _effect(contrast: Contrast, part: JudgedPart, metric: Metric) -> str:
    """Describe a contrast: the backends, the estimate, its 90 % interval, its size in seed spreads."""
    low, high = contrast.estimate.interval
    more = "farther apart than seeds are" if isinstance(metric, DistanceMetric) else ""
    size = f"{number(contrast.estimate.mean, metric.unit)} [{number(low)}, {number(high)}] {more}".strip()
    who = f"{contrast.one} → {contrast.other}"
    if contrast.factor is Factor.BOTH:
        who = f"{contrast.one} and {contrast.other}, half the difference"
    return f"{who}: {size}, {_in_sd(contrast, part)}"


def _in_sd(contrast: Contrast, part: JudgedPart) -> str:
    if part.is_flat and contrast.estimate.mean:
        return "seeds have no effect"
    amount = abs(contrast.effect_sd)
    return f"more than {_MANY} SD of the seeds" if amount > _MANY else f"{amount:.2g} SD of the seeds"


def largest(part: JudgedPart, metric: Metric) -> str:
    """Describe the largest difference in a part."""
    found = part.largest
    return "too few seeds have a value in all of them" if found is None else _effect(found, part, metric)


def grid_data(diff: GridDiff) -> dict[str, Any]:
    """Return a grid without the runs themselves, which are in their folders."""
    return {
        "experiment": diff.name,
        "brains": diff.grid.brains,
        "worlds": diff.grid.worlds,
        "wirings": diff.grid.wirings,
        "timesteps": [asdict(one) for one in convergence(diff)],
        "seeds": diff.grid.seeds,
        "overrides": diff.grid.overrides,
        "varied": {key: str(values) for key, values in diff.grid.varied.items()},
        "incomplete": diff.incomplete,
        "independent": diff.answer.is_independent,
        "answer": diff.answer,
        "controls": diff.controls,
        "engines": engine_data(diff.engines),
        "advice": advice(diff.judgements),
        "finding": [one.metric.name for one in diff.finding],
        "metrics": {one.metric.name: _judgement(one) for one in diff.judgements},
        "divergences": [_divergence_data(one) for one in diff.divergences],
        "failures": {str(cell): why for cell, why in diff.failures.items()},
        "results": diff.folder,
    }


def evidence_data(found: Evidence) -> dict[str, Any]:
    """Return the comparison of an experiment and its controls."""
    recordings = {
        name: [found.folder(cell) for cell in found.runs(name)] for name in (ORIGINAL, *found.controls)
    }
    return {
        **grid_data(found.diff),
        "advice": advice(found.finding),
        "finding": [one.metric.name for one in found.finding],
        "controls": {name: found.relation(name) for name in found.controls},
        "doing": found.doing.name.lower(),
        "sentence": found.sentence,
        "seeds_to_decide": found.seeds_to_decide,
        "left_out": found.left_out,
        "decoder": {"missing": found.without_decoder, "explained": found.explained},
        "recordings": recordings,
    }


def print_evidence(found: Evidence, console: Console) -> None:
    """Write the cause of the finding and the effect of each control."""
    _print_incomplete(console, found.diff.incomplete)
    console.print(Text(found.sentence, style="bold"))
    console.print(Text(f"{found.diff.name}, {evidence_subject(found)}; {finding(found)}", style="dim"))
    if recommended := seeds_advice(found):
        console.print(Text(recommended, style="yellow"))
    for name, why in found.left_out.items():
        console.print(Text(f"The control {name} was left out: {why}", style="yellow"))
    if found.without_decoder:
        console.print(Text(f"The decoder alone was not run: {found.without_decoder}", style="yellow"))
    table = _table("control", "the finding", "effect [90 %]")
    for name in found.controls:
        title, verdict = name, VERDICTS[found.relation(name)]
        for judged, part, one in found.effects(name):
            low, high = one.estimate.interval
            size = f"{number(one.estimate.mean, judged.metric.unit)} [{number(low)}, {number(high)}]"
            table.add_row(title, verdict, f"{part.name}: {size}")
            title = verdict = ""
    console.print(table)


def pair_data(diff: PairDiff) -> dict[str, Any]:
    """Return the comparison of two recordings."""
    return {
        "incomplete": diff.incomplete,
        "identical": diff.is_identical,
        "flaws": diff.flaws,
        "engines": engine_data(diff.engines),
        "reservations": diff.reservations,
        "divergence": _divergence_data(diff.divergence),
        "signals": diff.deviations,
        "metrics": [
            {
                "metric": row.metric.name,
                "part": row.part,
                "unit": row.metric.unit,
                "one": row.one,
                "other": row.other,
                "apart": row.apart,
            }
            for row in diff.measured
        ],
    }


def records_headline(diff: RecordsDiff) -> str:
    """Return the verdict on a run and old records, beginning with the parts that only one of them has."""
    left_out = []
    if diff.missing:
        left_out = ["Not all old records were compared"]
    elif diff.beyond:
        left_out = ["Part of the run has no old records"]
    differing = sum(not each.agrees for each in diff.signals)
    if differing:
        found = f"{differing} of {len(diff.signals)} signals differ from the old records"
    elif left_out:
        found = f"the {len(diff.signals)} signals that were compared agree"
    else:
        found = "The run agrees with the old records"
    return "; ".join([*left_out, found])


def records_data(diff: RecordsDiff) -> dict[str, Any]:
    """Return the comparison of a run with old records."""
    measured = ("largest", "at", "rms", "tolerance", "agrees")
    signals = {each.name: {key: getattr(each, key) for key in measured} for each in diff.signals}
    return {"agrees": diff.agrees, "missing": diff.missing, "beyond": diff.beyond, "signals": signals}


def print_records(diff: RecordsDiff, console: Console) -> None:
    """Write the comparison of a run with old records, the largest differences first."""
    _print_incomplete(console, [*diff.missing, *diff.beyond])
    console.print(Text(records_headline(diff), style=f"bold {'green' if diff.agrees else 'red'}"))
    table = _table("signal", "apart by", "at", "RMS", "allowed")
    for each in sorted(diff.signals, key=lambda one: one.agrees):
        numbers = (f"{each.largest:.3g}", f"{each.at:g}", f"{each.rms:.3g}", f"{each.tolerance:.3g}")
        table.add_row(each.name, *numbers)
    console.print(table)


def engine_data(verdict: EngineVerdict) -> dict[str, Any]:
    """Return the verdict on the engines, the largest difference first."""
    return {
        "answer": verdict.agreement,
        "agree": verdict.agrees,
        "headline": verdict.headline,
        "new": [one.key for one in verdict.new],
        "known": [one.key for one in verdict.known],
        "problems": verdict.problems,
        "differences": [
            {
                "key": one.key,
                "side": one.side,
                "one": one.one,
                "other": one.other,
                "measure": one.measure.name,
                "part": one.part,
                "difference": one.amount,
                "unit": one.measure.unit,
                "margin": one.margin,
                "in_margins": one.size,
                "known": one.is_known,
            }
            for one in verdict.differences
        ],
    }


def _judgement(judged: Judgement) -> dict[str, Any]:
    return {
        "title": judged.metric.title,
        "unit": judged.metric.unit,
        "answer": judged.answer,
        "parts": {part.name: _part(part) for part in judged.parts},
    }


def _part(part: JudgedPart) -> dict[str, Any]:
    return {
        "answer": part.answer,
        "margin": part.margin,
        "seed_sd": part.sd,
        "resolution": part.resolution,
        "seeds": part.n_seeds,
        "contrasts": [_contrast(one, part.margin) for one in part.contrasts],
        "cells": [cell._asdict() for cell in part.cells],
    }


def _contrast(one: Contrast, margin: float) -> dict[str, Any]:
    return {
        "factor": one.factor,
        "one": one.one,
        "other": one.other,
        "relation": one.relation(margin),
        "difference": one.estimate.mean,
        "interval_90": one.estimate.interval,
        "effect_sd": one.effect_sd,
        "p_equivalent": one.estimate.p_equivalent(margin),
        "p_different_holm": one.p_different,
    }


def _divergence_data(one: Divergence) -> dict[str, Any]:
    return {
        "one": one.one,
        "other": one.other,
        "steps": one.steps,
        "first": None if one.first is None else difference_data(one.first),
        "identical": one.is_identical,
        "visible": one.visible,
    }


def difference_data(first: Difference) -> dict[str, Any]:
    """Return where two runs first differ."""
    return {
        "step": first.step,
        "t_ns": first.t_ns,
        "side": first.group,
        "signal": first.signal,
        "one": first.recorded,
        "other": first.now,
    }


_MAX_PARTS = 4
_MAX_SIGNALS = 12
_MAX_ROWS = 6
_STYLES = {Answer.OPEN: "yellow", Answer.NONE: "dim"}


def print_grid(diff: GridDiff, console: Console) -> None:
    """Write both verdicts, then every metric with its largest difference, then where runs diverge."""
    _print_incomplete(console, diff.incomplete)
    style = f"bold {_style(diff.answer)}"
    console.print(Text.assemble((headline(diff), style)))
    for line in controls(diff.controls):
        console.print(Text(f"  {line}"))
    if not diff.grid.compares_variants:
        _print_engines(console, diff.engines)
    console.print(Text(f"{diff.name}, {subject(diff)}; {finding(diff)}", style="dim"))
    if (recommended := advice(diff.judgements)) is not None:
        console.print(Text(recommended, style="yellow"))
    table = _table("metric", "answer", "largest difference [90 %]")
    for judged in diff.judgements:
        _add(table, judged)
    console.print(table)
    if diff.grid.timesteps:
        console.print(Text(ABOUT, style="dim"))
        steps = _table(*columns(diff.grid.timesteps))
        for found in differing(diff):
            steps.add_row(*found.row)
        console.print(steps)
    for one in diff.divergences:
        _print_divergence(console, one)


def print_pair(diff: PairDiff, console: Console) -> None:
    """Write the common part of two recordings and their divergence."""
    _print_incomplete(console, [*diff.flaws, *diff.incomplete])
    for reservation in diff.reservations:
        console.print(Text(reservation, style="yellow"))
    if diff.is_identical:
        console.print(Text(f"identical: {diff.divergence.steps} steps", style="bold green"))
        return
    if diff.flaws:
        console.print(Text("not identical: a recording was changed or damaged", style="bold red"))
    experiments = [str(run.run.get("experiment", "?")) for run in (diff.one, diff.other)]
    if experiments[0] != experiments[1]:
        console.print(Text(f"two experiments: {' and '.join(experiments)}", style="yellow"))
    _print_engines(console, diff.engines)
    _print_divergence(console, diff.divergence)
    signals = _table("signal", "apart by", "at", "RMS", "range")
    for one in [one for one in diff.deviations if one.largest][:_MAX_SIGNALS]:
        numbers = (f"{one.largest:.3g}", f"{one.t_s:g} s", f"{one.rms:.3g}", f"{one.span:.3g}")
        signals.add_row(one.signal, *numbers)
    metrics = _table("metric", "part", "one", "other", "apart")
    apart = [row for row in diff.measured if row.apart or row.one != row.other]
    for title, rows in groupby(apart, lambda row: row.metric.title):
        _add_measured(metrics, title, sorted(rows, key=_by_difference))
    for table in (signals, metrics):
        if table.row_count:
            console.print(table)


def _print_incomplete(console: Console, reasons: Sequence[str]) -> None:
    for reason in reasons:
        console.print(Text(reason, style="bold red"))


def _print_engines(console: Console, verdict: EngineVerdict) -> None:
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
    largest_part = "" if worst is None else f"{worst.name}: {largest(worst, judged.metric)}"
    table.add_row(Text(judged.metric.title, style="bold"), Text(answer, style=style), Text(largest_part))
    telling = [
        part
        for part in parts[1:]
        if part.answer not in (Answer.AGREES, Answer.STABLE) and answer.is_dependent
    ]
    for part in telling[: _MAX_PARTS - 1]:
        detail = f"{part.name}: {largest(part, judged.metric)}"
        table.add_row("", Text(part.answer, style=_style(part.answer)), Text(detail))
    if len(telling) >= _MAX_PARTS:
        table.add_row("", "", Text(f"and {len(telling) - _MAX_PARTS + 1} more", style="dim"))


def _add_measured(table: Table, title: str, rows: Sequence[Measured]) -> None:
    """Add the parts of a metric with the largest differences."""
    for row in rows[:_MAX_ROWS]:
        values = (number(value) for value in (row.one, row.other))
        table.add_row(title, row.part, *values, number(row.apart, row.metric.unit))
        title = ""
    if len(rows) > _MAX_ROWS:
        table.add_row("", Text(f"and {len(rows) - _MAX_ROWS} more", style="dim"))


def _by_difference(row: Measured) -> tuple[bool, float]:
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
