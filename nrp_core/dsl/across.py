"""Values that differ between the copies of an experiment, for one call of a function for all of them.

Operations give, bit for bit, what they give for each copy alone. What NumPy computes element by element with
correctly rounded results is done for all copies at once, on arrays whose first axis is the copy; everything
else is done for one copy after the other.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import partialmethod, wraps
from math import prod
from typing import Any, Final, TypeVar

import numpy as np

from nrp_core._support.arrays import FloatArray

F = TypeVar("F", bound=Callable[..., Any])


class NotTogetherError(Exception):
    """The function cannot run once for all copies."""


class Across:
    """A value in each copy; it acts like the value in a single one.

    Args:
        values: an array with a row for each copy, or else a sequence with an object for each.
        is_number: whether the value in a copy is a ``float`` of Python; else it is NumPy's or an object.
    """

    __slots__ = ("is_number", "values")
    __array_priority__ = 1000.0

    def __init__(self, values: Any, *, is_number: bool = False) -> None:
        self.values, self.is_number = values, is_number

    @staticmethod
    def of(values: Sequence[Any]) -> Any:
        """Return the values of all copies as one; as a plain value if they are all the same."""
        first = values[0]
        if len(values) == 1 or all(value is first for value in values):
            return first
        kinds = {*map(type, values)}
        if type(None) in kinds:
            raise NotTogetherError("some copies have no value yet")
        if kinds == {float}:
            return _common(np.array(values))
        if len(kinds) == 1 and isinstance(first, np.ndarray | np.generic) and first.dtype.kind in "fiub":
            if len({value.shape for value in values}) == 1:
                return Across(np.stack(values))
        elif len(kinds) == 1 and isinstance(first, bool | int | str) and values.count(first) == len(values):
            return first
        return Across(values)

    def __len__(self) -> int:
        lengths = {len(value) for value in self.each()}
        if len(lengths) > 1:
            raise NotTogetherError("lengths differ between copies")
        return lengths.pop()

    def each(self) -> Sequence[Any]:
        """Return the value in each copy."""
        return self.values.tolist() if self.is_number else self.values  # type: ignore[no-any-return]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if isinstance(self.values, np.ndarray) and (reduce := _REDUCTIONS.get(name)):
            return lambda *given, **more: self._reduced(name, reduce, given, more)
        return Across.of([getattr(value, name) for value in self.each()])

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in Across.__slots__:
            raise NotTogetherError(f"it changes the attribute '{name}' of an object of a copy")
        object.__setattr__(self, name, value)

    def _reduced(self, name: str, reduce: Any, given: Any, more: Any) -> Any:
        rows = self.values
        if given or more or self.is_number or rows.ndim == 1:
            return each_call(lambda value: getattr(value, name)(*given, **more), (self,))
        return Across(reduce(rows.reshape(len(rows), prod(rows.shape[1:])), axis=1))

    def __call__(self, *given: Any, **more: Any) -> Any:
        return each_call(lambda call, *arguments: call(*arguments, **more), (self, *given))

    def __getitem__(self, index: Any) -> Any:
        rows = self.values
        if isinstance(rows, np.ndarray) and rows.ndim > 1 and isinstance(index, _PLAIN_INDEX):
            return Across(rows[:, index])
        return each_call(operator.getitem, (self, index))

    def __bool__(self) -> bool:
        truths = {bool(value) for value in self.each()}
        if len(truths) > 1:
            raise NotTogetherError("it branches differently in different copies")
        return truths.pop()

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise NotTogetherError("it needs the value of a single copy")

    __float__ = __int__ = __index__ = __complex__ = __hash__ = __array__ = _refuse
    __iter__ = __contains__ = __setitem__ = __delitem__ = __str__ = __format__ = _refuse

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *given: Any, **more: Any) -> Any:
        if method == "__call__" and not more:
            return applied(ufunc, given)
        if "out" in more:
            raise NotTogetherError("it writes into an array")
        return each_call(lambda *one: getattr(ufunc, method)(*one, **more), given)

    def __array_function__(self, function: Any, _: Any, given: Any, more: Any) -> Any:
        fast = _FUNCTIONS.get(function)
        return fast(*given) if fast and not more else each_call(function, given, more)


_PLAIN_INDEX: Final = (int, slice, np.ndarray)
_ROUNDED: Final = {
    operator.add: np.add, operator.sub: np.subtract, operator.mul: np.multiply, operator.truediv: np.divide,
    operator.neg: np.negative, operator.abs: np.absolute, operator.lt: np.less, operator.le: np.less_equal,
    operator.gt: np.greater, operator.ge: np.greater_equal, operator.eq: np.equal, operator.ne: np.not_equal,
    operator.and_: np.logical_and, operator.or_: np.logical_or,
}  # fmt: skip
"""Operations whose results are exact or correctly rounded, as those of Python's numbers are."""
_FLOATS: Final = {np.dtype(np.float64), np.dtype(np.float32)}
_SURE: Final = frozenset({*_ROUNDED.values(), np.sqrt, np.minimum, np.maximum, np.isfinite, np.isnan})
_REDUCTIONS: Final[dict[str, Any]] = {"max": np.max, "min": np.min, "any": np.any, "all": np.all}


def applied(function: Callable[..., Any], given: Sequence[Any]) -> Any:
    """Return the result of an operation or of a function of NumPy that goes by elements."""
    ufunc = _ROUNDED.get(function, function)
    if ufunc in _SURE and (rows := _aligned(given, ufunc)) is not None:
        is_number = ufunc is not function and all(map(_is_number, given))
        result = ufunc(*rows)
        if is_number and result.dtype == bool:
            return Across.of(result.tolist())  # Python's truth values count as numbers otherwise
        return Across(result, is_number=is_number and result.dtype == float)
    return each_call(function, given)


def _aligned(given: Sequence[Any], ufunc: Any) -> list[Any] | None:
    """Return arrays that broadcast as the values of a copy do; None if results might be rounded otherwise."""
    kinds = {_dtype_of(value) for value in given} - {None}
    if np.dtype(np.float32) in kinds and _has_numbers_across(given):
        return None  # a single number of Python would be rounded to the type of the array
    truths = kinds == {np.dtype(np.bool_)} and ufunc in (np.logical_and, np.logical_or)
    if not truths and not kinds <= _FLOATS:
        return None
    ndim = max(_ndim(value) for value in given)
    rows = []
    for value in given:
        if not isinstance(value, Across):
            rows.append(value)
            continue
        shape = value.values.shape
        rows.append(value.values.reshape(shape[0], *[1] * (ndim - len(shape) + 1), *shape[1:]))
    if ufunc is np.divide and not np.all(rows[1]):
        return None  # Python's numbers raise an error
    return rows


def _dtype_of(value: Any) -> Any:
    """Return the type of the elements; None for a number of Python, which takes that of an array."""
    if isinstance(value, Across):
        return value.values.dtype if isinstance(value.values, np.ndarray) else np.dtype(object)
    if isinstance(value, np.ndarray | np.generic):
        return value.dtype
    return None if type(value) in (float, int) else np.dtype(object)


def _has_numbers_across(given: Sequence[Any]) -> bool:
    return any(isinstance(value, Across) and value.is_number for value in given)


def _is_number(value: Any) -> bool:
    return value.is_number if isinstance(value, Across) else type(value) in (float, int)


def _ndim(value: Any) -> int:
    return value.values.ndim - 1 if isinstance(value, Across) else np.ndim(value)


def _common(numbers: FloatArray) -> Any:
    """Return numbers of Python, one for each copy, as a single one if they have the same bits."""
    bits = numbers.view(np.int64)
    return numbers.item(0) if (bits == bits[0]).all() else Across(numbers, is_number=True)


def copies_in(given: Sequence[Any]) -> int:
    """Return the number of copies in arguments; 0 if all have one value for all copies."""
    return next((len(value.values) for value in given if isinstance(value, Across)), 0)


def each_call(function: Callable[..., Any], given: Sequence[Any], more: Any = None) -> Any:
    """Call a function for each copy."""
    more = more or {}
    count = copies_in((*given, *more.values()))
    if not count:
        raise NotTogetherError("values of the copies are within another object")
    columns = [value.each() if isinstance(value, Across) else [value] * count for value in given]
    named = [
        {name: value.each()[k] if isinstance(value, Across) else value for name, value in more.items()}
        for k in range(count)
    ]
    rows = zip(*columns, strict=True) if columns else [()] * count
    return Across.of([function(*row, **own) for row, own in zip(rows, named, strict=True)])


def each_copy(function: F) -> F:
    """Let a function without side effects be called for each copy, where its arguments differ."""

    @wraps(function)
    def call(*given: Any, **more: Any) -> Any:
        if copies_in((*given, *more.values())):
            return each_call(function, given, more)
        return function(*given, **more)

    return call  # type: ignore[return-value]


def _least(*given: Any) -> Any:
    """As Python's ``min`` of several numbers."""
    return _chosen(min, operator.lt, given)


def _greatest(*given: Any) -> Any:
    return _chosen(max, operator.gt, given)


def _chosen(function: Any, precedes: Any, given: Any) -> Any:
    if len(given) < 2 or not copies_in(given):
        return function(*given)
    if not all(map(_is_number, given)):
        return each_call(function, given)
    best = given[0]
    for value in given[1:]:
        rows = [one.values if isinstance(one, Across) else one for one in (value, best)]
        best = Across(np.where(precedes(*rows), *map(np.asarray, rows)).astype(float), is_number=True)
    return best


def _clip(value: Any, low: Any, high: Any) -> Any:
    is_plain = isinstance(value, Across) and not copies_in((low, high)) and _dtype_of(value).kind == "f"
    if is_plain and value.values.ndim > 1:
        return Across(np.clip(value.values, low, high))
    return each_call(np.clip, (value, low, high))


_FUNCTIONS: Final[dict[Any, Callable[..., Any]]] = {np.clip: _clip}

BUILTINS: Final[dict[str, Any]] = {
    "min": _least, "max": _greatest, "float": each_copy(float), "int": each_copy(int),
    "round": each_copy(round), "bool": bool, "abs": abs, "len": len, "range": range, "sum": sum,
    "tuple": tuple, "list": list,
}  # fmt: skip
"""The built-in functions that a function may call: none has side effects."""


def _operator(function: Callable[..., Any], reverse: bool) -> Any:
    def act(self: Across, other: Any) -> Any:
        return applied(function, (other, self) if reverse else (self, other))

    return act


def _applied_alone(self: Across, function: Callable[..., Any]) -> Any:
    return applied(function, (self,))


for _name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow", "and_", "or_"):
    _function, _word = getattr(operator, _name), _name.rstrip("_")
    setattr(Across, f"__{_word}__", _operator(_function, reverse=False))
    setattr(Across, f"__r{_word}__", _operator(_function, reverse=True))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Across, f"__{_name}__", _operator(getattr(operator, _name), reverse=False))
for _name, _function in (("neg", operator.neg), ("abs", operator.abs)):
    setattr(Across, f"__{_name}__", partialmethod(_applied_alone, _function))
