"""Errors of this project that are also PyNN errors, so that scripts can catch them as such."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pyNN import errors

from nrp_core.errors import NetworkError, NrpError


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
