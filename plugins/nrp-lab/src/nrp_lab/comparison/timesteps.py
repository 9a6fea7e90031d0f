"""Whether measures approach a value as the loop's time step becomes shorter, and how much is left of the way.

Brain and world exchange data once in a step, so what one does reaches the other up to a step later. The error
of such a coupling is proportional to the step ``h`` as long as the motion is smooth. If a measure differs by
``d`` between the second finest step ``h2`` and the finest ``h1``, then ``d h1 / (h2 - h1)`` is left at the
finest: Richardson's extrapolation of the first order. This is stated only of differences that shrink.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from nrp_core.quantities import time_ns
from nrp_lab.comparison.judgement import JudgedPart
from nrp_lab.comparison.metric import ScalarMetric
from nrp_lab.comparison.result import GridDiff

ABOUT = (
    "Each measure minus its value at the finest step, the mean over seeds. What is left at the finest is "
    "estimated from the two finest ones, for an error that is proportional to the step."
)


@dataclass(frozen=True, slots=True)
class Convergence:
    """How a measure changes with the loop's time step.

    Args:
        measure: title of the metric.
        part: the part: a robot, a criterion, ...
        unit: the unit of the measure.
        answer: the factors that affect it.
        differences: the value at each time step minus that at the finest, the coarsest first.
        shrinks: whether these become smaller with each step; None if all are 0.
        left: the estimated difference between the finest step and infinitely small ones; None if it cannot be
            estimated.
    """

    measure: str
    part: str
    unit: str
    answer: str
    differences: tuple[float, ...]
    shrinks: bool | None
    left: float | None

    @property
    def row(self) -> tuple[str, ...]:
        """The cells of its row in a table."""
        shrinks = "yes" if self.shrinks else "no"
        left = "-" if self.left is None else f"{self.left:.2g} {self.unit}".strip()
        return self.measure, self.part, *(f"{one:.3g}" for one in self.differences), shrinks, left


def differing(diff: GridDiff) -> list[Convergence]:
    """Return the measures that differ between time steps."""
    return [one for one in convergence(diff) if one.shrinks is not None]


def columns(timesteps: Sequence[str]) -> tuple[str, ...]:
    """Return the titles of the columns of a table of rows, for time steps with the finest first."""
    return "measure", "part", *timesteps[:0:-1], "shrinks", f"left at {timesteps[0]}"


def convergence(diff: GridDiff) -> Iterator[Convergence]:
    """Yield every measure that is a number, if time steps are compared."""
    steps_ns = [*map(time_ns, diff.grid.timesteps)]
    for judged in diff.judgements if steps_ns else ():
        for part in judged.parts if isinstance(judged.metric, ScalarMetric) else ():
            if len(part.contrasts) == len(steps_ns) - 1:
                yield _convergence(judged.metric.title, judged.metric.unit, part, steps_ns)


def _convergence(title: str, unit: str, part: JudgedPart, steps_ns: Sequence[int]) -> Convergence:
    found = [one.estimate.mean for one in part.contrasts]  # against the finest step, from fine to coarse
    shrinks = None if not any(found) else all(abs(fine) < abs(coarse) for fine, coarse in pairwise(found))
    finest, second = steps_ns[0], steps_ns[1]
    left = abs(found[0]) * finest / (second - finest) if shrinks else 0.0 if shrinks is None else None
    return Convergence(title, part.name, unit, str(part.answer), tuple(found[::-1]), shrinks, left)
