"""Attributes that are stored in a compact form, and are arrays for whoever reads them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")

Change = Callable[[Any], Any]


def stored(*names: str, store: Change, read: Change) -> Callable[[type[T]], type[T]]:
    """Make a class store attributes in another form.

    Args:
        names: the attributes.
        store: returns the stored form of a value that is set.
        read: returns the array of a stored form.
    """

    def decorate(owner: type[T]) -> type[T]:
        for name in names:
            setattr(owner, name, _Stored(name, store, read))
        return owner

    return decorate


def stored_form(owner: object, name: str) -> Any:
    """Return the stored form of an attribute."""
    return vars(owner)[name]


class _Stored:
    def __init__(self, name: str, store: Change, read: Change) -> None:
        self._name, self._store, self._read = name, store, read

    def __get__(self, owner: object | None, kind: type) -> Any:
        return self if owner is None else self._read(stored_form(owner, self._name))

    def __set__(self, owner: object, value: Any) -> None:
        vars(owner)[self._name] = self._store(value)
