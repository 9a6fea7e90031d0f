"""A parameter of a script: its type, unit and range, and the values that it accepts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from fractions import Fraction
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

from nrp_core.errors import ExperimentError, ParameterError, did_you_mean
from nrp_core.units import NUMBER, correct_spelling, factor

Number: TypeAlias = float | int
Value: TypeAlias = bool | int | float | str | list[Number]

_QUANTITY = re.compile(rf"\s*({NUMBER})\s*(\S.*?)?\s*\Z")
_KINDS: dict[type, str] = {
    bool: "true or false", int: "a whole number", float: "a number", str: "a text", list: "a list of numbers"
}  # fmt: skip
V = TypeVar("V", bound="bool | int | float | str | list[float] | list[int]")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A declared parameter.

    Args:
        name: an identifier.
        default: its value without any other; its type is that of all values: bool, int, float, str, or a list
            of numbers.
        unit: of its numbers, such as ``mV`` or ``Hz/mV``.
        low, high: the range of its numbers, both included.
        doc: one sentence on its effect.
        path, line: the declaration.

    Raises:
        ParameterError: the declaration contradicts itself.
    """

    name: str
    default: Value
    unit: str | None = None
    low: float | None = None
    high: float | None = None
    doc: str = ""
    path: Path | None = field(default=None, compare=False)
    line: int | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        wrong = next(self._mistakes(), None)
        if wrong is not None:
            raise ParameterError(f"parameter {self.name!r}: {wrong}", path=self.path, line=self.line)

    def value(self, given: object) -> Value:
        """Return a value for the script, in the declared type and unit.

        Args:
            given: a value, or for a number a text with its unit, ``"1.5 mV"``.

        Raises:
            ValueError: it is of another type or unit, or out of range.
        """
        match self.default:
            case list():
                if not isinstance(given, (list, tuple)):
                    raise ValueError(f"{self.name} is {given!r}; it must be {self.kind}")
                whole = bool(self.default) and all(isinstance(one, int) for one in self.default)
                return [self._number(one, int if whole else float) for one in given]
            case bool() | str():
                if type(given) is not type(self.default):
                    raise ValueError(f"{self.name} is {given!r}; it must be {self.kind}")
                return given
        return self._number(given, type(self.default))

    @property
    def kind(self) -> str:
        """The type of its values, for people."""
        of = f" in {self.unit}" if self.unit else ""
        return _KINDS[type(self.default)] + of

    @property
    def range(self) -> str:
        """The range of its numbers with the unit, or an empty text."""
        unit = f" {self.unit}" if self.unit else ""
        if self.low is not None and self.high is not None:
            return f"{self.low:g}..{self.high:g}{unit}"
        if self.low is not None:
            return f"{self.low:g}{unit} or more"
        return "" if self.high is None else f"{self.high:g}{unit} or less"

    @property
    def place(self) -> str:
        """``file:line`` of the declaration, as far as known."""
        return ExperimentError("", path=self.path and self.path.name, line=self.line).location

    def value_text(self, value: Value) -> str:
        """Return a value with its unit."""
        text = {True: "true", False: "false"}[value] if isinstance(value, bool) else repr(value)
        return f"{text} {self.unit}" if self.unit else text

    def _number(self, given: object, kind: type) -> Number:
        exact = self._exact(given)
        number: Number = int(exact) if kind is int else float(exact)
        if number != exact and kind is int:
            raise ValueError(f"{self.name} is {given!r}; it must be a whole number{_of(self.unit)}")
        if not (self.low is None or number >= self.low) or not (self.high is None or number <= self.high):
            raise ValueError(f"{self.name} is {given!r}; it must be {self.range}")
        return number

    def _exact(self, given: object) -> Fraction:
        """Return a number in the declared unit."""
        text = repr(given) if isinstance(given, (int, float)) and not isinstance(given, bool) else given
        read = _QUANTITY.match(text) if isinstance(text, str) else None
        if read is None:
            raise ValueError(f"{self.name} is {given!r}; it must be {self.kind}")
        number, unit = read.groups()
        if unit and not self.unit:
            raise ValueError(f"{self.name} is {given!r}; it has no unit")
        try:
            exact = Fraction(number) * (factor(unit, self.unit) if unit and self.unit else 1)
            float(exact)
        except (ValueError, OverflowError) as error:
            raise ValueError(f"{self.name} is {given!r}; it must be {self.kind}: {error}") from None
        return exact

    def _mistakes(self) -> Any:
        if not self.name.isidentifier():
            yield "its name must be an identifier"
        if type(self.default) not in _KINDS:
            yield f"its default is {self.default!r}; it must be {', '.join(_KINDS.values())}"
            return
        has_numbers = not isinstance(self.default, (bool, str))
        bounds = [bound for bound in (self.low, self.high) if bound is not None]
        if not has_numbers and (self.unit or bounds):
            yield f"unit, low and high are for numbers; its default is {self.default!r}"
        if self.unit and (meant := correct_spelling(self.unit)):
            yield f"its unit '{self.unit}' is not known; did you mean '{meant}'?"
        if not all(_is_number(bound) for bound in bounds):
            yield f"low and high must be finite numbers{_of(self.unit)}, not {bounds}"
        elif len(bounds) == 2 and bounds[0] > bounds[1]:
            yield f"low, {bounds[0]:g}, is above high, {bounds[1]:g}"
        numbers = self.default if isinstance(self.default, list) else [self.default] if has_numbers else []
        if not all(_is_number(one) for one in numbers):
            yield f"its default is {self.default!r}; numbers must be finite"
            return
        try:
            self.value(self.default)
        except ValueError as error:
            yield f"its default is out of range: {error}"


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)


def _of(unit: str | None) -> str:
    return f" of {unit}" if unit else ""


class GivenParameters:
    """Answers the calls of ``parameter`` in one script.

    Args:
        values: the values that the experiment gives; others have their defaults.
    """

    def __init__(self, values: Mapping[str, object] = MappingProxyType({})) -> None:
        self._values = dict(values)
        self._declared: dict[str, Parameter] = {}

    @property
    def unused(self) -> list[str]:
        """The given values that the script has not asked for so far."""
        return [name for name in self._values if name not in self._declared]

    @property
    def declared(self) -> list[str]:
        """The parameters that the script has declared so far."""
        return list(self._declared)

    @contextmanager
    def answering(self) -> Iterator[None]:
        """Answer all calls of ``parameter`` in a block, whatever the script in it imports."""
        token = _ANSWERING.set(self)
        try:
            yield
        finally:
            _ANSWERING.reset(token)

    def parameter(
        self,
        name: str,
        default: V,
        *,
        unit: str | None = None,
        low: float | None = None,
        high: float | None = None,
        doc: str = "",
    ) -> V:
        """Declare a parameter of this file and return its value: that of the experiment, or the default.

        All arguments are literals, since checks read them without executing the file.

        Args:
            name: an identifier; ``-s brain.parameters.NAME=VALUE`` sets it.
            default: a bool, int, float, str or a list of numbers; values are of its type.
            unit: of its numbers, such as ``mV``; values in other units are converted.
            low: the smallest valid number.
            high: the largest valid number.
            doc: one sentence on its effect.

        Raises:
            ExperimentError: the declaration contradicts itself or another of the same name, or the value
                does not fit.
        """
        answering = _ANSWERING.get()
        if answering is not None and answering is not self:  # the file has imported another one's function
            return answering.parameter(name, default, unit=unit, low=low, high=high, doc=doc)
        declared = Parameter(name, default, unit, low, high, doc)  # type: ignore[arg-type]
        if self._declared.setdefault(name, declared) != declared:
            raise ParameterError(f"parameter '{name}' is declared twice, with different arguments")
        try:
            found: Value = declared.value(self._values.get(name, default))
        except ValueError as error:
            raise ExperimentError(str(error)) from None
        return found  # type: ignore[return-value]


_ANSWERING: ContextVar[GivenParameters | None] = ContextVar("answering", default=None)


def fitting(
    declared: Mapping[str, Parameter], given: Mapping[str, object]
) -> tuple[dict[str, Value], dict[str, str]]:
    """Compare values with declarations.

    Returns:
        the value of each declared parameter, and by name the mistake in a given one, which then stays
        at its default.
    """
    values: dict[str, Value] = {name: one.value(one.default) for name, one in declared.items()}
    wrong: dict[str, str] = {}
    for name, value in given.items():
        if name not in declared:
            wrong[name] = f"there is no parameter '{name}'{did_you_mean(name, declared)}"
            continue
        try:
            values[name] = declared[name].value(value)
        except ValueError as error:
            wrong[name] = f"{error} (declared at {declared[name].place})"
    return values, wrong
