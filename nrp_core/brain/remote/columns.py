"""Columns of numbers in memory shared by two processes."""

from __future__ import annotations

import mmap
import os
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray

_BYTES: Final = 8
"""Size of each number, an integer or a float."""
_FIRST_SIZE: Final = 1 << 16


class SharedColumns:
    """Memory for the columns of one message; it grows when a message needs more.

    The two sides take turns: each reads the other's columns before it writes its own.

    Args:
        descriptor: of an open memory file, which this object then owns; None for a new one.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        number = os.memfd_create("nrp-core") if descriptor is None else descriptor
        self._file = os.fdopen(number, "r+b", buffering=0)
        self._integers: IntArray = np.empty(0, np.int64)
        self._floats: npt.NDArray[np.float64] = np.empty(0)

    @property
    def descriptor(self) -> int:
        """The file descriptor."""
        return self._file.fileno()

    def write(self, columns: Sequence[npt.NDArray[Any]]) -> int:
        """Write columns one after another; return the number of values."""
        total = sum(map(len, columns))
        self._reach(total)
        at = 0
        for column in columns:
            numbers = self._floats if column.dtype.kind == "f" else self._integers
            numbers[at : at + len(column)] = column
            at += len(column)
        return total

    def read(self, total: int) -> IntArray:
        """Return a copy of the written values as integers; view floats in it as another type."""
        self._reach(total)
        return self._integers[:total].copy()

    def close(self) -> None:
        """Release the memory."""
        self._integers, self._floats = np.empty(0, np.int64), np.empty(0)
        self._file.close()

    def _reach(self, total: int) -> None:
        """Make room for this number of values; called by the writing side."""
        if total <= len(self._integers):
            return
        size = os.fstat(self.descriptor).st_size
        if size < total * _BYTES:
            size = max(_FIRST_SIZE, 1 << (total * _BYTES - 1).bit_length())
            os.ftruncate(self.descriptor, size)
        memory = mmap.mmap(self.descriptor, size)
        self._integers, self._floats = np.frombuffer(memory, np.int64), np.frombuffer(memory)
