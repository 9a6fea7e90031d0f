"""Names and kinds of arguments, checked where a script writes them, with what it may have meant."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from pyNN import errors
from pyNN.parameters import LazyArray

from nrp_core.brain.pynn.invalid import InvalidValueError, WrongKindError
from nrp_core.errors import NetworkError, did_you_mean

_NO_NUMBERS = "USc"
"""NumPy's kinds of texts and of complex numbers."""


class UnknownParameterError(NetworkError, errors.NonExistentParameterError):
    """A parameter that something does not have."""

    def __init__(self, message: str, **place: Any) -> None:
        NetworkError.__init__(self, message, **place)

    __str__ = NetworkError.__str__


def require_names(owner: str, given: Iterable[str], valid: Iterable[str]) -> None:
    """Check that all parameters exist.

    Args:
        owner: whose they are, for the message.
        given: names.
        valid: all that there are.

    Raises:
        UnknownParameterError: one does not.
    """
    known = list(valid)
    for name in given:
        if name not in known:
            raise UnknownParameterError(f"{owner} has no parameter '{name}'{did_you_mean(name, known)}")


def require_arguments(owner: str, function: Callable[..., Any], given: Iterable[str]) -> None:
    """Check that a function takes all these keyword arguments, as :func:`require_names` does."""
    parameters = inspect.signature(function).parameters.values()
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        require_names(owner, given, (parameter.name for parameter in parameters if parameter.name != "self"))


def require_kind(owner: str, what: str, value: Any, kinds: Any, valid: str) -> None:
    """Check that a part of something is of the kind that it must be.

    Args:
        owner: whose it is, for the message.
        what: which part.
        value: the part.
        kinds: a class, or several.
        valid: what it must be, for the message.

    Raises:
        WrongKindError: it is something else.
    """
    if not isinstance(value, kinds):
        shown = value.__name__ if isinstance(value, type) else reprlib.repr(value)
        raise WrongKindError(f"{owner}: its {what} is {shown}; it must be {valid}")


def require_values(owner: str, given: Mapping[str, Any]) -> None:
    """Check that values of parameters are not None, no texts and no complex numbers, nor hold any.

    Raises:
        InvalidValueError: one is or does.
    """
    for name, value in given.items():
        for part in value if isinstance(value, (list, tuple)) else [value]:
            if part is None or np.asarray(part).dtype.kind in _NO_NUMBERS:
                raise InvalidValueError(
                    f"{owner}: {name} is {reprlib.repr(value)}; it must be a number, one number for each, a "
                    "RandomDistribution or a function of the index"
                )


def require_shape(owner: str, space: Mapping[str, Any], shape: tuple[int, ...]) -> None:
    """Check that parameters given as arrays or lists have one value for each cell or pair of cells.

    Raises:
        InvalidValueError: one has another number of values.
    """
    for name, value in space.items():
        base = value.base_value if isinstance(value, LazyArray) else value
        base = np.asarray(base) if isinstance(base, list) else base
        if isinstance(base, np.ndarray) and base.shape not in ((), shape):
            sizes = [" x ".join(map(str, numbers)) for numbers in (base.shape, shape)]
            raise InvalidValueError(f"{owner}: {name} has {sizes[0]} values where there are {sizes[1]}")
