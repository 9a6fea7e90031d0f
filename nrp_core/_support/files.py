"""Files that are written as a whole, and failures of the disk as errors."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nrp_core.errors import ExperimentError


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Run a block that writes a file or a folder.

    Raises:
        ExperimentError: the disk refused a write; the message names the path and the reason.
    """
    try:
        yield
    except OSError as error:
        raise ExperimentError(f"cannot be written: {_reason(error)}", path=path) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Run a block that writes a file as a whole: if it fails, the old file is still there.

    It writes the draft that it is given, in the same folder and with the same suffix, which then gets the
    name of the file. The file keeps its permissions, and a link stays a link.

    Args:
        path: the file; its folder must exist.

    Raises:
        OSError: the disk refused a write, or the file may only be read.
    """
    target = path.resolve()
    mode = target.stat().st_mode if target.exists() else None
    if mode is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    draft = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield draft
        with draft.open("rb") as file:
            os.fsync(file.fileno())
        if mode is not None:
            draft.chmod(stat.S_IMODE(mode))
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file as a whole, as :func:`replacing`.

    Args:
        path: the file; its folder must exist.
        content: a text is written as UTF-8, with the line ends that it has.

    Raises:
        ExperimentError: the disk refused a write, or the file may only be read.
    """
    with writing(path), replacing(path) as draft:
        draft.write_bytes(content.encode() if isinstance(content, str) else content)


def lock(file: Any, *, shared: bool = False) -> None:
    """Lock an open file or descriptor until it is closed. Without locks, as on Windows, do nothing.

    Raises:
        OSError: another process has locked it, or the file system does not support locks.
    """
    try:
        import fcntl
    except ImportError:
        return
    fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


_guards: list[None] = []


@contextmanager
def regular_files_only() -> Iterator[None]:
    """Run a block that reads the files of others: a pipe or a device in place of one is refused.

    Reading it would wait, or never end. Only the function ``open`` is guarded, not ``os.open``.
    """
    if not hasattr(_refuse_endless, "is_hooked"):
        sys.addaudithook(_refuse_endless)  # for ever; without a guard it does nothing
        _refuse_endless.is_hooked = True  # type: ignore[attr-defined]
    _guards.append(None)
    try:
        yield
    finally:
        _guards.pop()


def _refuse_endless(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or not _guards or arguments[1] is None or isinstance(arguments[0], int):
        return
    try:
        mode = Path(os.fsdecode(arguments[0])).stat().st_mode
    except (OSError, ValueError):
        return  # the function itself says why
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        path = Path(os.fsdecode(arguments[0]))
        raise ExperimentError("is a pipe, a socket or a device, not a file", path=path)


def _reason(error: OSError) -> str:
    """Return the system's message for the number of an error; HDF5 buries it in a paragraph of text."""
    return str(error) if error.errno is None else os.strerror(error.errno)
