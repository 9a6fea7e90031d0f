"""Say of every metric on what it depends: contrasts between backends, held against the seeds' spread."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

from nrp_core.comparison.metrics.base import Metric
from nrp_core.comparison.statistics import ALPHA, Estimate, holm


class Answer(StrEnum):
    """On what a value depends."""

    AGREES = "agrees across backends"
    SEED = "depends on the seed only"
    BRAIN = "depends on the brain"
    WORLD = "depends on the world"
    BOTH = "depends on the brain and the world"
    OPEN = "not decided: take more seeds"
    NONE = "not measured"

    @property
    def is_independent(self) -> bool:
        """Whether it does not depend on the simulator."""
        return self in (Answer.AGREES, Answer.SEED)

    @property
    def is_dependent(self) -> bool:
        """Whether it does."""
        return self in (Answer.BRAIN, Answer.WORLD, Answer.BOTH)


class Relation(StrEnum):
    """How two backends are to each other."""

    EQUIVALENT = "equivalent"
    """The difference is below the margin (TOST), if there is any."""
    DIFFERENT = "different"
    """There is one, and it is above the margin."""
    OPEN = "open"
    """The runs do not tell."""


class Factor(StrEnum):
    """What is exchanged in a contrast."""

    BRAIN = "brain"
    WORLD = "world"
    BOTH = "brain and world"
    """What one makes of a difference of the other: half a difference of differences."""


@dataclass(frozen=True, slots=True)
class Contrast:
    """Two backends (of a difference of differences: two pairs) compared in one part of a metric.

    Args:
        factor: what is exchanged.
        one, other: the names.
        estimate: how much more the other gives.
        effect_sd: the same in standard deviations of the spread from seed to seed.
        p_different: of there being no difference, corrected by Holm for all contrasts of the finding, or of
            all else.
    """

    factor: Factor
    one: str
    other: str
    estimate: Estimate
    effect_sd: float
    p_different: float

    def relation(self, margin: float) -> Relation:
        """Return what it says at a margin."""
        if self.estimate.p_equivalent(margin) < ALPHA:
            return Relation.EQUIVALENT
        if self.p_different < ALPHA and abs(self.estimate.mean) > margin:
            return Relation.DIFFERENT
        return Relation.OPEN


class Cells(NamedTuple):
    """What one pair of backends gave."""

    brain: str
    world: str
    values: list[float]


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a metric: one robot, event, neuron, device.

    Args:
        name: of the part.
        margin: below which a difference does not matter, in the metric's unit.
        in_sd: whether the margin was counted in standard deviations of the spread from seed to seed.
        resolution: what the metric cannot tell apart, in the same unit.
        sd: spread from seed to seed, likewise.
        varies: whether runs of one pair of backends differ by more than the metric can tell apart.
        n_seeds: how many seeds have a value on both sides of every contrast; where there are none, some
            backends cannot be compared, and what they have in common decides nothing.
        contrasts: all comparisons.
        cells: the values themselves, for those that have numbers of their own.
    """

    name: str
    margin: float
    in_sd: bool
    resolution: float
    sd: float
    varies: bool
    n_seeds: int
    contrasts: tuple[Contrast, ...]
    cells: tuple[Cells, ...] = ()

    @property
    def answer(self) -> Answer:
        """On what it depends.

        Equivalent are all backends only if each pair is: that needs no correction for their number (Berger
        and Hsu 1996, Stat. Sci. 11:283).
        """
        if not self.contrasts:
            return Answer.NONE
        relations = {(one.factor, one.relation(self.margin)) for one in self.contrasts}
        different = {factor for factor, relation in relations if relation is Relation.DIFFERENT}
        if different:
            return _answer_of(different)
        if not self.n_seeds or any(relation is Relation.OPEN for _, relation in relations):
            return Answer.OPEN
        return Answer.SEED if self.varies else Answer.AGREES

    @property
    def is_flat(self) -> bool:
        """Whether seeds make no difference that a difference of backends could be held against."""
        return self.n_seeds > 1 and self.sd <= self.resolution

    @property
    def largest(self) -> Contrast | None:
        """The contrast in the worst relation, of those with the largest difference."""
        rank = {Relation.EQUIVALENT: 0, Relation.OPEN: 1, Relation.DIFFERENT: 2}
        return max(
            self.contrasts,
            key=lambda one: (rank[one.relation(self.margin)], abs(one.estimate.mean)),
            default=None,
        )


def _answer_of(factors: set[Factor]) -> Answer:
    if factors == {Factor.BRAIN}:
        return Answer.BRAIN
    return Answer.WORLD if factors == {Factor.WORLD} else Answer.BOTH


@dataclass(frozen=True, slots=True)
class Judgement:
    """A metric with all its parts.

    Args:
        metric: what was measured.
        parts: each by itself.
    """

    metric: Metric
    parts: tuple[Part, ...]

    @property
    def answer(self) -> Answer:
        """On what it depends: on all that any part of it depends on."""
        return combined(part.answer for part in self.parts)


def combined(answers: Iterable[Answer]) -> Answer:
    """Return on what a whole depends whose parts depend on these."""
    found = {answer for answer in answers if answer is not Answer.NONE}
    dependent = {answer for answer in found if answer.is_dependent}
    if dependent:
        return dependent.pop() if len(dependent) == 1 else Answer.BOTH
    for answer in (Answer.OPEN, Answer.SEED, Answer.AGREES):
        if answer in found:
            return answer
    return Answer.NONE


def corrected(judgements: Sequence[Judgement]) -> list[Judgement]:
    """Return judgements in which chance differences are as rare among many contrasts as in one.

    The finding is corrected by itself: it does not pay for the many details that are listed beside it.
    """
    p_values: dict[bool, list[float]] = {True: [], False: []}
    for judged, one in _contrasts(judgements):
        p_values[judged.metric.is_finding].append(one.p_different)
    left = {is_finding: iter(holm(values)) for is_finding, values in p_values.items()}

    def with_p(judged: Judgement, part: Part) -> Part:
        rest = left[judged.metric.is_finding]
        return replace(part, contrasts=tuple(replace(one, p_different=next(rest)) for one in part.contrasts))

    return [
        replace(judged, parts=tuple(with_p(judged, part) for part in judged.parts)) for judged in judgements
    ]


def _contrasts(judgements: Sequence[Judgement]) -> Iterator[tuple[Judgement, Contrast]]:
    for judged in judgements:
        for part in judged.parts:
            for one in part.contrasts:
                yield judged, one
