"""Files: failures of the disk as errors, and a cache of results, one folder for each content."""

from __future__ import annotations

import logging
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile, mkdtemp

from platformdirs import user_cache_path

from nrp_core.errors import ExperimentError

_PROBE_BYTES = 1024
_logger = logging.getLogger(__name__)


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


def _reason(error: OSError) -> str:
    """Return the system's message for the number of an error; HDF5 buries it in a paragraph of text."""
    return str(error) if error.errno is None else os.strerror(error.errno)


Fill = Callable[[Path], None]
Check = Callable[[Path], bool]


def _is_there(folder: Path) -> bool:
    return folder.is_dir()


def cached_folder(kind: str, key: str, fill: Fill, is_whole: Check = _is_there) -> Path:
    """Return the folder that ``fill`` filled, now or in an earlier process.

    If the cache cannot be written, the folder exists until the process ends.

    Args:
        kind: the kind of the content; a folder of the cache.
        key: a digest of everything that the contents depend on.
        fill: called with an empty folder; if it raises, nothing is kept.
        is_whole: returns whether a kept folder is complete; cleaners may have deleted files.
    """
    kept = user_cache_path("nrp-core") / kind / key
    if is_whole(kept):
        return kept
    shutil.rmtree(kept, ignore_errors=True)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        work = Path(mkdtemp(prefix=f".{key}-", dir=kept.parent))
    except OSError:
        return _for_this_process(kind, key, fill)
    try:
        fill(work)
        if not kept.is_dir():
            work.rename(kept)
    except OSError:
        if not kept.is_dir():  # not a race with another process: the disk refuses it
            return _for_this_process(kind, key, fill)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return kept


def _for_this_process(kind: str, key: str, fill: Fill) -> Path:
    folder = Path(_temporary().name) / kind / key
    if not folder.is_dir():
        folder.mkdir(parents=True)
        try:
            fill(folder)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
    return folder


@cache
def writable_folder(folder: Path) -> Path:
    """Return a folder of a cache; if it cannot be written, one that exists until the process ends.

    Says once that what is compiled or converted is not kept.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder) as file:  # a full disk lets folders be made
            file.write(bytes(_PROBE_BYTES))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        _logger.warning(
            "the cache %s cannot be written (%s): nothing is kept for the next run", folder, reason
        )
        return Path(_temporary().name) / folder.name
    return folder


@cache
def _temporary() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="nrp-core-")
