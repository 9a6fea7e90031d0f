"""``sys.path`` of one experiment: additions by its code affect only its own imports."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from nrp_legacy.files import Library

_OF_PACKAGES = ("site-packages", "dist-packages")
"""Folders of another Python's packages, which would hide those of this one."""


class ImportPath:
    """The folders whose modules code can import, including those added meanwhile.

    Args:
        names: ``sys.path`` of the code.
        folders: the folders that come first.
        library: the search path for folders that do not exist as named.
    """

    def __init__(self, names: list[str], folders: Iterable[Path], library: Library) -> None:
        self._names, self._folders, self._library = names, tuple(folders), library
        self._begun_with = frozenset(sys.path)

    def __iter__(self) -> Iterator[Path]:
        yield from self._folders
        names = (name for name in self._names if name not in self._begun_with)
        added = (Path(name) if Path(name).is_dir() else self._library.find_data(name) for name in names)
        yield from (folder for folder in added if folder is not None and folder.name not in _OF_PACKAGES)
