"""Judge the dependence of every metric: contrasts of backends or wirings against the spread of the seeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

from nrp_lab.comparison.metrics.base import Metric
from nrp_lab.comparison.statistics import ALPHA, Estimate, holm


class Answer(StrEnum):
    """The factors that a value depends on."""

    AGREES = "agrees across backends"
    KEPT = "agrees across wirings"
    SEED = "depends on the seed only"
    BRAIN = "depends on the brain"
    WORLD = "depends on the world"
    BOTH = "depends on the brain and the world"
    WIRING = "depends on the wiring"
    OPEN = "not decided: take more seeds"
    NONE = "not measured"

    @property
    def is_independent(self) -> bool:
        """Whether the value is independent of the simulator, or of the wiring if wirings are compared."""
        return self in (Answer.AGREES, Answer.KEPT, Answer.SEED)

    @property
    def is_dependent(self) -> bool:
        """Whether the value depends on the simulator, or on the wiring if wirings are compared."""
        return self in (Answer.BRAIN, Answer.WORLD, Answer.BOTH, Answer.WIRING)


class Relation(StrEnum):
    """The relation of two backends, or of a control and the original."""

    EQUIVALENT = "equivalent"
    """Any difference is below the margin (TOST)."""
    DIFFERENT = "different"
    """There is a difference, and it is above the margin."""
    OPEN = "open"
    """The runs do not decide."""


class Factor(StrEnum):
    """The factor that is exchanged in a contrast."""

    BRAIN = "brain"
    WORLD = "world"
    BOTH = "brain and world"
    """The interaction: half the difference of differences."""
    WIRING = "wiring"
    """A control in the place of the brain's own wiring."""


@dataclass(frozen=True, slots=True)
class Contrast:
    """Two backends or wirings (of a difference of differences: two pairs) compared in a part of a metric.

    Args:
        factor: the factor that is exchanged.
        one, other: the names.
        estimate: value of the other minus value of the one.
        effect_sd: the same in standard deviations of the spread from seed to seed.
        p_different: p-value of no difference, corrected by Holm for all contrasts of the finding, or for
            all other contrasts.
    """

    factor: Factor
    one: str
    other: str
    estimate: Estimate
    effect_sd: float
    p_different: float

    def relation(self, margin: float) -> Relation:
        """Return the relation at a margin."""
        if self.estimate.p_equivalent(margin) < ALPHA:
            return Relation.EQUIVALENT
        if self.p_different < ALPHA and abs(self.estimate.mean) > margin:
            return Relation.DIFFERENT
        return Relation.OPEN


class ConditionValues(NamedTuple):
    """The values of one pair of backends with one wiring."""

    brain: str
    world: str
    wiring: str
    values: list[float]


@dataclass(frozen=True, slots=True)
class JudgedPart:
    """A part of a metric: one robot, event, neuron, device.

    Args:
        name: its name.
        margin: a smaller difference does not matter, in the metric's unit.
        in_sd: whether the margin was given in standard deviations of the spread from seed to seed.
        resolution: the smallest difference that the metric can resolve, in the metric's unit.
        sd: spread from seed to seed, in the metric's unit.
        varies: whether runs of one pair of backends differ by more than the resolution.
        n_seeds: number of seeds with a value on both sides of every contrast; if it is 0, some backends
            cannot be compared and nothing is decided.
        contrasts: all comparisons.
        cells: the values themselves, for metrics that are numbers.
    """

    name: str
    margin: float
    in_sd: bool
    resolution: float
    sd: float
    varies: bool
    n_seeds: int
    contrasts: tuple[Contrast, ...]
    cells: tuple[ConditionValues, ...] = ()

    @property
    def answer(self) -> Answer:
        """The factors that it depends on.

        All backends are equivalent only if each pair is; that needs no correction for the number of pairs
        (Berger and Hsu 1996, Stat. Sci. 11:283).
        """
        if not self.contrasts:
            return Answer.NONE
        relations = {(one.factor, one.relation(self.margin)) for one in self.contrasts}
        different = {factor for factor, relation in relations if relation is Relation.DIFFERENT}
        if different:
            return _answer_of(different)
        if not self.n_seeds or any(relation is Relation.OPEN for _, relation in relations):
            return Answer.OPEN
        if self.varies:
            return Answer.SEED
        return Answer.KEPT if any(one.factor is Factor.WIRING for one in self.contrasts) else Answer.AGREES

    @property
    def is_flat(self) -> bool:
        """Whether the seeds have no spread, with which a difference of backends could be compared."""
        return self.n_seeds > 1 and self.sd <= self.resolution

    @property
    def largest(self) -> Contrast | None:
        """The contrast with the worst relation; of several, the one with the largest difference."""
        rank = {Relation.EQUIVALENT: 0, Relation.OPEN: 1, Relation.DIFFERENT: 2}
        return max(
            self.contrasts,
            key=lambda one: (rank[one.relation(self.margin)], abs(one.estimate.mean)),
            default=None,
        )


def _answer_of(factors: set[Factor]) -> Answer:
    alone = {Factor.BRAIN: Answer.BRAIN, Factor.WORLD: Answer.WORLD, Factor.WIRING: Answer.WIRING}
    return alone.get(next(iter(factors)), Answer.BOTH) if len(factors) == 1 else Answer.BOTH


@dataclass(frozen=True, slots=True)
class Judgement:
    """A metric with all its parts.

    Args:
        metric: the metric.
        parts: its parts, each judged by itself.
    """

    metric: Metric
    parts: tuple[JudgedPart, ...]

    @property
    def answer(self) -> Answer:
        """The factors that any of its parts depends on."""
        return combined(part.answer for part in self.parts)


def combined(answers: Iterable[Answer]) -> Answer:
    """Return the answer for a whole from the answers for its parts."""
    found = {answer for answer in answers if answer is not Answer.NONE}
    dependent = {answer for answer in found if answer.is_dependent}
    if dependent:
        return dependent.pop() if len(dependent) == 1 else Answer.BOTH
    for answer in (Answer.OPEN, Answer.SEED, Answer.AGREES, Answer.KEPT):
        if answer in found:
            return answer
    return Answer.NONE


def controls_of(judgements: Iterable[Judgement]) -> dict[str, Relation]:
    """Return the relation of each control to the original wiring, over all parts of some metrics."""
    found: dict[str, set[Relation]] = {}
    for part in (part for judged in judgements for part in judged.parts):
        for one in part.contrasts:
            if one.factor is Factor.WIRING:
                found.setdefault(one.other, set()).add(one.relation(part.margin))
    return {name: _worst(relations) for name, relations in found.items()}


def _worst(relations: set[Relation]) -> Relation:
    if Relation.DIFFERENT in relations:
        return Relation.DIFFERENT
    return Relation.OPEN if Relation.OPEN in relations else Relation.EQUIVALENT


def corrected(judgements: Sequence[Judgement]) -> list[Judgement]:
    """Return judgements corrected for the number of contrasts.

    The finding is corrected separately, so that it does not lose power by the many details listed beside it.
    """
    p_values: dict[bool, list[float]] = {True: [], False: []}
    for judged, one in _contrasts(judgements):
        p_values[judged.metric.is_finding].append(one.p_different)
    left = {is_finding: iter(holm(values)) for is_finding, values in p_values.items()}

    def with_p(judged: Judgement, part: JudgedPart) -> JudgedPart:
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
