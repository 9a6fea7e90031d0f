"""The same words in every form of a report."""

from __future__ import annotations

from nrp_core.comparison.judgement import Answer, Contrast, Factor, Part
from nrp_core.comparison.metrics.base import DistanceMetric, Metric
from nrp_core.comparison.result import GridDiff

_MANY = 1000
HEADLINES = {
    Answer.AGREES: "The finding does not depend on the simulator",
    Answer.SEED: "The finding does not depend on the simulator",
    Answer.BRAIN: "The finding depends on the brain",
    Answer.WORLD: "The finding depends on the world",
    Answer.BOTH: "The finding depends on the brain and on the world",
    Answer.OPEN: "Whether the finding depends on the simulator is not decided: take more seeds",
    Answer.NONE: "There is nothing to compare",
}


def subject(diff: GridDiff) -> str:
    """Say what was run."""
    grid = diff.grid
    first, last = grid.seeds[0], grid.seeds[-1]
    return (
        f"{len(diff.runs)} runs: {', '.join(grid.brains)} x {', '.join(grid.worlds)}, "
        + (f"seed {first}" if first == last else f"{len(grid.seeds)} seeds ({first} to {last})")
        + "".join(f", {key}={values}" for key, values in grid.varied.items())
    )


def finding(diff: GridDiff) -> str:
    """Say what is called the finding."""
    return "the finding: " + ", ".join(one.metric.title.lower() for one in diff.finding)


def number(value: float | None, unit: str = "") -> str:
    """Return a number with its unit."""
    if value is None:
        return "-"
    return f"{value:.3g} {unit}".strip()


def effect(contrast: Contrast, metric: Metric) -> str:
    """Say who differs from whom by how much: estimate, interval of 90 %, size in spreads of the seeds."""
    low, high = contrast.estimate.interval
    more = "farther apart than seeds are" if isinstance(metric, DistanceMetric) else ""
    size = f"{number(contrast.estimate.mean, metric.unit)} [{number(low)}, {number(high)}] {more}".strip()
    who = f"{contrast.one} → {contrast.other}"
    if contrast.factor is Factor.BOTH:
        who = f"{contrast.one} and {contrast.other}, half the difference"
    return f"{who}: {size}, {_in_sd(contrast)}"


def _in_sd(contrast: Contrast) -> str:
    amount = abs(contrast.effect_sd)
    return f"more than {_MANY} SD of the seeds" if amount > _MANY else f"{amount:.2g} SD of the seeds"


def largest(part: Part, metric: Metric) -> str:
    """Say what the largest difference in a part is."""
    found = part.largest
    return "too few seeds have it on all backends" if found is None else effect(found, metric)
