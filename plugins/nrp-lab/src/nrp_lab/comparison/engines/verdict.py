"""The verdict on the engines: they agree, or their differences, the largest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import groupby
from math import inf

from nrp_core._support.words import first_of
from nrp_lab.comparison.engines.measures import Measure

_MOST_NAMED = 4


class Agreement(StrEnum):
    """The verdict on the engines."""

    AGREE = "the engines agree"
    KNOWN = "the engines differ as known"
    DIFFER = "the engines differ"
    NONE = "the engines were not compared"


@dataclass(frozen=True, slots=True)
class EngineDifference:
    """One part of a measure between two engines that had the same inputs.

    Args:
        side: ``brain`` or ``world``; of two recordings ``run``.
        one, other: names of the engines.
        measure: the measure.
        part: the signal, robot or neurons.
        amount: the difference, other minus one where it has a sign, in the measure's unit.
        margin: the largest difference that does not matter, in the same unit.
        is_known: whether a baseline has it.
    """

    side: str
    one: str
    other: str
    measure: Measure
    part: str
    amount: float
    margin: float
    is_known: bool = False

    @property
    def size(self) -> float:
        """The difference in units of its margin."""
        return abs(self.amount) / self.margin

    @property
    def matters(self) -> bool:
        """Whether it is beyond its margin."""
        return self.size > 1

    @property
    def key(self) -> str:
        """Its name in a baseline."""
        return f"{self.side} {self.one} -> {self.other}: {self.measure.name}/{self.part}"

    @property
    def effect(self) -> str:
        """The difference as a text."""
        if abs(self.amount) == inf:
            return "only one of them has it"
        return f"{self.amount:.3g} {self.measure.unit}, {self.size:.2g} x its margin"


@dataclass(frozen=True)
class EngineVerdict:
    """The engines compared.

    Args:
        differences: every part of every measure, the largest in units of its margin first.
        problems: the reasons why the comparison is incomplete, such as an engine that failed.
    """

    differences: Sequence[EngineDifference]
    problems: Sequence[str] = ()

    @property
    def new(self) -> list[EngineDifference]:
        """The differences that matter and are not in a baseline."""
        return [one for one in self.differences if one.matters and not one.is_known]

    @property
    def known(self) -> list[EngineDifference]:
        """The differences that matter and are in a baseline."""
        return [one for one in self.differences if one.matters and one.is_known]

    @property
    def agreement(self) -> Agreement:
        """The verdict."""
        if self.new:
            return Agreement.DIFFER
        if self.problems or not self.differences:
            return Agreement.NONE
        return Agreement.KNOWN if self.known else Agreement.AGREE

    @property
    def agrees(self) -> bool:
        """Whether the engines agree, apart from known differences."""
        return self.agreement in (Agreement.AGREE, Agreement.KNOWN)

    @property
    def headline(self) -> str:
        """The verdict in a sentence that names the largest differences."""
        match self.agreement:
            case Agreement.DIFFER:
                partly = (
                    f"Not compared to the end ({'; '.join(self.problems)}): the" if self.problems else "The"
                )
                return f"{partly} engines differ in {_named(self.new)}"
            case Agreement.NONE:
                reasons = "; ".join(self.problems) or "they have no common signals"
                return f"The engines were not compared: {reasons}"
            case Agreement.KNOWN:
                return f"The engines agree, apart from {len(self.known)} known differences"
            case _:
                return f"The engines agree: {len(self.differences)} measurements are within their margins"


NOT_COMPARED = EngineVerdict(())
"""The verdict where nothing was measured."""


def ranked(differences: Sequence[EngineDifference]) -> list[EngineDifference]:
    """Return differences, the largest in units of its margin first."""
    return sorted(differences, key=lambda one: -one.size)


def _named(differences: Sequence[EngineDifference]) -> str:
    """Name the worst part of each measure between two engines, the largest first."""

    def title(one: EngineDifference) -> tuple[str, str, str, str]:
        return one.side, one.one, one.other, one.measure.name

    groups = [next(iter(group)) for _, group in groupby(sorted(differences, key=title), title)]
    worst = ranked(groups)
    names = [
        f"{one.measure.title} ({one.side} {one.one} -> {one.other}, {one.part}: {one.effect})"
        for one in worst
    ]
    return first_of(names, _MOST_NAMED, "; ")
