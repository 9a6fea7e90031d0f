"""Writing HDF5 files safely when the disk may be full."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

_BOOKKEEPING = 1 << 16
"""Writes of at most this many bytes may be structures that HDF5 reads again; larger ones are values."""


class _Disk(io.RawIOBase):
    """A file that accepts all writes of HDF5 and remembers the first failure of the disk.

    HDF5 survives neither a failed write, since it writes again when its objects are freed, nor structures
    that it reads back other than it wrote them: it crashes.

    Attributes:
        failure: the error of the first failed write; after it, structures are kept in memory.
    """

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self._kept: dict[int, bytes] = {}
        self.failure: OSError | None = None

    def write(self, data: Any) -> int:
        rest = memoryview(data).cast("B")
        size, begin = len(rest), self.tell()
        try:
            while self.failure is None and rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self.failure = error
        if self.failure is not None and size <= _BOOKKEEPING:
            self._kept.pop(begin, None)  # the latest comes last
            self._kept[begin] = bytes(memoryview(data).cast("B"))
        return size

    def readinto(self, buffer: Any) -> int:
        begin, size = self.tell(), len(buffer)
        read = self._file.readinto(buffer)
        if self.failure is None:
            return read
        buffer[read:] = bytes(size - read)
        for at, data in self._kept.items():
            low, high = max(at, begin), min(at + len(data), begin + size)
            if low < high:
                buffer[low - begin : high - begin] = data[low - at : high - at]
        return size

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def truncate(self, size: int | None = None) -> int:
        return self._file.tell() if self.failure else self._file.truncate(size)


@contextmanager
def new_file(path: Path, **options: Any) -> Iterator[h5py.File]:
    """Open a file; an existing one is replaced.

    Args:
        path: the file.
        options: of ``h5py.File``.

    Raises:
        OSError: the disk refused a write; raised when the file is closed.
    """
    with path.open("w+b", buffering=0) as file:
        disk = _Disk(file)
        try:
            with h5py.File(disk, "w", **options) as root:
                yield root
        finally:
            if disk.failure is not None:  # it hides other errors
                raise disk.failure
