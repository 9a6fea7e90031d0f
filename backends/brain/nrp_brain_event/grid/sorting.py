"""Sort synapses by source neuron, delay and target: count them, distribute them, sort in place.

This needs less additional memory than the tables themselves.
"""

from __future__ import annotations

import numpy as np

from nrp_brain_event.records import Array
from nrp_core._support.jit import jit


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
                row[:] = np.sort(row)
                break


@jit
def sort_by_delay(first: Array, delays: Array, targets: Array, values: Array) -> None:
    """Sort each neuron's synapses by delay and target; ``values`` may be empty."""
    longest = 0
    for k in range(len(delays)):
        longest = max(longest, delays[k])
    place = np.zeros(longest + 2, np.int64)
    for i in range(len(first) - 1):
        a, b = first[i], first[i + 1]
        if b - a < 2:
            continue
        if longest < b - a and (targets[a + 1 : b] >= targets[a : b - 1]).all():
            order = _by_delay(delays[a:b], place)
        else:
            order = np.argsort(delays[a:b].astype(np.int64) * 65536 + targets[a:b], kind="mergesort")
        delays[a:b], targets[a:b] = delays[a:b][order], targets[a:b][order]
        if len(values) > 0:
            values[a:b] = values[a:b][order]


@jit
def _by_delay(delays: Array, place: Array) -> Array:
    """Return the stable order of delays by counting; ``place`` has room for one more than the longest."""
    place[:] = 0
    for delay in delays:
        place[delay + 1] += 1
    for k in range(len(place) - 1):
        place[k + 1] += place[k]
    order = np.empty(len(delays), np.int64)
    for k in range(len(delays)):
        order[place[delays[k]]] = k
        place[delays[k]] += 1
    return order


@jit
def count_segments(first: Array, delays: Array) -> int:
    """Return how many stretches of equal delay there are."""
    n = 0
    for i in range(len(first) - 1):
        for k in range(first[i], first[i + 1]):
            n += k == first[i] or delays[k] != delays[k - 1]
    return n


@jit
def cut_segments(first: Array, delays: Array, neuron: Array, start: Array) -> None:
    """Write the neuron and the first synapse of each stretch."""
    n = 0
    for i in range(len(first) - 1):
        for k in range(first[i], first[i + 1]):
            if k == first[i] or delays[k] != delays[k - 1]:
                neuron[n], start[n] = i, k
                n += 1
