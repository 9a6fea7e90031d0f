"""Records what a run reads: files, listed folders, environment variables and loaded packages."""

from __future__ import annotations

import builtins
import os
import sys
import time
from collections.abc import Iterable
from importlib.util import source_from_cache
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Self

from platformdirs import user_cache_path

from nrp_core._support.audit_events import LOADS, LOOKS, SEARCHES

_WRITING = os.O_WRONLY | os.O_RDWR
_VARIABLE = "nrp_core.variable"
_LISTINGS = {"os.listdir", "os.scandir"}
_EVENTS = {LOADS, LOOKS, SEARCHES, _VARIABLE, *_LISTINGS}
_STANDARD = os.path.dirname(os.__file__)  # noqa: PTH120  compared with names of files of frames
_COMPILED = (".nbi", ".nbc")
"""Suffixes of compiled kernels, wherever their cache is."""
_SYSTEM = tuple(f"/{name}/" for name in ("proc", "sys", "dev", "etc", "usr", "run", "lib", "lib64"))
_listeners: list[FilesRead] = []

Version = tuple[int, int]
"""Time of the last change of a file, ns, and its size in bytes."""
SETTLED_NS = 2_000_000_000
"""Age from which on the time of a file tells whether it was changed again, also on coarse file systems."""


class FilesRead:
    """What this process reads while the block runs; the block may be entered again, which adds to it.

    Files and packages count whoever reads them, listed folders and environment variables only if a file of
    the experiment does.

    Attributes:
        folders: the folders that were listed.
        variables: values of environment variables when they were first read; None: it was not set.
        packages: top-level packages of the plugins and modules that were loaded.
    """

    _hooked = False

    def __init__(self) -> None:
        self._paths: dict[str, Version | None] = {}
        self._written: set[str] = set()
        self.folders: dict[str, None] = {}
        self.variables: dict[str, str | None] = {}
        self.packages: set[str] = {"nrp_core"}

    def __enter__(self) -> Self:
        # An audit hook cannot be removed; without listeners it returns at once.
        if not FilesRead._hooked:
            sys.addaudithook(_notice)
            FilesRead._hooked = True
        _listeners.append(self)
        os.environ.__class__ = _Audited
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _listeners.remove(self)
        if not _listeners:
            os.environ.__class__ = os._Environ

    def note(self, path: str, flags: int = 0) -> None:
        """Add an opened file; a compiled module counts as its source; the run's own output is ignored."""
        path = os.path.abspath(path)  # noqa: PTH100  called for every file, and a Path is slow
        if flags & _WRITING:
            self._written.add(path)
            return
        path = _source(path)
        if path not in self._paths:
            self._paths[path] = version_of(path)

    def below(self, folders: Iterable[Path]) -> list[Path]:
        """Return the files in some folders, except installed software and caches below them."""
        roots = {way for folder in folders for way in (folder, folder.resolve())}
        beginnings = tuple(f"{root}{os.sep}" for root in roots)
        near = {Path(path) for path in list(self._paths) if path.startswith(beginnings)}
        return sorted(path for path in near if any(_belongs(path, root) for root in roots))

    def elsewhere(self, software: Iterable[Path]) -> list[Path]:
        """Return the files outside the system, installed software, caches, and these folders of packages."""
        folders = (sys.prefix, sys.base_prefix, user_cache_path(), *software)
        beginnings = (*_SYSTEM, *(f"{folder}{os.sep}" for folder in folders))
        paths = (path for path in list(self._paths) if not path.startswith(beginnings))
        return sorted(Path(path) for path in paths if not path.endswith(_COMPILED) and Path(path).is_file())

    def is_unchanged(self, path: Path) -> bool:
        """Whether a file is still as when it was first read; also of a file that was not noted."""
        text = str(path)
        return text not in self._paths or self._paths[text] == version_of(text)

    @property
    def is_current(self) -> bool:
        """Whether all files, and those that were looked for in vain, and all variables are as they were."""
        files = all(version_of(path) == version for path, version in self._paths.items())
        return files and all(variable_now(name) == value for name, value in self.variables.items())

    @property
    def is_settled(self) -> bool:
        """Whether :attr:`is_current` would notice every change from now on; not if folders were listed."""
        latest_ns = max((version[0] for version in self._paths.values() if version), default=0)
        return not self.folders and time.time_ns() - latest_ns > SETTLED_NS

    def announce(self) -> None:
        """Let others note what was read."""
        for event, names in (("open", self._paths), (LOADS, self.packages), (SEARCHES, self.variables)):
            for name in list(names):
                sys.audit(event, *((name, "r", os.O_RDONLY) if event == "open" else (name,)))

    def is_output(self, path: Path) -> bool:
        """Whether the run itself wrote a file."""
        return str(path) in self._written


class _Audited(os._Environ[str]):
    """``os.environ`` that announces each variable that is read."""

    def __getitem__(self, key: str) -> str:
        if isinstance(key, str):
            sys.audit(_VARIABLE, key)
        value: str = super().__getitem__(key)
        return value


def version_of(path: str) -> Version | None:
    """Return the version of a file, None if it does not exist."""
    try:
        state = os.stat(path)  # noqa: PTH116  called for every file
    except OSError:
        return None
    return state.st_mtime_ns, state.st_size


def _notice(event: str, arguments: tuple[Any, ...]) -> None:
    if not _listeners:
        return
    if event == "open":
        path, _, flags = arguments
        if isinstance(path, (str, bytes, os.PathLike)):
            for listener in _listeners:
                listener.note(os.fsdecode(path), flags or 0)
    elif event in _EVENTS:
        _notice_other(event, arguments[0])


def _notice_other(event: str, argument: Any) -> None:
    if event == LOADS:
        for listener in _listeners:
            listener.packages.add(argument)
    elif event == LOOKS:
        for listener in _listeners:
            listener.note(argument)
    elif event == SEARCHES or _is_read_by_experiment(sys._getframe(2)):
        for listener in _listeners:
            if event in _LISTINGS:
                listener.folders[os.path.abspath(os.fsdecode(argument or "."))] = None  # noqa: PTH100
            else:
                listener.variables.setdefault(argument, variable_now(argument))


def variable_now(name: str) -> str | None:
    """Return the value of an environment variable, without being noted; None: it is not set."""
    value = os.environ._data.get(os.fsencode(name))  # type: ignore[attr-defined]
    return None if value is None else os.fsdecode(value)


def _is_read_by_experiment(frame: FrameType | None) -> bool:
    """Whether the code that reads, the standard library aside, is a file of an experiment, or xacro.

    Such a file has built-in functions of its own (:class:`~nrp_core.scripts.Scope`).
    """
    while frame is not None:
        name = frame.f_code.co_filename
        if name.startswith("<frozen importlib"):
            return False
        if name != __file__ and not name.startswith((_STANDARD, "<frozen")):
            is_xacro = str(frame.f_globals.get("__name__")).partition(".")[0] == "xacro"
            return is_xacro or frame.f_builtins is not vars(builtins)
        frame = frame.f_back
    return False


def _source(path: str) -> str:
    is_compiled = path.endswith(".pyc") and os.path.basename(os.path.dirname(path)) == "__pycache__"  # noqa: PTH119, PTH120
    return source_from_cache(path) if is_compiled else path


def _belongs(path: Path, folder: Path) -> bool:
    foreign = (Path(sys.prefix), Path(sys.base_prefix), user_cache_path())
    inside = (other for other in foreign if folder in other.parents)
    return path.is_relative_to(folder) and path.is_file() and not any(map(path.is_relative_to, inside))
