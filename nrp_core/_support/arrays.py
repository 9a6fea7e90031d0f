"""Array types of the interfaces, and arrays that processors read fast."""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np
import numpy.typing as npt

if sys.platform != "win32":
    from mmap import MAP_ANONYMOUS, MAP_PRIVATE, mmap

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]
IndexArray = npt.NDArray[np.int32]
"""Indices within one population or mesh, in half the memory."""

CACHE_LINE: Final = 64
"""Size of a cache line, bytes."""


_LARGE: Final = 1 << 22
"""Size from which on NumPy asks for huge pages, bytes."""


def unset(size: int) -> FloatArray:
    """Return an array of numbers that are still to be set, without huge pages.

    NumPy asks for huge pages for large arrays. Where free memory is in pieces, the system has to move
    others for them, which takes four times as long as to fill the array.
    """
    if size * 8 < _LARGE or sys.platform == "win32":
        return np.empty(size)
    return np.frombuffer(mmap(-1, size * 8, flags=MAP_PRIVATE | MAP_ANONYMOUS), np.float64)


def aligned_copy(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a contiguous copy that begins at a cache line.

    NumPy's arrays begin at any multiple of 16 bytes. Where each vector is in two cache lines, a loop over
    vectors takes up to a third longer.
    """
    memory = np.empty(array.nbytes + CACHE_LINE, np.uint8)
    first = -memory.ctypes.data % CACHE_LINE
    copied = memory[first : first + array.nbytes].view(array.dtype).reshape(array.shape)
    copied[...] = array
    return copied


def address(array: npt.NDArray[Any]) -> int:
    """Return the place of an array in memory, for compiled code; the caller keeps the array alive."""
    place: int = array.__array_interface__["data"][0]
    return place
