"""Files that are written as a whole, and failures of the disk as errors."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

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
    is_there = target.exists()
    if is_there and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    draft = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield draft
        with draft.open("rb") as file:
            os.fsync(file.fileno())
        if is_there:
            shutil.copymode(target, draft)
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


def _reason(error: OSError) -> str:
    """Return the system's message for the number of an error; HDF5 buries it in a paragraph of text."""
    return str(error) if error.errno is None else os.strerror(error.errno)
