"""Track the files that are read while an experiment is loaded and run: includes, modules and data."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from importlib.util import source_from_cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from platformdirs import user_cache_path

_WRITING = os.O_WRONLY | os.O_RDWR
_listeners: list[FilesRead] = []


class FilesRead:
    """The files that this process opens for reading while the block runs."""

    _hooked = False

    def __init__(self) -> None:
        self._paths: dict[str, None] = {}

    def __enter__(self) -> Self:
        # An audit hook cannot be removed; without listeners it returns at once.
        if not FilesRead._hooked:
            sys.addaudithook(_notice)
            FilesRead._hooked = True
        _listeners.append(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _listeners.remove(self)

    def note(self, path: str) -> None:
        """Add an opened file; a compiled module counts as its source."""
        self._paths[os.path.abspath(path)] = None  # noqa: PTH100  called for every file, and a Path is slow

    def below(self, folders: Iterable[Path]) -> list[Path]:
        """Return the files in some folders, except installed software and caches below them."""
        roots = {way for folder in folders for way in (folder, folder.resolve())}
        beginnings = tuple(f"{root}{os.sep}" for root in roots)
        near = {_source(Path(path)) for path in list(self._paths) if path.startswith(beginnings)}
        return sorted(path for path in near if any(_belongs(path, root) for root in roots))


def _notice(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open" and _listeners:
        path, _, flags = arguments
        if isinstance(path, (str, bytes, os.PathLike)) and not (flags or 0) & _WRITING:
            for listener in _listeners:
                listener.note(os.fsdecode(path))


def _source(path: Path) -> Path:
    return (
        Path(source_from_cache(path)) if path.parent.name == "__pycache__" and path.suffix == ".pyc" else path
    )


def _belongs(path: Path, folder: Path) -> bool:
    foreign = (Path(sys.prefix), Path(sys.base_prefix), user_cache_path())
    inside = (other for other in foreign if folder in other.parents)
    return path.is_relative_to(folder) and path.is_file() and not any(map(path.is_relative_to, inside))
