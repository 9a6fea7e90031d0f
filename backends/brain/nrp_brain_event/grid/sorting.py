"""Sort synapses by source neuron, key and target: count them, distribute them, sort in place.

The key is the delay, and the table where several lie together. This needs less additional memory than the
tables themselves.

Sorts by merging the stretches that are in order already.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrp_brain_event.records import Array, constant
from nrp_core._support.jit import inlined, jit

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


_MOST = 1 << 16
"""Keys below it are counted if they are not much more than the synapses."""
_FIRST = constant(0)


@jit
def count(pre: Array, post: Array, low: int, high: int, n: Array) -> None:
    """Add to ``n`` how many synapses of each neuron end on ``low <= post < high``."""
    for k in range(len(pre)):
        if low <= post[k] < high:
            n[pre[k]] += 1


@jit
def place(pre: Array, post: Array, low: int, high: int, shift: int, at: Array, targets: Array) -> None:
    """Write the targets of synapses plus ``shift`` at the position ``at`` of each neuron and advance it."""
    for k in range(len(pre)):
        if low <= post[k] < high:
            targets[at[pre[k]]] = post[k] + shift
            at[pre[k]] += 1


@jit
def place_values(
    pre: Array, post: Array, low: int, high: int, values: Array, step: int, at: Array, out: Array
) -> None:
    """Write values of the same synapses; ``step`` is 0 if all have the same value."""
    for k in range(len(pre)):
        if low <= post[k] < high:
            out[at[pre[k]]] = values[step * k]
            at[pre[k]] += 1


@jit
def sort_targets(first: Array, targets: Array) -> None:
    """Sort each neuron's targets, which lets memory be read in order."""
    for i in range(len(first) - 1):
        row = targets[first[i] : first[i + 1]]
        for k in range(len(row) - 1):
            if row[k] > row[k + 1]:
                row.sort()
                break


@jit
def sort_by_key(first: Array, keys: Array, targets: Array, values: Array) -> None:
    """Sort each neuron's synapses by key and target; ``values`` may be empty."""
    longest = 0
    for k in range(len(keys)):
        longest = max(longest, keys[k])
    place = np.zeros(longest + 2 if longest < _MOST else 0, np.int64)
    for i in range(len(first) - 1):
        a, b = first[i], first[i + 1]
        if b - a < 2:
            continue
        both = keys[a:b], targets[a:b]
        if longest < min(_MOST, 4 * (b - a)):
            order = _by_key(keys[a:b], place)
            _ascend(order, both)
        else:
            order = np.arange(b - a)
            _order(both, order, _FIRST, b - a)
        _write(keys, a, keys[a:b][order])
        _write(targets, a, targets[a:b][order])
        if len(values) > 0:
            _write(values, a, values[a:b][order])


@jit
def _by_key(keys: Array, place: Array) -> Array:
    """Return the stable order of keys by counting; ``place`` has room for one more than the highest."""
    place[:] = 0
    for key in keys:
        place[key + 1] += 1
    for k in range(len(place) - 1):
        place[k + 1] += place[k]
    order = np.empty(len(keys), np.int64)
    for k in range(len(keys)):
        order[place[keys[k]]] = k
        place[keys[k]] += 1
    return order


@jit
def _ascend(order: Array, both: tuple[Array, Array]) -> None:
    """Sort by target where keys are equal."""
    keys, begin = both[0], _FIRST
    for k in range(1, len(order) + 1):
        if k == len(order) or keys[order[k]] != keys[order[begin]]:
            _order(both, order, begin, k)
            begin = k


@inlined
def _earlier(both: tuple[Array, Array], a: int, b: int) -> bool:
    keys, targets = both
    return bool(keys[a] < keys[b] or (keys[a] == keys[b] and targets[a] < targets[b]))


_order = sorting(_earlier)


@jit
def _write(onto: Array, first: int, values: Array) -> None:
    """Write values in a loop; an assignment to a slice takes seconds to compile."""
    for k in range(len(values)):
        onto[first + k] = values[k]


@jit
def count_segments(first: Array, keys: Array) -> int:
    """Return the number of runs of equal keys."""
    n = 0
    for i in range(len(first) - 1):
        for k in range(first[i], first[i + 1]):
            n += k == first[i] or keys[k] != keys[k - 1]
    return n


@jit
def cut_segments(first: Array, keys: Array, neuron: Array, start: Array) -> None:
    """Write the neuron and the first synapse of each stretch."""
    n = 0
    for i in range(len(first) - 1):
        for k in range(first[i], first[i + 1]):
            if k == first[i] or keys[k] != keys[k - 1]:
                neuron[n], start[n] = i, k
                n += 1
