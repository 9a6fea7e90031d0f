"""``sys.path`` of one experiment: what its code adds leads its own imports, and nobody else's."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

_OF_PACKAGES = ("site-packages", "dist-packages")
"""Folders of another Python's packages, which would hide those of this one."""


class ImportPath:
    """The folders whose modules code can import, those included that it adds meanwhile.

    Args:
        names: what is ``sys.path`` to the code.
        folders: that come first.
    """

    def __init__(self, names: list[str], folders: Iterable[Path] = ()) -> None:
        self._names, self._folders = names, tuple(folders)
        self._begun_with = frozenset(sys.path)

    def __iter__(self) -> Iterator[Path]:
        yield from self._folders
        added = (Path(name) for name in self._names if name not in self._begun_with)
        yield from (folder for folder in added if folder.name not in _OF_PACKAGES)
