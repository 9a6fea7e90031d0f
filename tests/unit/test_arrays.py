"""Arrays that processors read fast."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nrp_core._support.arrays import CACHE_LINE, aligned_copy

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
