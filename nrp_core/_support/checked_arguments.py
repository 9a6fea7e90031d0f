"""Functions of the public interface that check their arguments against their type hints.

mypy finds a wrong argument before a program runs, but notebooks are rarely checked by it. This is the one
place where kinds are checked. Ranges, and relations between arguments, are checked by the function.
"""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from collections.abc import Callable as CallableABC
from dataclasses import fields
from enum import Enum
from functools import cache, wraps
from inspect import Parameter, Signature, signature
from itertools import islice
from numbers import Integral, Real
from os import PathLike
from pathlib import PurePath
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, ParamSpec, TypeGuard, TypeVar, Union, get_args, get_origin

from nrp_core.errors import ArgumentError, did_you_mean

_LOOKED_AT: Final = 1000
"""Items of a list that are looked at."""
_SINGULAR: Final = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    str: "a text",
    NoneType: "None",
}
_PLURAL: Final = {int: "whole numbers", float: "numbers", str: "texts"}
_FLAGS: Final = "b"
_NUMBERS: Final = "biuf"
"""NumPy's kind codes of real numbers."""


_CALLABLE: Final[Any] = CallableABC


_SIMPLE: Final = frozenset({str, int, float, bool})


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a real number, of Python or NumPy; a truth value is none."""
    return isinstance(value, Real) and not isinstance(value, bool)


def admits(hint: Any, value: object) -> bool:
    """Return whether a value is of the kind that a hint means.

    Numbers of NumPy are numbers, a truth value is not one, a text is not a list, and lists, tuples and arrays
    may stand for each other. Unknown hints admit every value.
    """
    if type(value) is hint and hint in _SIMPLE:
        return True  # most values
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return admits(parts[0], value)
    if _is_array_like(hint):
        return (value is None and NoneType in parts) or _are_numbers(value)
    if origin in (Union, UnionType):
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
    """Return whether items have the right types; items of an iterator are not checked."""
    if kind is tuple and parts and parts[-1] is not Ellipsis:
        return hasattr(value, "__len__") and len(value) == len(parts) and all(map(admits, parts, value))
    if not parts or not isinstance(value, list | tuple | set | frozenset):
        return True
    return all(admits(parts[0], one) for one in islice(value, _LOOKED_AT))


def _is_listed(value: object) -> bool:
    return hasattr(value, "__iter__") and not isinstance(value, str | bytes)


def _dtype_kind(value: object) -> str:
    return str(getattr(getattr(value, "dtype", None), "kind", ""))


def _is_array_like(hint: Any) -> bool:
    """Return whether a hint is NumPy's ``ArrayLike``, or a union with it.

    It is an alias with a name from Python 3.12 on, and before that a union itself.
    """
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    names = {getattr(get_origin(part) or part, "__name__", "") for part in parts}
    return not names.isdisjoint(("ArrayLike", "_SupportsArray"))


def _are_numbers(value: object) -> bool:
    import numpy as np

    try:
        return np.asarray(value).dtype.kind in _NUMBERS
    except (ValueError, TypeError):
        return False


def in_words(hint: Any) -> str:
    """Return a description of a type hint, such as ``a number or None``."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return in_words(parts[0])
    if _is_array_like(hint):
        return "a number, or numbers"
    if origin in (Union, UnionType):
        return _join_words(_without_repeated_paths([in_words(part) for part in parts]))
    if origin is Literal:
        return _join_words([repr(part) for part in parts])
    kind = origin or hint
    if kind in _SINGULAR:
        return _SINGULAR[kind]
    return _type_in_words(kind, parts) if isinstance(kind, type) else str(hint)


def _type_in_words(kind: type, parts: tuple[Any, ...]) -> str:
    if kind is _CALLABLE or (getattr(kind, "_is_protocol", False) and "__call__" in vars(kind)):
        return "a function"
    if kind is type:
        return "a class"
    if issubclass(kind, PurePath | PathLike):
        return "a path"
    if issubclass(kind, Enum):
        return _join_words([repr(getattr(one, "value", one)) for one in kind])
    if issubclass(kind, Mapping):
        return "a dictionary"
    if kind is tuple and parts and parts[-1] is not Ellipsis:
        return f"{len(parts)} {_PLURAL.get(parts[0], 'values')}"
    if kind.__module__ == "numpy":
        return "an array"
    if kind.__module__ in _CONTAINERS:
        return f"a list of {_PLURAL.get(parts[0]) or _each(parts[0])}" if parts else "a list"
    return f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"


def _each(hint: Any) -> str:
    words = in_words(hint)
    return "paths" if words == "a path" else f"items that are each {words}"


def _without_repeated_paths(words: list[str]) -> list[str]:
    """Return alternatives without "a text" where a path may be given, which is a text."""
    return [one for one in dict.fromkeys(words) if not (one == "a text" and "a path" in words)]


def _join_words(words: list[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def takes(function: Callable[..., object], number: int) -> bool:
    """Return whether a function accepts a number of arguments; some functions in C do not tell."""
    try:
        signature(function).bind(*[None] * number)
    except ValueError:
        return True
    except TypeError:
        return False
    return True


P = ParamSpec("P")
R = TypeVar("R")

_VARIADIC: Final = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
_UNEXPECTED: Final = "got an unexpected keyword argument"


def checks_arguments(*skip: str, **overrides: Any) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator: the function raises an ArgumentError for an argument of the wrong kind.

    A call takes some microseconds longer, so it is not for calls of each step.

    Args:
        skip: arguments that the function checks itself, with better advice.
        overrides: hints that are narrower than the declared ones.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def checked(*args: P.args, **named: P.kwargs) -> R:
            _require_all(function, skip, overrides, args, named)
            return function(*args, **named)

        return checked

    return decorate


def require_kind(owner: str, name: str, hint: Any, value: object) -> None:
    """Check one value.

    Args:
        owner: the function that is given it, for the message.
        name: its name there.
        hint: the type hint that it meets.
        value: the value.

    Raises:
        ArgumentError: it has another kind.
    """
    if not admits(hint, value):
        raise ArgumentError(f"{owner}: {name} is {reprlib.repr(value)}; it must be {in_words(hint)}")


def require_fields(record: object, owner: str, *names: str) -> None:
    """Check values of a dataclass against the hints of its fields.

    Args:
        record: an instance of it.
        owner: the kind of the owner, for the message.
        names: the fields; all by default.

    Raises:
        ArgumentError: one is of another kind.
    """
    cls: type = type(record)
    hints = _hints_of(cls)
    for name in names or hints:
        require_kind(owner, name, hints[name], getattr(record, name))


def _require_all(
    function: Callable[..., Any],
    skip: tuple[str, ...],
    overrides: dict[str, Any],
    args: tuple[Any, ...],
    named: dict[str, Any],
) -> None:
    declared, hints = _signature_and_hints(function)
    owner = function.__qualname__.removesuffix(".__init__")
    arguments, failure = _bind_arguments(declared, args, named)
    for name, value in arguments.items():
        kind = declared.parameters[name].kind
        hint = hints.get(name, Any) if kind in _VARIADIC else overrides.get(name, hints.get(name, Any))
        for called, one in _named_values(name, value, kind) if name not in skip else ():
            require_kind(owner, called, hint, one)
    if failure is not None:
        raise ArgumentError(f"{owner}: {_reason(failure, declared, named)}") from None


def _bind_arguments(
    declared: Signature, args: tuple[Any, ...], named: dict[str, Any]
) -> tuple[dict[str, Any], TypeError | None]:
    """Return the valid arguments by name, and the reason why others do not fit."""
    try:
        return declared.bind(*args, **named).arguments, None
    except TypeError as error:
        known = {name: value for name, value in named.items() if name in declared.parameters}
        try:
            return declared.bind_partial(*args, **known).arguments, error
        except TypeError:
            return known, error


def _named_values(name: str, value: Any, kind: Any) -> Iterable[tuple[str, Any]]:
    """Return the names and values of an argument, which may be a collection of several."""
    if kind is Parameter.VAR_KEYWORD:
        return [*value.items()]
    return [(name, one) for one in (value if kind is Parameter.VAR_POSITIONAL else (value,))]


def _reason(failure: TypeError, declared: Signature, named: dict[str, Any]) -> str:
    """Return why arguments do not fit, and suggest a name.

    The words are Python's, because callers such as TorchRL search the message for them to call again without
    the argument.
    """
    if _UNEXPECTED not in str(failure):
        return str(failure)
    unknown = next(name for name in named if name not in declared.parameters)
    names = [
        name for name, one in declared.parameters.items() if one.kind not in _VARIADIC and name != "self"
    ]
    return f"{_UNEXPECTED} '{unknown}'{did_you_mean(unknown, names)}"


@cache
def _signature_and_hints(function: Callable[..., Any]) -> tuple[Signature, dict[str, Any]]:
    """Return the signature of a function and its hints."""
    declared, hints = signature(function), dict[str, Any]()
    for name, parameter in declared.parameters.items():
        if parameter.annotation is not Parameter.empty:
            hints[name] = _evaluate_hint(parameter.annotation, function.__globals__)
    return declared, hints


@cache
def _hints_of(cls: type) -> dict[str, Any]:
    """Return the hints of the fields of a dataclass."""
    return {one.name: _evaluate_hint(one.type, vars(sys.modules[cls.__module__])) for one in fields(cls)}


def _evaluate_hint(hint: Any, names: dict[str, Any]) -> Any:
    """Return a hint; one with a name that only type checkers import admits anything."""
    try:
        return eval(hint, names) if isinstance(hint, str) else hint
    except (NameError, AttributeError):
        return Any
