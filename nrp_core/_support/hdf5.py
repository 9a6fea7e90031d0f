"""Writing HDF5 files safely when the disk may be full."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py


class _Disk(io.RawIOBase):
    """A file that accepts all writes of HDF5 and remembers the first failure of the disk.

    HDF5 does not survive a failed write: it keeps writing when its objects are freed, and finally crashes.

    Attributes:
        failure: the error of the first failed write; nothing is written after it.
    """

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self.failure: OSError | None = None

    def write(self, data: Any) -> int:
        rest = memoryview(data).cast("B")
        size = len(rest)
        try:
            while self.failure is None and rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self.failure = error
        return size

    def readinto(self, buffer: Any) -> int:
        return self._file.readinto(buffer)

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
