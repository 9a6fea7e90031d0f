"""The cache of this user, shared by all processes: compiled kernels, converted meshes, results of checks.

Its entries are folders or files named ``KIND/KEY``. A process that has added one ends by removing those that
were not used for longest, until the rest is within the limit.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile, mkdtemp
from typing import Final

from platformdirs import user_cache_path

LIMIT_VARIABLE: Final = "NRP_CACHE_LIMIT_MB"
"""The environment variable that sets the limit."""
_LIMIT_MB: Final = 2000.0
_IN_USE_S: Final = {"unpacked": 7 * 86_400.0}
"""How long after its last use a process may still read an entry; models of archives are read at resets."""
_ENGINES_READ_S: Final = 3600.0
"""The same for other kinds, which are read when a simulation opens."""
_PROBE_BYTES = 1024
_logger = logging.getLogger(__name__)

Fill = Callable[[Path], None]
Check = Callable[[Path], bool]


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of the cache."""

    path: Path
    n_bytes: int
    used_s: float
    """When it was last used, in s since 1970."""

    @property
    def kind(self) -> str:
        """The kind of its content."""
        return self.path.parent.name

    def remove(self) -> None:
        """Delete it; another process sees the whole entry or none."""
        gone = self.path.with_name(f".{self.path.name}-{os.getpid()}")
        with suppress(OSError):
            self.path.rename(gone)
            gone.unlink() if gone.is_file() else shutil.rmtree(gone, ignore_errors=True)


def cache_root() -> Path:
    """Return the folder of the cache."""
    return user_cache_path("nrp-core")


def limit_bytes() -> int:
    """Return the size to which the cache is cut; a variable that is not a number counts as unset."""
    try:
        limit_mb = float(os.environ[LIMIT_VARIABLE])
    except (KeyError, ValueError):
        limit_mb = _LIMIT_MB
    return int(limit_mb * 1e6)


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
    kept = cache_root() / kind / key
    if is_whole(kept):
        mark_used(kept)
        return kept
    shutil.rmtree(kept, ignore_errors=True)
    try:
        return _filled(writable_folder(cache_root()) / kind / key, fill, is_whole)
    except OSError:  # the disk is full
        return _filled(Path(_temporary().name) / kind / key, fill, is_whole)


def _filled(folder: Path, fill: Fill, is_whole: Check) -> Path:
    if is_whole(folder):
        return folder
    folder.parent.mkdir(parents=True, exist_ok=True)
    work = Path(mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        fill(work)
        work.rename(folder)
    except OSError:
        if not is_whole(folder):  # no other process has filled it meanwhile
            raise
    finally:
        shutil.rmtree(work, ignore_errors=True)
    prune_at_exit()
    return folder


def mark_used(entry: Path) -> None:
    """Mark an entry as used now, if it exists."""
    with suppress(OSError):
        os.utime(entry)


@cache
def writable_folder(folder: Path) -> Path:
    """Return a folder of a cache; if it cannot be written, one that exists until the process ends.

    Warns once that compiled and converted files are not kept.
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
        return Path(_temporary().name)
    return folder


@cache
def _temporary() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="nrp-core-")


@cache
def prune_at_exit() -> None:
    """Cut the cache to its limit when this process ends."""
    atexit.register(prune)


def prune(to_bytes: int | None = None) -> int:
    """Remove entries that were not used for longest until the others fit; return the bytes removed.

    Entries that a running process may still read stay.

    Args:
        to_bytes: the size to reach; None: :func:`limit_bytes`.
    """
    found = sorted(entries(), key=lambda entry: (entry.used_s, entry.path))
    excess = sum(entry.n_bytes for entry in found) - (limit_bytes() if to_bytes is None else to_bytes)
    removed, now_s = 0, time.time()
    for entry in found:
        if removed >= excess:
            break
        if now_s - entry.used_s > _IN_USE_S.get(entry.kind, _ENGINES_READ_S):
            entry.remove()
            removed += entry.n_bytes
    return removed


def entries() -> Iterator[Entry]:
    """Yield everything in the cache."""
    for path in cache_root().glob("*/*"):
        with suppress(OSError):  # another process removes it
            files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
            n_bytes = sum(file.stat().st_size for file in files)
            yield Entry(path, n_bytes, path.stat().st_mtime)
