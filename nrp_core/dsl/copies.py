"""The parameters of a vectorised function: those of all copies of an experiment, with a row for each copy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import partial, wraps
from inspect import signature
from typing import Any, Final, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

_NUMBERS: Final = (bool, int, float, np.number, np.bool_)


class Copies:
    """One object for each copy.

    An attribute of numbers or arrays is one array, whose first axis is that of the copies; any other
    attribute is a :class:`Copies` again. A value that is set, or passed to a method, is an array with a row
    for each copy, a message of such arrays, or any other value, which all copies share.

    Args:
        each: the object of each copy; an iteration gives them.
    """

    __slots__ = ("_each",)

    def __init__(self, each: Sequence[Any]) -> None:
        object.__setattr__(self, "_each", each)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._each)

    def __getitem__(self, index: Any) -> Any:
        return gathered([one[index] for one in self._each])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        kind, *others = {*map(type, self._each)}
        attribute = None if others else getattr(kind, name, None)
        if attribute is not None and hasattr(attribute, "of_copies"):
            return attribute.of_copies(self._each)
        together = None if others else getattr(kind, f"{name}_of_copies", None)
        if together is not None:
            return partial(together, self._each)
        return gathered([getattr(one, name) for one in self._each])

    def __setattr__(self, name: str, value: Any) -> None:
        for one, row in zip(self._each, rows_of(value, len(self._each)), strict=True):
            setattr(one, name, row)

    def __call__(self, *values: Any, **named: Any) -> Any:
        n = len(self._each)
        rows = list(zip(*(rows_of(value, n) for value in values), strict=True)) or [()] * n
        options = list(zip(*(rows_of(value, n) for value in named.values()), strict=True)) or [()] * n
        calls = zip(self._each, rows, options, strict=True)
        return gathered([one(*row, **dict(zip(named, own, strict=True))) for one, row, own in calls])

    def __bool__(self) -> bool:
        raise TypeError(f"{self!r} are not one truth value; iterate over them")

    def __eq__(self, other: object) -> bool:
        raise TypeError(f"{self!r} are not equal or different as a whole; iterate over them")

    __hash__ = None  # type: ignore[assignment]  # as of any other object that defines __eq__

    def __repr__(self) -> str:
        return f"<{len(self._each)} copies of {self._each[0]!r:.60}>"


def gathered(each: list[Any]) -> Any:
    """Return a value of each copy as one read-only array or as :class:`Copies`; None if each is None."""
    kinds = {*map(type, each)}
    if kinds == {type(None)}:
        return None
    if kinds == {np.ndarray}:
        are_alike = len({one.shape for one in each}) == 1
    elif kinds == {list}:
        are_alike = len({*map(len, each)}) == 1 and all(map(_are_numbers, each))
    else:
        are_alike = _are_numbers(each)
    if not are_alike:
        return Copies(each)
    rows = np.array(each)
    rows.flags.writeable = False  # a change would be lost
    return rows


def _are_numbers(values: Iterable[Any]) -> bool:
    return all(issubclass(kind, _NUMBERS) for kind in {*map(type, values)})


def rows_of(value: Any, n: int) -> Sequence[Any]:
    """Return the part of a value for each of ``n`` copies.

    Raises:
        ValueError: an array does not have a row for each copy.
    """
    if isinstance(value, np.ndarray) and value.ndim:
        if len(value) != n:
            raise ValueError(f"an array of shape {value.shape} does not have a row for each of {n} copies")
        return value.tolist() if value.ndim == 1 else list(value)
    if isinstance(value, Copies):
        return list(value)
    if is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, field.name) for field in fields(value)]
        if any(isinstance(part, (np.ndarray, Copies)) or is_dataclass(part) for part in parts):
            kind: Any = type(value)
            return [kind(*row) for row in zip(*(rows_of(part, n) for part in parts), strict=True)]
    return [value] * n


def for_copies(function: F) -> F:
    """Let a function take :class:`Copies` for its first parameter as well."""
    first = next(iter(signature(function).parameters))

    @wraps(function)
    def call(*values: Any, **named: Any) -> Any:
        given = values[0] if values else named.get(first)
        if not isinstance(given, Copies):
            return function(*values, **named)
        named.pop(first, None)
        return gathered([function(one, *values[1:], **named) for one in given])

    return cast("F", call)
