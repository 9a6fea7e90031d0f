"""Checks of argument names and types where a script passes them, with suggestions."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any, Final

import numpy as np
from pyNN import errors
from pyNN.models import BaseCellType
from pyNN.parameters import LazyArray
from pyNN.space import BaseStructure
from quantities import Quantity

from nrp_core._support.checked_arguments import is_number
from nrp_core.errors import NetworkError, NrpError, did_you_mean


class InvalidValueError(NetworkError, errors.InvalidParameterValueError):
    """A cell parameter has an invalid value."""


class UnknownVariableError(NetworkError, errors.RecordingError):
    """A variable that the cells cannot record."""

    def __init__(self, message: str, **place: Any) -> None:
        NetworkError.__init__(self, message, **place)

    __str__ = NetworkError.__str__


class InvalidSynapseError(NetworkError, errors.ConnectionError):
    """A synapse is invalid."""


class UnknownCellError(NetworkError, IndexError, TypeError):
    """An index of cells that the population does not have."""


class UnknownSynapseError(NetworkError, IndexError):
    """An index of a synapse that the projection does not have."""


class WrongKindError(NetworkError, TypeError):
    """An argument has the wrong type."""


class PastTimeError(NetworkError):
    """The end of the run is in the past."""


@contextmanager
def computing(message: str, kind: type[NetworkError] = InvalidValueError) -> Iterator[None]:
    """Raise errors of the script's functions and expressions with ``message``, the failed step."""
    try:
        yield
    except (NrpError, MemoryError):
        raise
    except Exception as error:
        raise kind(f"{message}: {type(error).__name__}: {error}") from error


@contextmanager
def raising(kind: type[NetworkError]) -> Iterator[None]:
    """Raise network errors as errors of this class."""
    try:
        yield
    except NetworkError as error:
        raise kind(error.message) from None


PYNN07_ARGUMENTS: Final = {
    "weights": "StaticSynapse(weight=...), which is an argument of the projection",
    "delays": "StaticSynapse(delay=...), which is an argument of the projection",
    "target": "receptor_type",
    "synapse_dynamics": "synapse_type",
    "method": "connector",
    "A_plus": "an argument of the timing dependence, such as SpikePairRule(A_plus=...)",
    "A_minus": "an argument of the timing dependence, such as SpikePairRule(A_minus=...)",
    "v_init": "initialize(v=...)",
    "u_init": "initialize(u=...)",
}
"""The arguments of PyNN 0.7, and what PyNN has since 0.8 in their place."""
_NO_NUMBERS = "USc"
"""NumPy's kind codes of strings and complex numbers."""


class UnknownParameterError(NetworkError, errors.NonExistentParameterError):
    """An unknown parameter."""

    def __init__(self, message: str, **place: Any) -> None:
        NetworkError.__init__(self, message, **place)

    __str__ = NetworkError.__str__


def require_names(owner: str, given: Iterable[str], valid: Iterable[str]) -> None:
    """Check that all parameters exist.

    Args:
        owner: the object with these parameters, for the message.
        given: the given names.
        valid: all valid names.

    Raises:
        UnknownParameterError: a parameter does not exist.
    """
    known = list(valid)
    for name in given:
        if name not in known:
            today = PYNN07_ARGUMENTS.get(name)
            hint = f"; it was PyNN 0.7's; today it is {today}" if today else ""
            raise UnknownParameterError(
                f"{owner} has no parameter '{name}'{hint or did_you_mean(name, known)}"
            )


def require_arguments(owner: str, function: Callable[..., Any], given: Iterable[str]) -> None:
    """Check that a function takes all these keyword arguments, as :func:`require_names` does."""
    parameters = inspect.signature(function).parameters.values()
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        require_names(owner, given, (parameter.name for parameter in parameters if parameter.name != "self"))


def refuse_misspelt(
    owner: str, what: str, given: Iterable[str], known: Collection[str], alike: float
) -> None:
    """Refuse a name that is nearly a known one, where others are ignored.

    Args:
        owner: the object to which it is passed.
        what: the kind of object that it names.
        given: the names.
        known: the names that have a meaning.
        alike: how alike two names are, from 0 to 1, if one is a misspelling of the other.

    Raises:
        NetworkError: a name is misspelt.
    """
    for name in given:
        if name not in known and get_close_matches(name, known, 1, alike):
            raise NetworkError(f"{owner}: there is no {what} '{name}'{did_you_mean(name, known)}")


def require_by_name(owner: str, arguments: Sequence[Any], valid: Iterable[str]) -> None:
    """Check that a model is given its parameters by name.

    Raises:
        WrongKindError: it is given some by place, or as a dictionary.
    """
    if arguments:
        example = next(iter(valid), "name")
        raise WrongKindError(
            f"{owner} takes its parameters by name, as {owner}({example}=...), not {arguments[0]!r:.60}; "
            f"those of a dictionary as {owner}(**parameters)"
        )


def require_kind(owner: str, what: str, value: Any, kinds: Any, valid: str) -> None:
    """Check the type of an argument.

    Args:
        owner: the called object, for the message.
        what: the argument's name.
        value: the argument.
        kinds: a class or several classes.
        valid: the valid values, for the message.

    Raises:
        WrongKindError: the argument is of another type.
    """
    if not isinstance(value, kinds):
        shown = value.__name__ if isinstance(value, type) else reprlib.repr(value)
        raise WrongKindError(f"{owner}: its {what} is {shown}; it must be {valid}")


def in_units(owner: str, given: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
    """Return parameters as numbers in PyNN's units; values with a unit are converted.

    Raises:
        InvalidValueError: a value is in a unit of something else.
    """
    found = dict(given)
    for name, value in given.items():
        if isinstance(value, Quantity):
            try:
                numbers = value.rescale(units[name]).magnitude
            except (LookupError, ValueError):
                unit = units.get(name, "a number without a unit")
                raise InvalidValueError(f"{owner}: {name} is {value}; it must be in {unit}") from None
            found[name] = numbers if numbers.ndim else float(numbers)
    return found


def require_values(owner: str, given: Mapping[str, Any]) -> None:
    """Check that parameter values are numbers, or contain them: no texts, truth values or classes, not None.

    Raises:
        InvalidValueError: a value is invalid.
    """
    for name, value in given.items():
        parts = value if isinstance(value, (list, tuple)) else [value]
        is_mixed = any(map(is_number, parts)) and any(isinstance(one, (list, tuple)) for one in parts)
        if is_mixed or any(map(_is_no_number, parts)):
            raise InvalidValueError(
                f"{owner}: {name} is {_shown(value)}; it must be a number, one number for each, a "
                "RandomDistribution or a function of the index"
            )


def _is_no_number(part: Any) -> bool:
    if part is None or isinstance(part, (Mapping, type, bool, np.bool_)):
        return True
    return np.asarray(part).dtype.kind in _NO_NUMBERS


def _shown(value: Any) -> str:
    return f"the class {value.__name__}" if isinstance(value, type) else reprlib.repr(value)


def require_shape(owner: str, space: Mapping[str, Any], shape: tuple[int, ...]) -> None:
    """Check that parameters given as arrays or lists have one value for each cell or pair of cells.

    Raises:
        InvalidValueError: a parameter has a different number of values.
    """
    for name, value in space.items():
        base = value.base_value if isinstance(value, LazyArray) else value
        base = np.asarray(base) if isinstance(base, list) else base
        if isinstance(base, np.ndarray) and base.shape not in ((), shape):
            sizes = [" x ".join(map(str, numbers)) for numbers in (base.shape, shape)]
            raise InvalidValueError(f"{owner}: {name} has {sizes[0]} values where there are {sizes[1]}")


def require_population(label: str, size: Any, model: Any, structure: Any, initial_values: Any) -> None:
    """Check the arguments of a population.

    Raises:
        NetworkError: the size is not a whole number of 0 or more, or an argument has the wrong type.
    """
    owner = f"population '{label}'"
    numbers = size if isinstance(size, tuple) else (size,)
    if len(numbers) > 3 or not all(isinstance(number, (int, np.integer)) for number in numbers):
        raise InvalidValueError(
            f"{owner}: its size is {size!r}; it must be a whole number, or one for each of up to 3 axes"
        )
    if min(numbers) < 1:
        raise NetworkError(f"{owner} has no cells: its size is {size}")
    if not (isinstance(model, type) and issubclass(model, BaseCellType)):
        example = model if isinstance(model, str) else "IF_cond_exp"
        require_kind(owner, "cell type", model, BaseCellType, f"one such as sim.{example}()")
    require_kind(owner, "structure", structure, (BaseStructure, type(None)), "one such as sim.Line()")
    require_kind(owner, "initial_values", initial_values, (Mapping, type(None)), "a dictionary")
