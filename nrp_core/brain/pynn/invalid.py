"""Errors that are both ours and PyNN's, so that scripts which catch PyNN's keep working."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pyNN import errors

from nrp_core.errors import NetworkError, NrpError


class InvalidValueError(NetworkError, errors.InvalidParameterValueError):
    """A parameter of cells is impossible."""


class UnknownVariableError(NetworkError, errors.RecordingError):
    """A variable that cells do not have to record."""

    def __init__(self, message: str, **place: Any) -> None:
        NetworkError.__init__(self, message, **place)

    __str__ = NetworkError.__str__


class InvalidSynapseError(NetworkError, errors.ConnectionError):
    """A synapse is impossible."""


class UnknownCellError(NetworkError, IndexError, TypeError):
    """Cells that a population does not have."""


class UnknownSynapseError(NetworkError, IndexError):
    """A synapse that a projection does not have."""


class WrongKindError(NetworkError, TypeError):
    """Something is not of the kind that it must be."""


class PastTimeError(NetworkError):
    """A time to run to that has passed."""


@contextmanager
def computing(message: str, kind: type[NetworkError] = InvalidValueError) -> Iterator[None]:
    """Say by ``message`` what was being computed where a function or an expression of the script fails."""
    try:
        yield
    except (NrpError, MemoryError):
        raise
    except Exception as error:
        raise kind(f"{message}: {type(error).__name__}: {error}") from error


@contextmanager
def raising(kind: type[NetworkError]) -> Iterator[None]:
    """Raise errors about the network as errors of this kind."""
    try:
        yield
    except NetworkError as error:
        raise kind(error.message) from None
