"""Errors that are both ours and PyNN's, so that scripts which catch PyNN's keep working."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pyNN import errors

from nrp_core.errors import NetworkError


class InvalidValueError(NetworkError, errors.InvalidParameterValueError):
    """A parameter of cells is impossible."""


class UnknownVariableError(NetworkError, errors.RecordingError):
    """A variable that cells do not have to record."""

    def __init__(self, message: str, **place: Any) -> None:
        NetworkError.__init__(self, message, **place)

    __str__ = NetworkError.__str__


class InvalidSynapseError(NetworkError, errors.ConnectionError):
    """A synapse is impossible."""


@contextmanager
def raising(kind: type[NetworkError]) -> Iterator[None]:
    """Raise errors about the network as errors of this kind."""
    try:
        yield
    except NetworkError as error:
        raise kind(error.message) from None
