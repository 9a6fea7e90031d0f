"""The values of one setting in a sweep: a list, a span, or a range from which each seed draws."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import exp, log
from typing import Any, TypeAlias

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import did_you_mean
from nrp_core.experiment.model.ranges import Range
from nrp_core.quantities import TIME_UNITS

Value: TypeAlias = "bool | int | float | str | list[Any]"
"""A value of a setting, as in an experiment file."""

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")
_KEYS = ("from", "to", "steps", "scale")
_SCALES = ("linear", "log")
_DIGITS = 12  # significant digits: enough for any setting, and short in a table


@dataclass(frozen=True, slots=True)
class Choices:
    """A list of values, in any order."""

    levels: tuple[Value, ...]

    def __len__(self) -> int:
        return len(self.levels)

    def at(self, share: float) -> Value:
        """Return the value at a fraction of the list, from 0 up to 1."""
        return self.levels[min(int(share * len(self.levels)), len(self.levels) - 1)]


@dataclass(frozen=True)
class Span:
    """The numbers from one to another.

    Args:
        low, high: the ends; both are included.
        unit: their unit; may be empty.
        steps: number of values in a grid; None: every whole number.
        is_log: whether values are spaced logarithmically.
        is_whole: whether all values are whole numbers.
    """

    low: float
    high: float
    unit: str = ""
    steps: int | None = None
    is_log: bool = False
    is_whole: bool = False

    def __len__(self) -> int:
        if self.steps is not None:
            return self.steps
        return int(self.high - self.low) + 1 if self.is_whole else 0

    @cached_property
    def levels(self) -> tuple[Value, ...]:
        """The values of a grid; empty for a span of real numbers without ``steps``."""
        if self.steps is None:
            return tuple(range(int(self.low), int(self.high) + 1)) if self.is_whole else ()
        gaps = max(self.steps - 1, 1)
        return tuple(self._value(self._number(step / gaps)) for step in range(self.steps))

    def at(self, share: float) -> Value:
        """Return the value at a fraction of the span, from 0 up to 1."""
        if levels := self.levels:
            return Choices(levels).at(share)
        return self._value(self._number(share))

    @property
    def ends(self) -> tuple[Value, Value]:
        """The first and the last value."""
        return self._value(self.low), self._value(self.high)

    def _number(self, share: float) -> float:
        if self.is_log:
            return exp(log(self.low) + share * (log(self.high) - log(self.low)))
        return self.low + share * (self.high - self.low)

    def _value(self, number: float) -> Value:
        number = float(f"{number:.{_DIGITS}g}")
        if self.is_whole:
            return round(number)
        if self.unit in TIME_UNITS:
            number = seconds(round(number * TIME_UNITS[self.unit] * NS_PER_S)) / TIME_UNITS[self.unit]
        return f"{number:.{_DIGITS}g} {self.unit}" if self.unit else number


Axis: TypeAlias = Choices | Span | Range


def axis_of(value: object) -> Axis:
    """Read the values of a setting.

    Raises:
        ValueError: they have another form.
    """
    match value:
        case Choices() | Span() | Range():
            return value
        case Mapping():
            return _span(value)
        case list():
            return _choices(value)
        case str() if ".." in value:
            return Range.parse(value)
    raise ValueError(
        f"expected a list of values, {{from: 0.5, to: 2, steps: 7}}, or a range to draw from with each "
        f"seed, such as 4..8 s; not {value!r}"
    )


def _choices(values: list[Any]) -> Choices:
    if not values:
        raise ValueError("the list of values is empty")
    seen: set[str] = set()
    for value in values:
        if isinstance(value, Mapping) or value is None:
            raise ValueError(f"a value is a number, a string, true, false or a list, not {value!r}")
        if repr(value) in seen:  # 1 and true are equal in Python
            raise ValueError(f"the value {value!r} appears twice")
        seen.add(repr(value))
    return Choices(tuple(values))


def _span(given: Mapping[str, Any]) -> Span:
    for key in given:
        if key not in _KEYS:
            raise ValueError(f"a span has no key '{key}'{did_you_mean(key, _KEYS)}")
    if missing := [key for key in ("from", "to") if key not in given]:
        raise ValueError(f"a span needs '{missing[0]}', as in {{from: 0.5, to: 2, steps: 7}}")
    (low, unit), (high, other) = _quantity(given["from"]), _quantity(given["to"])
    if unit != other:
        raise ValueError(f"both ends need the same unit, not '{given['from']}' and '{given['to']}'")
    if not low < high:
        raise ValueError(f"'to' of a span must be above 'from', not {given['from']} to {given['to']}")
    steps, scale = given.get("steps"), given.get("scale", "linear")
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int) or steps < 2):
        raise ValueError(f"'steps' is the number of values, at least 2, not {steps!r}")
    if scale not in _SCALES:
        raise ValueError(f"'scale' is linear or log, not {scale!r}")
    if scale == "log" and low <= 0:
        raise ValueError(f"a logarithmic scale needs values above 0, not {given['from']}")
    ends_whole = all(isinstance(given[key], int) for key in ("from", "to"))
    whole = ends_whole and scale == "linear" and (steps is None or (high - low) % (steps - 1) == 0)
    return Span(low, high, unit, steps, scale == "log", whole)


def _quantity(value: object) -> tuple[float, str]:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value), ""
    if isinstance(value, str) and (found := _QUANTITY.fullmatch(value)):
        return float(found[1]), found[2]
    raise ValueError(f"an end of a span is a number, with or without a unit, not {value!r}")


def written(key: str, value: Value) -> str:
    """Return a setting as an override, ``dotted.key=value``."""
    return f"{key}={value if isinstance(value, str) else json.dumps(value)}"
