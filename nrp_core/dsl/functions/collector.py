"""The registration of transfer functions with their loader; there is no process-wide list."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nrp_core.dsl.functions.function import TransferFunction

_collected: ContextVar[list[TransferFunction] | None] = ContextVar("collected", default=None)


@contextmanager
def collecting() -> Iterator[list[TransferFunction]]:
    """Collect the transfer functions declared in this context, in order.

    Each thread or task has a context of its own, so experiments can load concurrently.
    """
    functions: list[TransferFunction] = []
    token = _collected.set(functions)
    try:
        yield functions
    finally:
        _collected.reset(token)


def register(function: TransferFunction) -> None:
    """Add a function to the current collection, if there is one.

    Raises:
        TransferFunctionError: the name is taken.
    """
    functions = _collected.get()
    if functions is not None:
        require_new_name(function, functions)
        functions.append(function)


def require_new_name(function: TransferFunction, others: Iterable[TransferFunction]) -> None:
    """Refuse a function whose name is taken.

    Raises:
        TransferFunctionError: the name is taken.
    """
    for other in others:
        if other.name == function.name:
            raise function.place.error(name_taken(function.name, other.place))


def name_taken(name: str, place: object) -> str:
    """Return the message about a function whose name is already taken by a function at a place."""
    return f"the transfer function '{name}' already exists, at {place}; rename one"
