"""Built-in functions of Python 2 that Python 3 lacks or has changed.

``next`` also takes the lists that ``range`` and similar functions return, as code for Python 3 expects. They
are not iterators themselves, because libraries treat iterators as generators, which can be read only once.
"""

# ruff: noqa: A001 - the names of Python 2

from __future__ import annotations

import builtins
import codecs
import operator
from collections.abc import Callable, Iterable, Iterator
from decimal import ROUND_HALF_UP, Decimal
from functools import cached_property, cmp_to_key, reduce
from math import isfinite
from typing import Any

import numpy as np

__all__ = [
    "apply", "basestring", "buffer", "cmp", "divide", "filter", "intern", "long", "map", "next", "next_of",
    "ord", "range", "raw_input", "reduce", "reload", "sort", "sorted", "unichr", "unicode", "xrange", "zip",
]  # fmt: skip

basestring = unicode = str
long = int
unichr, raw_input, xrange, buffer = chr, input, builtins.range, memoryview


class Listed(list[Any]):
    """A list of which :func:`next` returns one item after the other."""

    @cached_property
    def rest(self) -> Iterator[Any]:
        """The items that have not been returned."""
        return iter(list(self))


def next(items: Any, *default: Any) -> Any:
    """Return the next item of an iterator, or of a list that replaces one."""
    return builtins.next(items.rest if isinstance(items, Listed) else items, *default)


def range(*bounds: Any) -> list[int]:
    """Return whole numbers; bounds may be numbers that divisions gave."""
    return Listed(builtins.range(*bounds))


def map(function: Callable[..., Any] | None, *items: Iterable[Any]) -> list[Any]:
    """Return the result of a function for each item; without a function, the items."""
    if function is None:
        return Listed(builtins.zip(*items, strict=False) if len(items) > 1 else items[0])
    return Listed(builtins.map(function, *items))


def filter(function: Callable[[Any], Any] | None, items: Iterable[Any]) -> Any:
    """Return the items for which a function is true; for a text or tuple, a text or tuple."""
    chosen = Listed(builtins.filter(function, items))
    if isinstance(items, tuple):
        return tuple(chosen)
    return "".join(chosen) if isinstance(items, str) else chosen


def zip(*items: Iterable[Any], **options: Any) -> list[Any]:
    """Return tuples of items."""
    return Listed(builtins.zip(*items, strict=bool(options.get("strict"))))


def cmp(left: Any, right: Any) -> int:
    """Return -1, 0 or 1."""
    return int(left > right) - int(left < right)


def sorted(
    items: Iterable[Any], cmp: Callable[[Any, Any], int] | None = None, key: Any = None, reverse: bool = False
) -> list[Any]:
    """Return items in order."""
    return builtins.sorted(items, key=_key(cmp, key), reverse=reverse)


def sort(items: Any, *values: Any, cmp: Any = None, **options: Any) -> Any:
    """Sort a list by a comparison function; other objects by their own method."""
    compare = values[0] if values and callable(values[0]) else cmp
    if compare is None:
        return items.sort(*values, **options)
    return items.sort(key=_key(compare, options.pop("key", None)), **options)


def _key(compare: Callable[[Any, Any], int] | None, key: Any) -> Any:
    if compare is None:
        return key
    by = cmp_to_key(compare)
    return by if key is None else lambda item: by(key(item))


def ord(character: Any) -> int:
    """Return the number of a character, or of a byte, which is one already."""
    return int(character) if isinstance(character, (int, np.integer)) else builtins.ord(character)


def round_of(number: Any, ndigits: int = 0) -> Any:
    """Return a number rounded as Python 2 did: halves go away from zero, and the result is a float."""
    if np.size(number) != 1:
        return np.round(number, ndigits)  # the function of the same name, which code may have imported
    value = float(_only(number))
    if not isfinite(value):
        return value
    unit = Decimal(1).scaleb(-int(ndigits))
    return float((Decimal(value) / unit).to_integral_value(ROUND_HALF_UP) * unit)


def float_of(value: Any = 0.0) -> float:
    """Return a number, or an array with one, as a float."""
    return float(_only(value))


def int_of(value: Any = 0, *base: int) -> int:
    """Return a number, or an array with one, as an integer."""
    return int(_only(value), *base)


def _only(value: Any) -> Any:
    return value.item() if isinstance(value, np.ndarray) and value.size == 1 else value


def reload(module: Any) -> Any:
    """Return a module unchanged."""
    return module


def apply(function: Callable[..., Any], values: Iterable[Any] = (), options: Any = None) -> Any:
    """Return the result of a function."""
    return function(*values, **(options or {}))


def intern(text: str) -> str:
    """Return a text."""
    return text


def next_of(items: Any) -> Any:
    """Return the next item: ``items.next()``."""
    return items.next() if hasattr(items, "next") else next(items)


def text_of(value: Any, encoding: str = "ascii", *errors: str) -> Any:
    """Return a text encoded or decoded: unchanged, except for hexadecimal digits."""
    if encoding in ("hex", "base64"):
        return codecs.encode(value.encode("latin-1"), encoding).decode("ascii").strip()
    return value.decode(encoding, *errors) if isinstance(value, bytes) else value


def compared(sign: str, left: Any, right: Any) -> Any:
    """Return whether a comparison holds; None is less than anything else."""
    if left is None or right is None:
        left, right = (left is not None, right is not None)
    return getattr(operator, sign)(left, right)


def message_of(error: BaseException) -> Any:
    """Return the message of an error: ``error.message``."""
    return getattr(error, "message", error.args[0] if error.args else "")


def bytes_of(value: Any) -> Any:
    """Return the bytes of an array: ``array.tostring()``."""
    return value.tostring() if hasattr(value, "tostring") else value.tobytes()


def ptp_of(value: Any, *values: Any, **options: Any) -> Any:
    """Return the range of the numbers of an array: ``array.ptp()``."""
    return value.ptp(*values, **options) if hasattr(value, "ptp") else np.ptp(value, *values, **options)


def itemset_of(array: Any, *values: Any) -> None:
    """Set one number of an array: ``array.itemset(place, number)``, or ``(row, column, number)``."""
    *place, number = values
    if len(place) == 1 and not isinstance(place[0], tuple):
        array.flat[place[0]] = number
    else:
        array[place[0] if len(place) == 1 else tuple(place)] = number


def rgb_of(canvas: Any) -> bytes:
    """Return the pixels of a figure: ``canvas.tostring_rgb()``."""
    return np.asarray(canvas.buffer_rgba())[..., :3].tobytes()


class Quotient(float):
    """A quotient of whole numbers, which can be an index as in Python 2."""

    def __index__(self) -> int:
        return int(self // 1)

    def __add__(self, other: Any) -> Any:
        return _again(float.__add__(self, other), other)

    def __sub__(self, other: Any) -> Any:
        return _again(float.__sub__(self, other), other)

    def __mul__(self, other: Any) -> Any:
        return _again(float.__mul__(self, other), other)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Any:
        return _again(float.__rsub__(self, other), other)

    def __neg__(self) -> Quotient:
        return Quotient(-float(self))


def index_of(index: Any) -> Any:
    """Return an index for a float or a text of digits, as NumPy accepted until version 1.11.

    It is still equal to it, so that a dictionary finds it.
    """
    if isinstance(index, (float, np.floating)):
        return index if isinstance(index, Quotient) or not isfinite(index) else Index(index)
    if isinstance(index, tuple):
        return tuple(map(index_of, index))
    if isinstance(index, str):
        return Digits(index) if index.removeprefix("-").isdecimal() else index
    if isinstance(index, np.ndarray) and index.dtype.kind == "f":
        return index.astype(np.intp)
    if isinstance(index, list) and any(isinstance(each, (float, np.floating)) for each in index):
        return [int(each) for each in index]
    return index


class Index(float):
    """A float that is used as an index: it is truncated."""

    def __index__(self) -> int:
        return int(self)


class Digits(str):
    """A text that is used as an index, as those in the rows of a CSV file: it is read as a number."""

    __slots__ = ()

    def __index__(self) -> int:
        return int(str(self))  # of the text alone, for int() would call this again


def _again(value: Any, other: Any) -> Any:
    """Return a number that can be an index, if it was computed from such numbers."""
    return Quotient(value) if value is not NotImplemented and isinstance(other, (int, Quotient)) else value


def divide(left: Any, right: Any) -> Any:
    """Divide as Python 2: of whole numbers, the quotient rounded down."""
    return left // right if _is_whole(left) and _is_whole(right) else left / right


def quotient(left: Any, right: Any) -> Any:
    """Divide as Python 3; the quotient can be an index as in Python 2."""
    value = left / right
    whole = _is_whole(left) and _is_whole(right)
    return Quotient(value) if whole and not hasattr(value, "__len__") else value


def _is_whole(value: Any) -> bool:
    """Whether a number, or all numbers of an array, are integers."""
    return isinstance(value, int) or getattr(getattr(value, "dtype", None), "kind", "") in ("i", "u")
