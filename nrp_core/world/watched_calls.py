"""Report every change made to an object from Python, so that a recording can repeat it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import update_wrapper
from typing import Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S", bound="Changeable")

Watcher = Callable[[str, Sequence[object], Mapping[str, object]], None]
"""Called with the name of a change and its arguments, once it has been made."""


class Changeable:
    """An object whose methods marked by :func:`change` are watched.

    Attributes:
        watchers: called with every change; for nested changes only with the outermost one.
    """

    def __init__(self) -> None:
        self.watchers: list[Watcher] = []
        self._changing = False

    @contextmanager
    def changing(self, name: str, arguments: Sequence[object], named: Mapping[str, object]) -> Iterator[None]:
        """Report the changes in a block as one change of that name."""
        if self._changing or not self.watchers:
            yield
            return
        self._changing = True
        try:
            yield
        finally:
            self._changing = False
        for watcher in self.watchers:
            watcher(name, arguments, named)


def change(method: Callable[Concatenate[S, P], R]) -> Callable[Concatenate[S, P], R]:
    """Mark a method: each call is reported to the watchers of its object."""

    def watched(self: S, /, *arguments: P.args, **named: P.kwargs) -> R:
        with self.changing(method.__name__, arguments, named):
            return method(self, *arguments, **named)

    update_wrapper(watched, method)
    return watched
