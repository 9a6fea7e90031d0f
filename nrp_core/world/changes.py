"""Tell who watches a world what is done to it from Python, so that a recording can do it again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import update_wrapper
from typing import Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S", bound="Changeable")

Watcher = Callable[[str, Sequence[object], Mapping[str, object]], None]
"""Called with the name of a method and its arguments, once it has done what it does."""


class Changeable:
    """Something whose methods marked by :func:`change` are watched."""

    def __init__(self) -> None:
        self._watchers: list[Watcher] = []
        self._changing = False

    def add_watcher(self, watcher: Watcher) -> None:
        """Tell a watcher of every change; of one that makes others, of that one alone."""
        self._watchers.append(watcher)

    def remove_watcher(self, watcher: Watcher) -> None:
        """Tell a watcher nothing more."""
        self._watchers.remove(watcher)


def change(method: Callable[Concatenate[S, P], R]) -> Callable[Concatenate[S, P], R]:
    """Let the watchers of an object know when this method of it has been called."""

    def watched(self: S, /, *arguments: P.args, **named: P.kwargs) -> R:
        if self._changing or not self._watchers:
            return method(self, *arguments, **named)
        self._changing = True
        try:
            result = method(self, *arguments, **named)
        finally:
            self._changing = False
        for watcher in self._watchers:
            watcher(method.__name__, arguments, named)
        return result

    update_wrapper(watched, method)
    return watched
