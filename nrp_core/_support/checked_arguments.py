"""Functions of the public interface that check what they are given against their type hints.

mypy finds a wrong argument before a program runs, but notebooks are rarely checked by it. This is the one
place where kinds are checked. Ranges, and relations between arguments, are checked by the function.
"""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import cache, wraps
from inspect import Parameter, Signature, signature
from typing import Any, Final, ParamSpec, TypeVar

from nrp_core._support.kinds import admits, in_words
from nrp_core.errors import ArgumentError, did_you_mean

P = ParamSpec("P")
R = TypeVar("R")

_SEVERAL: Final = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
_UNEXPECTED: Final = "unexpected keyword argument"


def checks_arguments(*but: str, **closer: Any) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator: the function raises an ArgumentError for an argument of the wrong kind.

    A call takes some microseconds longer, so it is not for calls of each step.

    Args:
        but: arguments that the function checks itself, with better advice.
        closer: hints that are closer than the declared ones.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def checked(*args: P.args, **named: P.kwargs) -> R:
            _require_all(function, but, closer, args, named)
            return function(*args, **named)

        return checked

    return decorate


def require_kind(owner: str, name: str, hint: Any, value: object) -> None:
    """Check one value.

    Args:
        owner: the function that is given it, for the message.
        name: what it is called there.
        hint: the type hint that it meets.
        value: the value.

    Raises:
        ArgumentError: it is of another kind.
    """
    if not admits(hint, value):
        raise ArgumentError(f"{owner}: {name} is {reprlib.repr(value)}; it must be {in_words(hint)}")


def require_fields(record: object, owner: str, *names: str) -> None:
    """Check values of a dataclass against the hints of its fields.

    Args:
        record: an instance of it.
        owner: what it is, for the message.
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
    but: tuple[str, ...],
    closer: dict[str, Any],
    args: tuple[Any, ...],
    named: dict[str, Any],
) -> None:
    declared, hints = _declared(function)
    owner = function.__qualname__.removesuffix(".__init__")
    arguments, failure = _bound(declared, args, named)
    for name, value in arguments.items():
        kind = declared.parameters[name].kind
        hint = hints.get(name, Any) if kind in _SEVERAL else closer.get(name, hints.get(name, Any))
        for called, one in _given(name, value, kind) if name not in but else ():
            require_kind(owner, called, hint, one)
    if failure is not None:
        raise ArgumentError(f"{owner}: {_reason(failure, declared, named)}") from None


def _bound(
    declared: Signature, args: tuple[Any, ...], named: dict[str, Any]
) -> tuple[dict[str, Any], TypeError | None]:
    """Return arguments by name, as far as they fit, and why some do not."""
    try:
        return declared.bind(*args, **named).arguments, None
    except TypeError as error:
        known = {name: value for name, value in named.items() if name in declared.parameters}
        try:
            return declared.bind_partial(*args, **known).arguments, error
        except TypeError:
            return known, error


def _given(name: str, value: Any, kind: Any) -> Iterable[tuple[str, Any]]:
    """Return the names and values of an argument, which may stand for several."""
    if kind is Parameter.VAR_KEYWORD:
        return [*value.items()]
    return [(name, one) for one in (value if kind is Parameter.VAR_POSITIONAL else (value,))]


def _reason(failure: TypeError, declared: Signature, named: dict[str, Any]) -> str:
    """Return why arguments do not fit; Python does not say which name was meant."""
    if _UNEXPECTED not in str(failure):
        return str(failure)
    unknown = next(name for name in named if name not in declared.parameters)
    names = [name for name, one in declared.parameters.items() if one.kind not in _SEVERAL and name != "self"]
    return f"there is no argument '{unknown}'{did_you_mean(unknown, names)}"


@cache
def _declared(function: Callable[..., Any]) -> tuple[Signature, dict[str, Any]]:
    """Return the signature of a function and its hints."""
    declared, hints = signature(function), dict[str, Any]()
    for name, parameter in declared.parameters.items():
        if parameter.annotation is not Parameter.empty:
            hints[name] = _evaluated(parameter.annotation, function.__globals__)
    return declared, hints


@cache
def _hints_of(cls: type) -> dict[str, Any]:
    """Return the hints of the fields of a dataclass."""
    return {one.name: _evaluated(one.type, vars(sys.modules[cls.__module__])) for one in fields(cls)}


def _evaluated(hint: Any, names: dict[str, Any]) -> Any:
    """Return a hint; one with a name that only type checkers import admits anything."""
    try:
        return eval(hint, names) if isinstance(hint, str) else hint
    except (NameError, AttributeError):
        return Any
