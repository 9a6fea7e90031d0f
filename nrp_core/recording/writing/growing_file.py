"""A file that only grows, with a digest of its contents, on a disk that may become full."""

from __future__ import annotations

import errno
import hashlib
import os
import sys
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

from nrp_core._support.closing import Closing

RESERVE_BYTES = 1 << 20
"""Disk space that is reserved for the end of a file, bytes."""

LEAST_RESERVE_BYTES = 1 << 16
"""The same on a disk that is nearly full: enough for the index and ``run.json`` of a short run, bytes."""


class GrowingFile(Closing):
    """Writes a file; each piece is written completely or not at all.

    A second file without a name reserves disk space. When the disk is full, that file is removed,
    so that there is space for the end. Of a limited file size as much is reserved.

    Args:
        path: a new file; its folder exists.

    Attributes:
        size: number of bytes that were written.
        full: the error after which the reserve is used; None while there is space.
        failed: the error after which nothing more is written.
    """

    def __init__(self, path: Path) -> None:
        self.size = 0
        self.full: OSError | None = None
        self.failed: OSError | None = None
        self._file = path.open("wb", buffering=0)
        self._digest = hashlib.sha256()
        self._reserve = _reserved(path.parent)
        self._limit = _limited()

    def append(self, data: bytes | bytearray) -> None:
        """Pass bytes to the operating system.

        Raises:
            OSError: this write or an earlier one failed.
        """
        if self.failed is not None:
            raise self.failed
        with memoryview(data) as rest:
            try:
                written = 0
                while written < len(rest):
                    written += self._written(rest[written:])
            except OSError as error:
                self.failed = error
                self.cut(self.size)
                raise
        self._digest.update(data)
        self.size += len(data)

    def cut(self, size: int) -> None:
        """Truncate the file to a size after a failed write."""
        self._file.truncate(size)

    @property
    def digest(self) -> str:
        """The SHA-256 of the file."""
        return self._digest.hexdigest()

    @property
    def closed(self) -> bool:
        """Whether :meth:`close` was called."""
        return self._file.closed

    def close(self) -> None:
        """Close the file and remove the reserve; calling it again does nothing."""
        self._free_reserve()
        self._file.close()

    def _written(self, data: memoryview) -> int:
        if self._limit is not None and self.full is None and self.size + len(data) > self._limit:
            self.full = OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        try:
            return self._file.write(data)
        except OSError as error:
            if self._reserve is None:
                raise
            self._free_reserve()
            self.full = error
            return self._file.write(data)

    def _free_reserve(self) -> None:
        if self._reserve is not None:
            self._reserve.close()
            self._reserve = None


def _reserved(folder: Path) -> IO[bytes] | None:
    """Reserve disk space in a folder: less on a disk that is nearly full, and None on a full one."""
    try:
        reserve = TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115  closed with the file
    except OSError:
        return None
    size = RESERVE_BYTES
    while size >= LEAST_RESERVE_BYTES:
        try:
            if reserve.seek(0) == 0 and reserve.write(bytes(size)) == size:
                return reserve
        except OSError:
            pass
        reserve.truncate(0)
        size //= 2
    reserve.close()
    return None


def _limited() -> int | None:
    """Return the size from which a file uses its reserve, if this process may not write files of any size."""
    if sys.platform == "win32":
        return None
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    return None if limit == resource.RLIM_INFINITY else limit - min(RESERVE_BYTES, limit // 2)
