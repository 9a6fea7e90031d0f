"""What spikes do at their synapses: a kernel for each kind of synapses that a network has.

Spikes in transit: a calendar of the segments that arrive in each step, and their effect.

A spike travels along the segments of its neuron in the order of their delays; only the next one is in the
calendar. So an arrival acts at once without a buffer, and spikes in transit cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from nrp_brain_event.grid.records import PLASTIC, Grid, GridClock, Segment, Table
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_brain_event.synapse_kernels import released_share, slow_of, store_spike, transmit
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


Dynamic = Callable[[Grid, Array, Segment, Table, float], None]
"""Delivers a segment of synapses whose weight changes, at a time (ms)."""


def deliver_static(places: Array, step: int) -> int:
    """Deliver all spikes due in a step, with static synapses."""
    grid = opened(Grid, places)
    _deliver_static(grid.clock[0], grid, grid.state.reshape(-1), step)
    return 0


def deliver_short_term(places: Array, step: int) -> int:
    """Deliver all spikes due in a step, with static and short-term synapses."""
    grid = opened(Grid, places)
    _deliver_short_term(grid.clock[0], grid, grid.state.reshape(-1), step)
    return 0


def deliver_plastic(places: Array, step: int) -> int:
    """Deliver all spikes due in a step, with static and plastic synapses."""
    grid = opened(Grid, places)
    _deliver_plastic(grid.clock[0], grid, grid.state.reshape(-1), step)
    return 0


def deliver_every(places: Array, step: int) -> int:
    """Deliver all spikes due in a step, with all kinds of synapses."""
    grid = opened(Grid, places)
    _deliver_every(grid.clock[0], grid, grid.state.reshape(-1), step)
    return 0


def deliver_late(places: Array, number: int, step: int) -> int:
    """Deliver one of the ``arrivals``, through a plastic synapse."""
    grid = opened(Grid, places)
    arrival = grid.arrivals[number]
    grid.state.reshape(-1)[arrival.target] += transmitted(grid, arrival.synapse, step * grid.clock[0].h)
    return 0


def store_for_plastic(places: Array, row: int, step: int) -> int:
    """Store the present spike of a neuron for its plastic synapses, if any; there must be a free place."""
    grid = opened(Grid, places)
    first, last = grid.first_plastic[row], grid.first_plastic[row + 1]
    if first < last:
        memory = grid.memories[row]
        memory.wake = step * grid.clock[0].h
        store_spike(memory, first, last, grid.plastic, grid.slow, grid.rules, grid.pool[0], grid.stored)
    return 0


@inlined
def transmitted(grid: Grid, row: int, arrival: float) -> float:
    """Return the weight with which a spike arrives over the plastic synapse in a row."""
    synapse = grid.plastic[row]
    memory = grid.memories[synapse.target >> 1]
    return transmit(synapse, slow_of(grid.slow, row), grid.rules[synapse.rule], memory, grid.stored, arrival)


def _arriving(dynamic: Dynamic) -> Arrive:
    """Return the function that delivers a segment of static synapses, or of others by ``dynamic``."""

    def arrive(clock: GridClock, grid: Grid, lines: Array, segment: int, step: int) -> None:
        passed = grid.segments[segment]
        table = grid.tables[passed.table]
        if table.dynamic:
            dynamic(grid, lines, passed, table, step * clock.h)
        else:
            _add(grid, lines, passed, table)

    return inlined(arrive)


@inlined
def _add(grid: Grid, lines: Array, passed: Segment, table: Table) -> None:
    first, last = passed.start, passed.start + passed.length
    onto, targets = lines[table.line :], grid.targets[first:last]
    if table.own:
        _add_own(onto, targets, grid.weights[first + table.weights : last + table.weights])
    else:
        _add_equal(onto, targets, table.weight)


@inlined
def _add_equal(onto: Array, targets: Array, weight: float) -> None:
    for k in range(len(targets)):
        onto[targets[k]] += weight


@inlined
def _add_own(onto: Array, targets: Array, weights: Array) -> None:
    for k in range(len(targets)):
        onto[targets[k]] += weights[k]


@inlined
def _transmit(grid: Grid, lines: Array, passed: Segment, table: Table, t: float) -> None:
    onto = lines[table.line :]
    for k in range(passed.start, passed.start + passed.length):
        onto[grid.targets[k]] += transmitted(grid, grid.plastic_rows[k + table.dynamics], t)


@inlined
def _release(grid: Grid, lines: Array, passed: Segment, table: Table, t: float) -> None:
    onto = lines[table.line :]
    for k in range(passed.start, passed.start + passed.length):
        share = released_share(grid.short_term[k + table.dynamics], t)
        onto[grid.targets[k]] += grid.weights[k + table.weights] * share


@inlined
def _release_or_transmit(grid: Grid, lines: Array, passed: Segment, table: Table, t: float) -> None:
    if table.dynamic == PLASTIC:
        _transmit(grid, lines, passed, table, t)
    else:
        _release(grid, lines, passed, table, t)


@inlined
def _none(_grid: Grid, _lines: Array, _passed: Segment, _table: Table, _t: float) -> None:
    pass


_deliver_static, _deliver_short_term = delivering(_arriving(_none)), delivering(_arriving(_release))
_deliver_plastic, _deliver_every = (
    delivering(_arriving(_transmit)),
    delivering(_arriving(_release_or_transmit)),
)
