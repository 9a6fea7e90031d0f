"""Sorts by merging the stretches that are in order already."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrp_brain_event.records import Array
from nrp_core._support.jit import jit

Earlier = Callable[[Any, int, int], bool]
"""Whether the first of two numbers of elements comes before the second one, in what is passed on."""


def sorting(earlier: Earlier) -> Callable[[Any, Array, int, int], None]:
    """Return the function that sorts ``order[first:last]``, numbers of elements, stably."""

    def sort(what: Any, order: Array, first: int, last: int) -> None:
        begins, n_begins = np.empty(last - first + 1, np.int64), 0
        for k in range(first, last):
            if k == first or earlier(what, order[k], order[k - 1]):
                begins[n_begins] = k
                n_begins += 1
        begins[n_begins] = last
        if n_begins < 2:
            return
        merged = np.empty(last - first, np.int64)
        while n_begins > 1:
            n_merged = 0
            for k in range(0, n_begins, 2):
                begin, middle, end = begins[k], begins[k + 1], begins[min(k + 2, n_begins)]
                a, b = begin, middle
                for place in range(begin, end):
                    if b == end or (a < middle and not earlier(what, order[b], order[a])):
                        merged[place - first] = order[a]
                        a += 1
                    else:
                        merged[place - first] = order[b]
                        b += 1
                begins[n_merged] = begin
                n_merged += 1
            begins[n_merged] = last
            n_begins = n_merged
            for k in range(first, last):
                order[k] = merged[k - first]

    return jit(sort)
