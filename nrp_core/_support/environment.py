"""Which environment variables a piece of code reads."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager


class _Noting(os._Environ[str]):
    """``os.environ`` that notes the names that are looked up."""

    noted: set[str]

    def __getitem__(self, key: str) -> str:
        if isinstance(key, str):  # starting a process also asks for b"PATH", in vain
            self.noted.add(key)
        value: str = super().__getitem__(key)
        return value

    def __iter__(self) -> Iterator[str]:
        for key in super().__iter__():
            self.noted.add(key)
            yield key


@contextmanager
def noting_variables() -> Iterator[set[str]]:
    """Collect the names of the environment variables that are read in this block, by all threads."""
    os.environ.__class__ = _Noting
    os.environ.noted = set()  # type: ignore[attr-defined]
    try:
        yield os.environ.noted  # type: ignore[attr-defined]
    finally:
        os.environ.__class__ = os._Environ


def values_of(names: set[str]) -> dict[str, str | None]:
    """Return the values of environment variables, None for those that are not set."""
    return {name: os.environ.get(name) for name in sorted(names)}


def have_changed(values: Mapping[str, str | None]) -> bool:
    """Return whether environment variables now have other values."""
    return any(os.environ.get(name) != value for name, value in values.items())
