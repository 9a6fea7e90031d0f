"""A calendar of what is to come: arriving spikes, and neurons that wake by themselves.

Time is cut into windows no longer than the shortest delay, so what happens in a window arrives in later
ones, and each neuron can pass through a window alone. The windows lie on a ring of lists; what is
further ahead waits in one more list, which is sorted in once every round. A neuron stands in at most one.
"""

from __future__ import annotations

from math import inf

from nrp_brain_event.records import Array, Cell, Clock, Event
from nrp_core.jit import jit


@jit
def post(clock: Clock, slots: Array, events: Array, time: float, target: int, weight: float) -> None:
    """Let a spike arrive at a target; there must be a free event."""
    index = clock.free
    event = events[index]
    clock.free = event.after
    clock.n_free -= 1
    event.time, event.target, event.weight = time, target, weight
    slot = _slot(clock, len(slots) - 1, time)
    event.after = slots[slot]
    slots[slot] = index


@jit
def release(clock: Clock, events: Array, cell: Cell) -> None:
    """Give the first arrival of a neuron back to the pool."""
    index = cell.arrivals
    cell.arrivals = events[index].after
    events[index].after = clock.free
    clock.free = index
    clock.n_free += 1


@jit
def schedule(clock: Clock, slots: Array, cells: Array, row: int) -> None:
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
    clock: Clock,
    event_slots: Array,
    cell_slots: Array,
    events: Array,
    cells: Array,
    plastic: Array,
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
            target = event.target if event.target >= 0 else plastic[~event.target].target
            row = target >> 1
            _hand_over(events, cells[row], index)
            _get_ready(clock, cells, ready, row)
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
def next_round(clock: Clock, event_slots: Array, cell_slots: Array, events: Array, cells: Array) -> None:
    """At the beginning of a round, take in what was too far ahead in the last one."""
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
def _slot(clock: Clock, n: int, time: float) -> int:
    """Return the list of a time on a ring of n windows; times gone by count as now."""
    if time >= (clock.slot + n) * clock.width:
        return n
    return max(int(time / clock.width), clock.slot) & (n - 1)


@jit
def _unlink(slots: Array, cells: Array, cell: Cell) -> None:
    if cell.before >= 0:
        cells[cell.before].after = cell.after
    else:
        slots[cell.slot] = cell.after
    if cell.after >= 0:
        cells[cell.after].before = cell.before


@jit
def _get_ready(clock: Clock, cells: Array, ready: Array, row: int) -> None:
    cell = cells[row]
    if not cell.ready:
        cell.ready = 1
        ready[clock.n_ready] = row
        clock.n_ready += 1


@jit
def _hand_over(events: Array, cell: Cell, index: int) -> None:
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
def _earlier(a: Event, b: Event) -> bool:
    if a.time != b.time:
        return a.time < b.time
    if a.target != b.target:
        return a.target < b.target
    return a.weight < b.weight
