"""Spikes in transit: a calendar of the segments that arrive in each step, and their effect.

A spike travels along the segments of its neuron in the order of their delays; only the next one is in the
calendar. So an arrival acts at once without a buffer, and spikes in transit cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from nrp_brain_event.grid.records import Grid, GridClock
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit, prefetch
from nrp_core.clock import NS_PER_MS

Arrive = Callable[[GridClock, Grid, Any, int, int], None]
"""Delivers a segment in a step to what is passed on."""
_LINE: Final = 32
"""Number of targets in a cache line."""
_NEAR: Final = 3
_FAR: Final = 8
"""How many entries before their turn their synapses, and the locations of these, are prefetched."""


@jit
def send_all(clock: GridClock, grid: Grid) -> None:
    """Send all queued spikes; there must be free entries."""
    for k in range(clock.n_out):
        send(clock, grid, grid.ids[grid.outbox[1, k]], grid.outbox[0, k] >> 1)
    clock.n_out = 0


@inlined
def send(clock: GridClock, grid: Grid, neuron: int, step: int) -> None:
    """Send a spike of a neuron (global id); there must be a free entry."""
    segment = grid.row_first[neuron]
    if segment < grid.row_first[neuron + 1]:
        ahead = step + grid.segments[segment].gap
        _post(clock, grid.slots, grid.entry_segment, grid.entry_after, segment, ahead)


@inlined
def store(clock: GridClock, grid: Grid, neuron: int, step: int) -> None:
    """Store a spike of a neuron (global id) for those who take it; there must be room."""
    spike = grid.spikes[clock.n_spikes]
    spike.time, spike.id = step * clock.step_ns / NS_PER_MS, neuron
    clock.n_spikes += 1


@inlined
def _post(clock: GridClock, slots: Array, segments: Array, after: Array, segment: int, step: int) -> None:
    entry = clock.free
    clock.free = after[entry]
    clock.n_free -= 1
    slot = step & (len(slots) - 1)
    segments[entry] = segment
    after[entry] = slots[slot]
    slots[slot] = entry


@inlined
def _announced(segments: Array, entry_segment: Array, entry_after: Array, entry: int) -> int:
    """Prefetch the location of an entry's synapses, before these are prefetched; return the next entry."""
    following: int = entry
    if entry >= 0:
        prefetch(segments, entry_segment[entry], 0)
        following = entry_after[entry]
    return following


@inlined
def _fetched(grid: Grid, entry: int) -> int:
    """Prefetch the synapses of an entry; return the next one."""
    if entry < 0:
        return entry
    segment = grid.entry_segment[entry]
    while True:
        passed = grid.segments[segment]
        first, last = passed.start, passed.start + passed.length
        for k in range(first, last, _LINE):
            prefetch(grid.targets, k, 0)
        table = grid.tables[passed.table]
        if table.own:
            for k in range(first + table.weights, last + table.weights, _LINE // 2):
                prefetch(grid.weights, k, 0)
        segment += 1
        if passed.last or grid.segments[segment].gap > 0:
            break
    following: int = grid.entry_after[entry]
    return following


def delivering(arrive: Arrive) -> Callable[[GridClock, Grid, Any, int], None]:
    """Return the function that delivers all spikes due in a step, by a function that delivers a segment."""

    def deliver(clock: GridClock, grid: Grid, onto: Any, step: int) -> None:
        slot = step & (len(grid.slots) - 1)
        entry = near = far = grid.slots[slot]
        grid.slots[slot] = -1
        for _ in range(_FAR):
            far = _announced(grid.segments, grid.entry_segment, grid.entry_after, far)
        for _ in range(_NEAR):
            near = _fetched(grid, near)
        while entry >= 0:
            far = _announced(grid.segments, grid.entry_segment, grid.entry_after, far)
            near = _fetched(grid, near)
            segment: Any = np.int64(grid.entry_segment[entry])  # of one type: nothing is compiled twice
            following = grid.entry_after[entry]
            grid.entry_after[entry] = clock.free
            clock.free = entry
            clock.n_free += 1
            while True:
                arrive(clock, grid, onto, segment, step)
                if grid.segments[segment].last:
                    break
                segment += 1
                if grid.segments[segment].gap > 0:
                    ahead = step + grid.segments[segment].gap
                    _post(clock, grid.slots, grid.entry_segment, grid.entry_after, segment, ahead)
                    break
            entry = following

    return inlined(deliver)
