"""Wording shared by all forms of a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from nrp_core._support.words import first_of
from nrp_lab.comparison.judgement import Answer, Contrast, Factor, JudgedPart, Relation
from nrp_lab.comparison.metrics.base import DistanceMetric, Metric
from nrp_lab.comparison.result import GridDiff

_MANY = 1000
_MOST_NAMED = 4
_DEPENDS_ON = {
    Answer.BRAIN: "the brain",
    Answer.WORLD: "the world",
    Answer.BOTH: "the brain and on the world",
    Answer.WIRING: "the wiring",
}
_CONTROLLED = {
    Relation.DIFFERENT: "changes the finding",
    Relation.EQUIVALENT: "keeps the finding",
    Relation.OPEN: "may change the finding: take more seeds",
}


def question(diff: GridDiff) -> str:
    """Return what the grid asks."""
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
    """Yield what each control of the wiring does to the finding."""
    for name, relation in relations.items():
        yield f"{name} {_CONTROLLED[relation]}"


def _compared(diff: GridDiff) -> str:
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
        + "".join(f", {key}={values}" for key, values in grid.varied.items())
    )


def finding(diff: GridDiff) -> str:
    """Name the metrics of the finding."""
    return "the finding: " + ", ".join(one.metric.title.lower() for one in diff.finding)


def advice(diff: GridDiff) -> str | None:
    """Return advice for metrics without a spread between seeds."""
    without = [judged for judged in diff.judgements if any(map(_lacks_spread, judged.parts))]
    if not without:
        return None
    names = first_of([judged.metric.title.lower() for judged in without], _MOST_NAMED)
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
