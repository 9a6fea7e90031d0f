"""Statistics of paired seeds, and the judgement by them whether a metric depends on a backend or wiring."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import erf, exp, inf, nan, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from nrp_core.brain import FloatArray
from nrp_lab.comparison.metric import Metric

ALPHA = 0.05
"""Level of every test; the intervals shown are 90 % intervals, which match two one-sided tests at 5 %."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean with its error.

    Args:
        mean: the estimate.
        error: its standard error; NaN for a single value.
        freedom: degrees of freedom of the error.
        is_share: whether it is that of matched shares.
    """

    mean: float
    error: float
    freedom: int
    is_share: bool = False

    @classmethod
    def of(cls, values: FloatArray) -> Estimate:
        """Return the mean of independent values."""
        n = len(values)
        error = float(np.std(values, ddof=1)) / sqrt(n) if n > 1 else nan
        return cls(float(np.mean(values)), error, n - 1)

    @classmethod
    def from_matched_shares(cls, differences: FloatArray) -> Estimate:
        """Return the mean of differences between yes (1) and no (0) for the same seeds.

        If all are 0, the usual error would be 0 even for few. Half an observation is added to
        each of the four cells of the table: Agresti and Min 2005, Statistics in Medicine 24:729.
        """
        return cls._of_shares(float(np.sum(differences)), float(np.sum(differences**2)), len(differences))

    @classmethod
    def _of_shares(cls, total: float, squares: float, n: int) -> Estimate:
        mean = total / (n + 2)
        variance = (squares + 1) / (n + 2) - mean**2
        return cls(mean, sqrt(variance / (n + 2)), n - 1, is_share=True)

    def scaled(self, factor: float) -> Estimate:
        """Return the estimate from as many seeds, times a factor, if the others are like these."""
        n = self.freedom + 1
        if n < 2:
            return self
        more = max(2, round(factor * n))
        if not self.is_share:
            return replace(self, error=self.error * sqrt(n / more), freedom=more - 1)
        squares = (n + 2) * ((n + 2) * self.error**2 + self.mean**2) - 1
        return self._of_shares((n + 2) * self.mean * more / n, squares * more / n, more)

    @property
    def interval(self) -> tuple[float, float]:
        """The 90 % confidence interval; a difference of shares is between -1 and 1."""
        most = 1.0 if self.is_share else inf
        if self.freedom < 1:
            return -most, most
        reach = self.error * _t().ppf(1 - ALPHA, self.freedom)
        return max(self.mean - reach, -most), min(self.mean + reach, most)

    @property
    def p_different(self) -> float:
        """Two-sided p-value of the hypothesis of no difference (Student's t)."""
        if self.freedom < 1:
            return 1.0
        if self.error == 0:
            return float(self.mean == 0)
        return float(2 * _t().sf(abs(self.mean) / self.error, self.freedom))

    def p_equivalent(self, margin: float) -> float:
        """Return the p-value of the hypothesis that the difference is at least the margin.

        Two one-sided tests: Schuirmann 1987, J. Pharmacokinet. Biopharm. 15:657.
        """
        if self.freedom < 1:
            return 1.0
        room = margin - abs(self.mean)
        if self.error == 0:
            return float(room < 0)
        return float(_t().sf(room / self.error, self.freedom))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for their number: Holm 1979, Scand. J. Stat. 6:65."""
    corrected, largest = [1.0] * len(p_values), 0.0
    for rank, index in enumerate(np.argsort(p_values)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        corrected[index] = largest
    return corrected


def pooled_sd(sds: Sequence[float]) -> float:
    """Return the standard deviation within groups of equal size: the root of the mean variance."""
    return sqrt(sum(sd**2 for sd in sds) / len(sds)) if sds else 0.0


# -- distances

_SHIFTS = np.linspace(0.0, 20.0, 2001)


def excess_of_shift(shift_sd: float) -> float:
    """Return the relative excess of the distance between two normal samples that a shift causes.

    The mean distance of members of one sample is ``2 sd / sqrt(pi)``, that of members of two is the mean of
    a folded normal; this is the excess of the second as a share of the first: 0.24 for a shift of 1 SD.
    """
    return exp(-(shift_sd**2) / 4) + shift_sd * sqrt(pi) / 2 * erf(shift_sd / 2) - 1


def shift_of_excess(excess: float) -> float:
    """Return the shift, SD, that causes an excess; 0 for an excess that is not positive."""
    return float(np.interp(excess, [excess_of_shift(shift) for shift in _SHIFTS], _SHIFTS))


def excess_values(within_a: FloatArray, between: FloatArray, within_b: FloatArray) -> FloatArray:
    """Return the pseudo-values, one for each seed, of the excess distance between two groups.

    Their mean is half the energy distance (Székely and Rizzo 2013, J. Stat. Plan. Inference 143:1249), from
    pairs of different seeds only; they are jackknife pseudo-values (Tukey 1958).

    Args:
        within_a: distances between the seeds of one group, shape ``(n, n)``, n at least 3.
        between: from the seeds of that group to those of the other, shape ``(n, n)``.
        within_b: between the seeds of the other, shape ``(n, n)``.
    """
    n = len(between)
    excess = between - (within_a + within_b) / 2
    excess = (excess + excess.T) / 2
    np.fill_diagonal(excess, 0.0)
    rows = excess.sum(axis=1)
    whole, without = rows.sum() / (n * (n - 1)), (rows.sum() - 2 * rows) / ((n - 1) * (n - 2))
    pseudo: FloatArray = n * whole - (n - 1) * without
    return pseudo


def _t() -> Any:
    """Return Student's distribution; SciPy is slow to import."""
    from scipy.stats import t

    return t


class Answer(StrEnum):
    """The factors that a value depends on."""

    AGREES = "agrees across backends"
    STABLE = "agrees across wirings"
    CONVERGED = "agrees across time steps"
    SEED = "depends on the seed only"
    BRAIN = "depends on the brain"
    WORLD = "depends on the world"
    BOTH = "depends on the brain and the world"
    WIRING = "depends on the wiring"
    TIMESTEP = "depends on the loop's time step"
    OPEN = "not decided: take more seeds"
    NONE = "not measured"

    @property
    def is_independent(self) -> bool:
        """Whether the value is independent of the compared variants: simulators, wirings or time steps."""
        return self in (Answer.AGREES, Answer.STABLE, Answer.CONVERGED, Answer.SEED)

    @property
    def is_dependent(self) -> bool:
        """Whether the value depends on the compared variants."""
        return self in (Answer.BRAIN, Answer.WORLD, Answer.BOTH, Answer.WIRING, Answer.TIMESTEP)


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
    TIMESTEP = "time step"
    """Another step of the loop than the finest."""


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
        return _AGREES.get(self.contrasts[0].factor, Answer.AGREES)

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


_AGREES = {Factor.WIRING: Answer.STABLE, Factor.TIMESTEP: Answer.CONVERGED}


def _answer_of(factors: set[Factor]) -> Answer:
    alone = {
        Factor.BRAIN: Answer.BRAIN,
        Factor.WORLD: Answer.WORLD,
        Factor.WIRING: Answer.WIRING,
        Factor.TIMESTEP: Answer.TIMESTEP,
    }
    return alone.get(next(iter(factors)), Answer.BOTH) if len(factors) == 1 else Answer.BOTH


@dataclass(frozen=True, slots=True)
class Judgement:
    """A metric with all its parts.

    Args:
        metric: the metric.
        parts: its parts, each judged separately.
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
    for answer in (Answer.OPEN, Answer.SEED, Answer.AGREES, Answer.STABLE, Answer.CONVERGED):
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
