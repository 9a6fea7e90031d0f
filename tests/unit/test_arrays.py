"""Arrays that processors read fast."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nrp_core._support.arrays import CACHE_LINE, aligned_copy, unset

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
