"""A calendar of what is to come: arriving spikes, and neurons that wake by themselves.

Time is cut into windows no longer than the shortest delay, so what happens in a window arrives in later
ones, and each neuron can pass through a window alone. Windows lie on a ring of lists; what is further
ahead waits in one more list, which is sorted in once every round. A neuron stands in at most one list.
"""

from __future__ import annotations

from math import inf

from nrp_core.jit import jit

from nrp_brain_event.records import Array, Record


@jit
def post(engine_clock: Record, slots: Array, events: Array, time: float, target: int, weight: float) -> None:
    """Let a spike arrive at a target (see :class:`~nrp_brain_event.records.Engine`); needs a free event."""
    index = engine_clock.free
    event = events[index]
    engine_clock.free = event.after
    engine_clock.n_free -= 1
    event.time, event.weight = time, weight
    event.cell, event.receptor = target >> 1, target & 1
    slot = _slot(engine_clock, len(slots) - 1, time)
    event.after = slots[slot]
    slots[slot] = index


@jit
def schedule(clock: Record, slots: Array, cells: Array, row: int) -> None:
    """Put a neuron where its waking time belongs."""
    cell = cells[row]
    slot = _slot(clock, len(slots) - 1, cell.wake) if cell.wake < inf else -1
    if slot == cell.slot:
        return
    if cell.slot >= 0:
        _unlink(slots, cells, cell)
    cell.slot = slot
    if slot >= 0:
        cell.before, cell.after = -1, slots[slot]
        if cell.after >= 0:
            cells[cell.after].before = row
        slots[slot] = row


@jit
def gather(
    clock: Record,
    event_slots: Array,
    cell_slots: Array,
    events: Array,
    cells: Array,
    ready: Array,
    end: float,
) -> None:
    """Hand out the events of the window before ``end`` and list the neurons that have something to do."""
    slot = clock.slot & (len(event_slots) - 2)
    index = event_slots[slot]
    event_slots[slot] = -1
    while index >= 0:
        event = events[index]
        following = event.after
        if event.time < end:
            _hand_over(events, cells[event.cell], index)
            _get_ready(clock, cells, ready, event.cell)
        else:
            event.after = event_slots[slot]
            event_slots[slot] = index
        index = following
    row = cell_slots[slot]
    while row >= 0:
        if cells[row].wake < end:
            _get_ready(clock, cells, ready, row)
        row = cells[row].after


@jit
def next_round(clock: Record, event_slots: Array, cell_slots: Array, events: Array, cells: Array) -> None:
    """At the beginning of a round take in what was too far ahead in the last one."""
    n = len(event_slots) - 1
    index = event_slots[n]
    event_slots[n] = -1
    while index >= 0:
        event = events[index]
        following = event.after
        slot = _slot(clock, n, event.time)
        event.after = event_slots[slot]
        event_slots[slot] = index
        index = following
    row = cell_slots[n]
    while row >= 0:
        following = cells[row].after
        schedule(clock, cell_slots, cells, row)
        row = following


@jit
def release(clock: Record, events: Array, cell: Record) -> None:
    """Give the first arrival of a neuron back to the pool."""
    index = cell.arrivals
    cell.arrivals = events[index].after
    events[index].after = clock.free
    clock.free = index
    clock.n_free += 1


@jit
def _slot(clock: Record, n: int, time: float) -> int:
    """Return the list of a time on a ring of n windows; times gone by count as now."""
    if time >= (clock.slot + n) * clock.width:
        return n
    return max(int(time / clock.width), clock.slot) & (n - 1)


@jit
def _unlink(slots: Array, cells: Array, cell: Record) -> None:
    if cell.before >= 0:
        cells[cell.before].after = cell.after
    else:
        slots[cell.slot] = cell.after
    if cell.after >= 0:
        cells[cell.after].before = cell.before


@jit
def _get_ready(clock: Record, cells: Array, ready: Array, row: int) -> None:
    cell = cells[row]
    if not cell.ready:
        cell.ready = 1
        ready[clock.n_ready] = row
        clock.n_ready += 1


@jit
def _hand_over(events: Array, cell: Record, index: int) -> None:
    """Sort an event in among the arrivals of its neuron.

    The order is by time, receptor and weight, so that sums are the same bit for bit however the events
    came here.
    """
    event = events[index]
    last, following = -1, cell.arrivals
    while following >= 0 and _earlier(events[following], event):
        last, following = following, events[following].after
    event.after = following
    if last >= 0:
        events[last].after = index
    else:
        cell.arrivals = index


@jit
def _earlier(a: Record, b: Record) -> bool:
    if a.time != b.time:
        return bool(a.time < b.time)
    if a.receptor != b.receptor:
        return bool(a.receptor < b.receptor)
    return bool(a.weight < b.weight)
