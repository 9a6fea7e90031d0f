"""Which values a type hint admits, as users mean it, and the hint in words."""

from __future__ import annotations

from collections.abc import Callable as CallableABC
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum
from itertools import islice
from numbers import Integral
from os import PathLike
from pathlib import PurePath
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

from nrp_core._support.numbers import is_number

_LOOKED_AT: Final = 1000
"""Items of a list that are looked at."""
_ONE: Final = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    str: "a text",
    NoneType: "None",
}
_SEVERAL: Final = {int: "whole numbers", float: "numbers", str: "texts"}
_FLAGS: Final = "b"
_NUMBERS: Final = "biuf"
"""NumPy's kind codes of real numbers."""


_FUNCTION: Final[Any] = CallableABC


def admits(hint: Any, value: object) -> bool:
    """Return whether a value is of the kind that a hint means.

    Numbers of NumPy are numbers, a truth value is not one, a text is not a list, and lists, tuples and arrays
    may stand for each other. What this knows nothing of, it admits.
    """
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return admits(parts[0], value)
    if origin in (Union, UnionType):
        if _is_array_like(parts):
            return (value is None and NoneType in parts) or _are_numbers(value)
        return any(admits(part, value) for part in parts)
    if origin is Literal:
        return any(isinstance(value, type(part)) and value == part for part in parts)
    kind = origin or hint
    if not isinstance(kind, type) or kind in (Any, object):
        return True
    return _admits_type(kind, parts, value)


def _admits_type(kind: type, parts: tuple[Any, ...], value: object) -> bool:
    simple = {
        bool: lambda: isinstance(value, bool) or _dtype_kind(value) == _FLAGS,
        int: lambda: isinstance(value, Integral) and not isinstance(value, bool),
        float: lambda: is_number(value),
        type: lambda: isinstance(value, type),
        CallableABC: lambda: callable(value),
    }
    if kind in simple:
        return simple[kind]()
    if issubclass(kind, PurePath):
        return isinstance(value, PathLike)
    if issubclass(kind, Enum):
        return isinstance(value, kind) or (isinstance(value, str) and value in [*kind])
    if issubclass(kind, Mapping):
        return isinstance(value, Mapping) and (not parts or _admits_items(parts, value))
    if kind.__module__ == "numpy":
        return kind.__name__ != "ndarray" or _is_listed(value)
    if kind not in (str, bytes) and issubclass(kind, Iterable) and kind.__module__ in _CONTAINERS:
        is_kept = not (issubclass(kind, Sequence) and isinstance(value, Mapping))
        return is_kept and _is_listed(value) and _admits_each(kind, parts, value)
    if getattr(kind, "_is_protocol", False):
        return callable(value) or "__call__" not in vars(kind)
    return isinstance(value, kind)


_CONTAINERS: Final = frozenset({"builtins", "collections.abc"})


def _admits_items(parts: tuple[Any, ...], value: Mapping[Any, Any]) -> bool:
    key, item = parts
    return all(admits(key, name) and admits(item, one) for name, one in islice(value.items(), _LOOKED_AT))


def _admits_each(kind: type, parts: tuple[Any, ...], value: Any) -> bool:
    """Return whether items are of the right kinds; those of an iterator are not looked at."""
    if kind is tuple and parts and parts[-1] is not Ellipsis:
        return hasattr(value, "__len__") and len(value) == len(parts) and all(map(admits, parts, value))
    if not parts or not isinstance(value, list | tuple | set | frozenset):
        return True
    return all(admits(parts[0], one) for one in islice(value, _LOOKED_AT))


def _is_listed(value: object) -> bool:
    return hasattr(value, "__iter__") and not isinstance(value, str | bytes)


def _dtype_kind(value: object) -> str:
    return str(getattr(getattr(value, "dtype", None), "kind", ""))


def _is_array_like(parts: tuple[Any, ...]) -> bool:
    """Return whether these are the parts of NumPy's ``ArrayLike``."""
    return any(getattr(get_origin(part) or part, "__name__", "") == "_SupportsArray" for part in parts)


def _are_numbers(value: object) -> bool:
    import numpy as np

    try:
        return np.asarray(value).dtype.kind in _NUMBERS
    except (ValueError, TypeError):
        return False


def in_words(hint: Any) -> str:
    """Return what a hint asks for, such as ``a number or None``."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return in_words(parts[0])
    if origin in (Union, UnionType):
        if _is_array_like(parts):
            return "a number, or numbers"
        return _joined(_without_repeated_paths([in_words(part) for part in parts]))
    if origin is Literal:
        return _joined([repr(part) for part in parts])
    kind = origin or hint
    if kind in _ONE:
        return _ONE[kind]
    return _type_in_words(kind, parts) if isinstance(kind, type) else str(hint)


def _type_in_words(kind: type, parts: tuple[Any, ...]) -> str:
    if kind is _FUNCTION or (getattr(kind, "_is_protocol", False) and "__call__" in vars(kind)):
        return "a function"
    if kind is type:
        return "a class"
    if issubclass(kind, PurePath | PathLike):
        return "a path"
    if issubclass(kind, Enum):
        return _joined([repr(getattr(one, "value", one)) for one in kind])
    if issubclass(kind, Mapping):
        return "a dictionary"
    if kind is tuple and parts and parts[-1] is not Ellipsis:
        return f"{len(parts)} {_SEVERAL.get(parts[0], 'values')}"
    if kind.__module__ == "numpy":
        return "an array"
    if kind.__module__ in _CONTAINERS:
        return f"a list of {_SEVERAL.get(parts[0]) or _each(parts[0])}" if parts else "a list"
    return f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"


def _each(hint: Any) -> str:
    words = in_words(hint)
    return "paths" if words == "a path" else f"items that are each {words}"


def _without_repeated_paths(words: list[str]) -> list[str]:
    """Return alternatives without "a text" where a path may be given, which is a text."""
    return [one for one in dict.fromkeys(words) if not (one == "a text" and "a path" in words)]


def _joined(words: list[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
