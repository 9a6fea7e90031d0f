"""Arrays that processors read fast."""

from __future__ import annotations

import gc
import weakref
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core._support.arrays import CACHE_LINE, aligned_copy, unset
from nrp_core._support.rows import Rows

RECORD = np.dtype([("a", np.int32), ("b", np.float64)])


@pytest.mark.parametrize(
    "array",
    [
        np.arange(5.0),
        np.arange(28, dtype=np.int32).reshape(4, 7),
        np.arange(12.0).reshape(3, 4).T,
        np.ones(3, bool),
        np.array([(1, 2.5), (3, 4.5), (5, 6.5)], RECORD),
        np.empty((2, 0)),
    ],
    ids=["numbers", "rows", "transposed", "bytes", "records", "empty"],
)
def test_a_copy_begins_at_a_cache_line_and_is_independent(array: np.ndarray[Any, Any]) -> None:
    copies = [aligned_copy(array) for _ in range(8)]  # a plain copy is at a cache line by chance
    for copied in copies:
        assert copied.size == 0 or copied.ctypes.data % CACHE_LINE == 0
        assert copied.flags.c_contiguous
        assert copied.dtype == array.dtype
        assert not np.shares_memory(copied, array)
        np.testing.assert_array_equal(copied, array)


@pytest.mark.parametrize("size", [0, 1, (1 << 19) - 1, 1 << 19, 3_000_001])
def test_unset_numbers_can_be_set_and_outlive_other_names(size: int) -> None:
    numbers = unset(size)
    assert (numbers.dtype, numbers.shape, numbers.flags.c_contiguous) == (np.float64, (size,), True)
    numbers[:] = np.arange(size)
    part = numbers[size // 2 :].reshape(1, -1)
    del numbers
    assert part[0].tolist() == list(range(size // 2, size))


@pytest.mark.parametrize("shape", [(), (3,), (7, 10), (0,)])
def test_rows_are_read_from_arrays_and_written_to_those_that_are_not_skipped(shape: tuple[int, ...]) -> None:
    arrays = [np.full(shape, float(number)) for number in range(5)]
    kept, n = [weakref.ref(array) for array in arrays], arrays[0].size
    rows = Rows(arrays)
    arrays.clear()
    gc.collect()
    table = rows.read()
    assert table.tolist() == [[float(number)] * n for number in range(5)]
    rows.write(10.0 + table, np.array([True, False, True, False, False]))
    after = [array.ravel().tolist() for ref in kept if (array := ref()) is not None]
    assert after == [[number] * n for number in (0.0, 11.0, 2.0, 13.0, 14.0)]
    assert rows.read(table) is table
    assert table.tolist() == after


@pytest.mark.parametrize("other", [np.zeros(3), np.zeros(2, np.float32), np.zeros((2, 2)).T[0]])
def test_rows_of_arrays_that_differ_are_refused(other: Any, golden: Golden) -> None:
    with golden.raises(ValueError):
        Rows([np.zeros(2), other])


@pytest.mark.parametrize("shape", [(2, 3), (3, 2), (4,)])
def test_rows_refuse_an_array_of_another_shape(shape: tuple[int, ...], golden: Golden) -> None:
    with golden.raises(ValueError):
        Rows([np.zeros(2)] * 2).read(np.zeros(shape))
