"""Conditions on the values of observables, as criteria, events, sweeps and environments use them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from numbers import Real
from typing import Any

from nrp_core._support.checked_arguments import is_number
from nrp_core.errors import ExperimentError
from nrp_core.observables.observable import Observable
from nrp_core.units import NUMBER, factor

_QUANTITY = re.compile(rf"\s*({NUMBER})\s*(.*?)\s*\Z")


def quantity_of(written: Any, unit: str = "") -> tuple[str, str]:
    """Return a number as a text, and its own unit, which may be empty.

    Raises:
        ExperimentError: it is no number.
    """
    if isinstance(written, Real) and not isinstance(written, bool):
        return str(written), ""
    match = _QUANTITY.match(written) if isinstance(written, str) else None
    if match is None:
        raise ExperimentError(f"not a number{f' in {unit}' if unit else ''}: {written!r}")
    return match[1], match[2]


def value_in(written: Any, unit: str) -> float:
    """Return a number in a unit, as ``20``, or with its own as ``20 Hz``.

    Raises:
        ExperimentError: it is no number, or has a unit of another kind.
    """
    number, own = quantity_of(written, unit)
    if not own or own == unit:
        return float(number)
    try:
        return float(Fraction(number) * Fraction(factor(own, unit)))
    except ValueError as error:
        raise ExperimentError(f"'{written}' is not in {unit or 'a number without a unit'}: {error}") from None


@dataclass(frozen=True)
class Condition:
    """A range of values, or one value.

    Args:
        above: the lower bound, or None.
        below: the upper bound.
        equals: the only value.
        reaches: whether the bounds themselves belong to the range.
    """

    above: float | None = None
    below: float | None = None
    equals: Any = None
    reaches: bool = False

    def gap(self, value: Any) -> float:
        """Return how far a value is outside of the range; negative: how far inside."""
        if self.equals is not None and value != self.equals:
            return inf
        gaps = [] if self.above is None else [self.above - value]
        gaps += [] if self.below is None else [value - self.below]
        return max(gaps, default=-inf)

    def holds(self, value: Any) -> bool:
        """Whether a value is in the range; None is not."""
        if value is None:
            return False
        gap = self.gap(value)
        return bool(gap <= 0 if self.reaches else gap < 0)

    def room(self, value: Any) -> float:
        """Return how much a value may change before it can pass a bound."""
        above, below = self.above, self.below
        if above is None or below is None:
            return 0.0 if above is below else float(abs(value - (below if above is None else above)))
        return float(min(abs(value - above), abs(value - below)))

    def text(self, unit: str = "") -> str:
        """Return the condition in words, such as ``above 1 m``."""
        ending = f" {unit}" if unit else ""
        if self.above is not None and self.below is not None and self.equals is None and self.reaches:
            return f"between {_short(self.above)} and {_short(self.below)}{ending}"
        bounds = {"above": self.above, "below": self.below, "equal to": self.equals}
        given = {how: _short(bound) for how, bound in bounds.items() if bound is not None}
        return " and ".join(f"{how} {bound}{ending}" for how, bound in given.items())


def _short(value: Any) -> str:
    """Return a value in words; a number that was converted, such as 36 deg in rad, with six digits."""
    text = str(value)
    return f"{value:.6g}" if isinstance(value, float) and len(text) > 10 else text


class Sentence:
    """An observable and a condition on it.

    Args:
        observable: the observable.
        condition: the condition.

    Attributes:
        value: the value at the last moment read; None: it had none.
        hears: whether messages change the value.
    """

    def __init__(self, observable: Observable, condition: Condition) -> None:
        self.observable, self.condition = observable, condition
        self.hears = observable.hears
        self.value: Any = None

    def holds(self, now_ns: int) -> bool:
        """Whether the condition holds at a moment, which is not before the previous one."""
        self.value = self.observable.value(now_ns)
        return self.condition.holds(self.value)

    def news(self) -> Sequence[int]:
        """Return the times of the messages that came since the last call, ns."""
        return self.observable.news()

    def unchanged_ns(self, now_ns: int) -> int | None:
        """Return the time for which the condition cannot change, ns; None: until the next message."""
        return self.observable.unchanged_ns(self.condition.room)

    def look(self, now_ns: int) -> None:
        """Keep the value at a physics step between two steps of the loop."""
        self.observable.look(now_ns)

    @property
    def wanted(self) -> str:
        """The condition in words."""
        return self.condition.text(self.observable.unit)

    def value_text(self) -> str:
        """Return the last value in words."""
        if self.value is None:
            return "without a value"
        if not is_number(self.value):
            return repr(self.value)
        return f"{self.value:.6g} {self.observable.unit}".rstrip()
