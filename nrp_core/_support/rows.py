"""Arrays of one size, each somewhere in memory, as the rows of one array."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray, address
from nrp_core._support.jit import array_at, jit

_NUMBERS: Final = np.empty(0)


class Rows:
    """Arrays that are copied from and to the rows of one array, by one call for all.

    Args:
        arrays: contiguous arrays of as many numbers, which it keeps: their memory stays where it is.

    Raises:
        ValueError: the arrays differ in size, or an array is not contiguous or not of floats.
    """

    def __init__(self, arrays: Sequence[FloatArray]) -> None:
        self._arrays = tuple(arrays)
        for one in arrays:
            if not (one.flags.c_contiguous and one.dtype == _NUMBERS.dtype and one.size == arrays[0].size):
                kind = f"{one.dtype} of shape {one.shape}"
                raise ValueError(f"rows are contiguous, of float64 and of one size, not {kind}")
        self._places = np.array([address(one) for one in arrays], np.int64)
        self._shape = len(arrays), arrays[0].size

    def read(self, table: FloatArray | None = None) -> FloatArray:
        """Return an array of their numbers, a given or a new one; a row for each."""
        table = np.empty(self._shape) if table is None else table
        _read(self._places, self._fitting(table))
        return table

    def write(self, table: FloatArray, skipped: npt.NDArray[np.bool_]) -> None:
        """Copy the rows of an array into the arrays that are not skipped."""
        _write(self._places, self._fitting(table), skipped)

    def _fitting(self, table: FloatArray) -> FloatArray:
        if table.shape != self._shape:
            raise ValueError(f"an array of shape {table.shape} for rows of shape {self._shape}")
        return table


@jit
def _read(places: IntArray, table: FloatArray) -> None:
    for i in range(len(places)):
        table[i, :] = array_at(places[i], table.shape[1], _NUMBERS)


@jit
def _write(places: IntArray, table: FloatArray, skipped: Any) -> None:
    for i in range(len(places)):
        if not skipped[i]:
            array_at(places[i], table.shape[1], _NUMBERS)[:] = table[i]
