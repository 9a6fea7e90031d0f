"""Files that code names by paths of another machine, or relative to the experiment, and its ``sys.path``."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from glob import glob
from pathlib import Path
from typing import Any

from nrp_legacy.files import Library

_OF_PACKAGES = ("site-packages", "dist-packages")
"""Folders of another Python's packages, which would hide those of this one."""


class ImportPath:
    """The folders whose modules code can import, including those added meanwhile.

    Args:
        names: ``sys.path`` of the code.
        folders: the folders to search first.
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


class BytesOrText(io.BufferedWriter):
    """A binary file that takes text too, as it did in Python 2."""

    def write(self, content: Any) -> int:
        return super().write(content.encode("utf-8") if isinstance(content, str) else content)


class Paths:
    """The locations of files that code names.

    Args:
        library: the search path for files that do not exist as named.
    """

    def __init__(self, library: Library) -> None:
        self._library = library

    def there(self, path: Any) -> Any:
        """Return the path of a file to read: as named, else found by search."""
        if not isinstance(path, (str, os.PathLike)) or Path(path).exists():
            return path
        return str(self._library.find_data(os.fspath(path)) or path)

    def place(self, path: Any) -> Any:
        """Return the path of a file to write: as named, else in the folder of the experiment."""
        if not isinstance(path, (str, os.PathLike)) or Path(path).parent.is_dir():
            return path
        return str(self._library.folder / Path(path).name)

    def glob(self, pattern: str, **options: Any) -> list[str]:
        """Return the files of a pattern: as named, else in the folder of the experiment."""
        here = glob(pattern, **options)  # noqa: PTH207 - with its own options
        return here or glob(str(self._library.folder / pattern), **options)  # noqa: PTH207

    def open(self, name: Any, mode: str = "r", buffering: int = -1, *more: Any, **options: Any) -> Any:
        """Open a file as Python 2 did: binary ones take text, and text may be of any encoding."""
        mode = mode.replace("U", "") or "r"
        is_read = "r" in mode
        path = self.there(name) if is_read else self.place(name)
        if "b" in mode:
            takes_text = not is_read and "+" not in mode and buffering != 0
            file: Any = open(path, mode, buffering, *more, **options)  # noqa: PTH123, SIM115 - see below
            return BytesOrText(file.detach()) if takes_text else file
        if not more:
            options = {"errors": "surrogateescape", **options}
        return open(path, mode, buffering or 1, *more, **options)  # noqa: PTH123 - also a descriptor

    def reading(self, function: Callable[..., Any], **defaults: Any) -> Callable[..., Any]:
        """Return a function that reads the file in its first argument from its actual path."""
        return lambda name=".", *values, **options: function(self.there(name), *values, **defaults | options)

    def writing(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that writes the file in its first argument to a possible path."""
        return lambda name, *values, **options: function(self.place(name), *values, **options)
