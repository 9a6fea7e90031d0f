"""A calendar of what is to come: arriving spikes, and neurons that wake by themselves.

Time is cut into windows no longer than the shortest delay, so what happens in a window arrives in later
ones, and each neuron can pass through a window alone. The windows lie on a ring of lists; what is
further ahead waits in one more list, which is sorted in once every round. A neuron stands in at most one.
"""

from __future__ import annotations

from math import inf
from typing import Final

from nrp_brain_event.records import Array, Cell, Clock, Event
from nrp_core.jit import inlined, jit

_BEYOND: Final = 1 << 61
_NEVER: Final = 1 << 62
"""Windows after all others: of what the ring does not reach yet, of neurons that wait for a spike."""


@inlined
def post(clock: Clock, slots: Array, events: Array, time: float, target: int, weight: float) -> None:
    """Let a spike arrive at a target; there must be a free event."""
    index = clock.free
    event = events[index]
    clock.free = event.after
    clock.n_free -= 1
    event.time, event.target, event.weight = time, target, weight
    slot = _slot(_window(clock, len(slots) - 1, time), len(slots) - 1)
    event.after = slots[slot]
    slots[slot] = index


@inlined
def release(clock: Clock, events: Array, cell: Cell) -> None:
    """Give the first arrival of a neuron back to the pool."""
    index = cell.arrivals
    cell.arrivals = events[index].after
    events[index].after = clock.free
    clock.free = index
    clock.n_free += 1


@inlined
def schedule(clock: Clock, slots: Array, cells: Array, row: int) -> None:
    """Put a neuron where it is found by the time it wakes; where it is found sooner, it can stay."""
    cell = cells[row]
    window = _window(clock, len(slots) - 1, cell.wake) if cell.wake < inf else _NEVER
    if clock.slot < cell.window <= window < _NEVER or cell.window == window:
        return
    if cell.window >= 0:
        _unlink(slots, cells, cell)
    cell.window = -1
    if window < _NEVER:
        slot = _slot(window, len(slots) - 1)
        cell.window, cell.before, cell.after = window, -1, slots[slot]
        if cell.after >= 0:
            cells[cell.after].before = row
        slots[slot] = row


@inlined
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
        following = cells[row].after
        if cells[row].wake < end:
            _get_ready(clock, cells, ready, row)
        else:
            schedule(clock, cell_slots, cells, row)
        row = following


@jit
def next_round(clock: Clock, event_slots: Array, cell_slots: Array, events: Array, cells: Array) -> None:
    """At the beginning of a round, take in what was too far ahead in the last one."""
    n = len(event_slots) - 1
    index = event_slots[n]
    event_slots[n] = -1
    while index >= 0:
        event = events[index]
        following = event.after
        slot = _slot(_window(clock, n, event.time), n)
        event.after = event_slots[slot]
        event_slots[slot] = index
        index = following
    row = cell_slots[n]
    while row >= 0:
        following = cells[row].after
        schedule(clock, cell_slots, cells, row)
        row = following


@inlined
def _window(clock: Clock, n: int, time: float) -> int:
    """Return the window of a time, if the ring of n has it; times gone by count as now."""
    number = time * clock.per_width
    return _BEYOND if number >= clock.slot + n else max(int(number), clock.slot)


@inlined
def _slot(window: int, n: int) -> int:
    """Return the list of a window on the ring; the last is for those beyond it."""
    return n if window == _BEYOND else window & (n - 1)


@inlined
def _unlink(slots: Array, cells: Array, cell: Cell) -> None:
    if cell.before >= 0:
        cells[cell.before].after = cell.after
    else:
        slots[_slot(cell.window, len(slots) - 1)] = cell.after
    if cell.after >= 0:
        cells[cell.after].before = cell.before


@inlined
def _get_ready(clock: Clock, cells: Array, ready: Array, row: int) -> None:
    cell = cells[row]
    if not cell.ready:
        cell.ready = 1
        ready[clock.n_ready] = row
        clock.n_ready += 1


@inlined
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


@inlined
def _earlier(a: Event, b: Event) -> bool:
    if a.time != b.time:
        return a.time < b.time
    if a.target != b.target:
        return a.target < b.target
    return a.weight < b.weight
