"""A calendar of what is to come: arriving spikes, and neurons that wake by themselves.

Time is cut into windows no longer than the shortest delay, so what happens in a window arrives in later
ones, and each neuron can pass through a window alone. The windows lie on a ring of lists; what is
further ahead waits in one more list, which is sorted in once every round. A neuron stands in at most one.
"""

from __future__ import annotations

from math import inf
from typing import Final

from nrp_brain_event.records import Array, Cell, Clock, Event, Link
from nrp_core._support.jit import inlined, jit

_BEYOND: Final = 1 << 61
_NEVER: Final = 1 << 62
"""Windows after all others: of what the ring does not reach yet, of neurons that wait for a spike."""


@inlined
def post(clock: Clock, slots: Array, events: Array, time: float, target: int, weight: float, n: int) -> None:
    """Let a spike arrive at a target, or at n synapses from number ``target`` on; needs a free event."""
    index = clock.free
    event = events[index]
    clock.free = event.after
    clock.n_free -= 1
    event.time, event.target, event.weight, event.n = time, target, weight, n
    slot = _slot(_window(clock, len(slots) - 1, time), len(slots) - 1)
    event.after = slots[slot]
    slots[slot] = index


@inlined
def release(clock: Clock, events: Array) -> None:
    """Give the event that has arrived back to the pool, and turn to the next."""
    index = clock.arriving
    clock.arriving, clock.arrived = events[index].after, 0
    events[index].after, events[index].n = clock.free, 0
    clock.free = index
    clock.n_free += 1


@jit
def gather(clock: Clock, slots: Array, events: Array, sorting: Array, end: float) -> None:
    """Take the events of the window before ``end`` out of the calendar, in their order."""
    slot = clock.slot & (len(slots) - 2)
    index = slots[slot]
    slots[slot] = -1
    longest = 0
    while index >= 0:
        one, index = index, events[index].after
        if events[one].time >= end:
            events[one].after = slots[slot]
            slots[slot] = one
            continue
        events[one].after = -1
        k = 0
        while sorting[k] >= 0:
            one = _merged(events, sorting[k], one)
            sorting[k] = -1
            k += 1
        sorting[k] = one
        longest = max(longest, k)
    for k in range(longest + 1):
        if sorting[k] >= 0:
            clock.arriving = sorting[k] if clock.arriving < 0 else _merged(events, clock.arriving, sorting[k])
            sorting[k] = -1


@inlined
def schedule(clock: Clock, slots: Array, links: Array, cell: Cell, row: int) -> None:
    """Put a neuron where it is found by the time it wakes; where it is found sooner, it can stay."""
    if cell.wake < cell.listed:
        reschedule(clock, slots, links, cell, row)


@jit
def reschedule(clock: Clock, slots: Array, links: Array, cell: Cell, row: int) -> None:
    """Put a neuron where it is found when it wakes."""
    link, n = links[row], len(slots) - 1
    window = _window(clock, n, cell.wake) if cell.wake < inf else _NEVER
    cell.listed = min(window, clock.slot + n) * clock.width if window < _NEVER else inf
    if link.window == window:
        return
    if link.window < _NEVER:
        _unlink(slots, links, link)
    link.window = window
    if window < _NEVER:
        slot = _slot(window, n)
        link.before, link.after = -1, slots[slot]
        if link.after >= 0:
            links[link.after].before = row
        slots[slot] = row


@jit
def next_round(
    clock: Clock, event_slots: Array, cell_slots: Array, events: Array, links: Array, cells: Array
) -> None:
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
        following = links[row].after
        reschedule(clock, cell_slots, links, cells[row], row)
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
def _unlink(slots: Array, links: Array, link: Link) -> None:
    if link.before >= 0:
        links[link.before].after = link.after
    else:
        slots[_slot(link.window, len(slots) - 1)] = link.after
    if link.after >= 0:
        links[link.after].before = link.before


@jit
def _merged(events: Array, a: int, b: int) -> int:
    """Return the first event of two sorted lists made into one."""
    if _earlier(events[b], events[a]):
        a, b = b, a
    head = last = a
    a = events[a].after
    while a >= 0 and b >= 0:
        if _earlier(events[b], events[a]):
            a, b = b, a
        events[last].after = a
        last, a = a, events[a].after
    events[last].after = a if a >= 0 else b
    return head


@inlined
def _earlier(a: Event, b: Event) -> bool:
    """Return whether a comes before b: by time, receptor or synapse, weight.

    So sums are the same bit for bit however the events came here.
    """
    if a.time != b.time:
        return a.time < b.time
    if a.n != b.n:
        return a.n < b.n
    if a.target != b.target:
        return a.target < b.target
    return a.weight < b.weight
