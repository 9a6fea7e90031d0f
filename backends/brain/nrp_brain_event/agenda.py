"""A calendar of future events: arriving spikes, and scheduled updates of neurons.

Time is divided into windows no longer than the shortest delay, so spikes of a window arrive in later windows,
and each neuron can be advanced through a window independently. The windows are a ring of lists; later events
wait in one more list, which is distributed once in each round. A neuron is in at most one list.
"""

from __future__ import annotations

from math import inf
from typing import Final

from nrp_brain_event.records import Array, Clock, Event, Link
from nrp_core._support.jit import inlined, jit

_BEYOND: Final = 1 << 61
_NEVER: Final = 1 << 62
"""Windows after all others: for events beyond the ring, and for neurons that wait for a spike."""


@inlined
def post(clock: Clock, slots: Array, events: Array, time: float, target: int, weight: float, n: int) -> None:
    """Schedule a spike at a target, or at n synapses from number ``target`` on; needs a free event."""
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
    """Return the arrived event to the pool, and go to the next one."""
    index = clock.arriving
    clock.arriving, clock.arrived = events[index].after, 0
    events[index].after, events[index].n = clock.free, 0
    clock.free = index
    clock.n_free += 1


@jit
def gather(clock: Clock, slots: Array, events: Array, sorting: Array, end: float) -> None:
    """Remove the events of the window before ``end`` from the calendar, in order."""
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
def schedule(clock: Clock, slots: Array, links: Array, wake: float, row: int) -> float:
    """Schedule a neuron for its next update; return the latest time of its entry."""
    link, n = links[row], len(slots) - 1
    window = _window(clock, n, wake) if wake < inf else _NEVER
    listed = min(window, clock.slot + n) * clock.width if window < _NEVER else inf
    if link.window == window:
        return listed
    if link.window < _NEVER:
        _unlink(slots, links, link)
    link.window = window
    if window < _NEVER:
        slot = _slot(window, n)
        link.before, link.after = -1, slots[slot]
        if link.after >= 0:
            links[link.after].before = row
        slots[slot] = row
    return listed


@jit
def next_round(clock: Clock, slots: Array, events: Array) -> None:
    """At the start of a round, distribute the events beyond the last one."""
    n = len(slots) - 1
    index = slots[n]
    slots[n] = -1
    while index >= 0:
        event = events[index]
        following = event.after
        slot = _slot(_window(clock, n, event.time), n)
        event.after = slots[slot]
        slots[slot] = index
        index = following


@inlined
def _window(clock: Clock, n: int, time: float) -> int:
    """Return the window of a time, if it is in the ring of n; past times count as now."""
    number = time * clock.per_width
    return _BEYOND if number >= clock.slot + n else max(int(number), clock.slot)


@inlined
def _slot(window: int, n: int) -> int:
    """Return the list of a window in the ring; the last list is for later windows."""
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
    """Merge two sorted lists and return the first event."""
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

    So sums are the same bit for bit for any order of insertion.
    """
    if a.time != b.time:
        return a.time < b.time
    if a.n != b.n:
        return a.n < b.n
    if a.target != b.target:
        return a.target < b.target
    return a.weight < b.weight
