"""The compiled functions that the brain calls: run, add spikes, change currents, read.

Functions that are called in every step take the ``places`` of a :class:`~nrp_brain_event.handles.Handle`.

A calendar of future events: arriving spikes, and scheduled updates of neurons.

Time is divided into windows no longer than the shortest delay, so spikes of a window arrive in later windows,
and each neuron can be advanced through a window independently. The windows are a ring of lists; later events
wait in one more list, which is distributed once in each round. A neuron is in at most one list.
"""

from __future__ import annotations

from math import inf, nextafter
from typing import Final

from nrp_brain_event.handles import opened
from nrp_brain_event.linear import deliver, freeze, is_linear, postpone, search, set_time, thaw, voltage_of
from nrp_brain_event.neuron import fire, move, plan, receive, voltage_at
from nrp_brain_event.records import (
    COLD,
    DIVERGED,
    DONE,
    FIRE,
    FULL,
    HOT,
    PAUSED,
    SEARCH,
    START,
    Array,
    Cell,
    Clock,
    EngineArrays,
    Event,
    Kind,
    Link,
    Modes,
    Work,
)
from nrp_brain_event.rise import remaining_at
from nrp_brain_event.runge_kutta import state_at
from nrp_brain_event.synapse_kernels import released_share, slow_of, store_spike, transmit
from nrp_core._support.arrays import CACHE_LINE
from nrp_core._support.jit import inlined, jit, prefetch

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
def gather(
    clock: Clock, slots: Array, events: Array, sorting: Array, bundle: Array, delay: Array, end: float
) -> bool:
    """Remove the events of the window before ``end`` from the calendar, in order; False if there is no room.

    Each makes the event that follows it, so a spike in transit is a single event, however many delays its
    synapses have.
    """
    index = slots[clock.slot & (len(slots) - 2)]
    while index >= 0:
        one, after = index, events[index].after
        if after >= 0 and events[after].n > 0:
            prefetch(delay, events[after].target + events[after].n, 0)
            prefetch(bundle, events[after].target + events[after].n, 0)
        while events[one].time < end and events[one].n > 0 and bundle[events[one].target] < 0:
            event, following = events[one], clock.free
            sent, s = event.weight, event.target + event.n
            if sent == -inf:
                break
            if clock.n_free == 0:
                return False
            event.weight = -inf
            post(clock, slots, events, sent + delay[s], s, sent, abs(bundle[s]))
            one = following
        index = events[index].after
    _sort(clock, slots, events, sorting, end)
    return True


@jit
def _sort(clock: Clock, slots: Array, events: Array, sorting: Array, end: float) -> None:
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
        tail = one
        while index >= 0 and events[index].time < end:  # the spikes of sources come in order, or in reverse
            following = events[index].after
            if _earlier(events[index], events[one]):
                events[index].after = one
                one = index
            elif _earlier(events[index], events[tail]):
                break
            else:
                events[tail].after = index
                tail = index
            index = following
        events[tail].after = -1
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


READABLE = ("v", "u", "w", "gsyn_exc", "gsyn_inh")
"""State variables by number, see :func:`read`."""

_AHEAD: Final = 8
"""Number of neurons that are prefetched."""
_PIECE: Final = 1 << 17
"""Number of arrivals and updates of neurons after which compiled code returns: less than 1 s."""


@jit
def run(places: Array, until: float, end: float) -> int:
    """Simulate everything up to and including ``until``; ``end`` is the next number after it.

    Returns:
        ``DONE``; ``FULL`` if events or spikes need more room (enlarge the arrays and call again);
        ``DIVERGED`` if a neuron cannot be integrated; ``PAUSED`` if there is more to do (call again), because
        signals are handled only between calls. The result does not depend on these pauses.
    """
    engine = opened(EngineArrays, places)
    clock, events = engine.clock[0], engine.events
    event_slots = engine.event_slots
    last, left = len(event_slots) - 2, _PIECE
    while True:
        window_end = min((clock.slot + 1) * clock.width, end)
        slot = clock.slot & last
        waiting = clock.arriving < 0 and event_slots[slot] >= 0
        if waiting and not gather(
            clock, event_slots, events, engine.sorting, engine.bundle, engine.delay, window_end
        ):
            return FULL
        while clock.arriving >= 0:
            if left <= 0:
                return PAUSED
            left -= max(events[clock.arriving].n, 1)
            status = _arrive(engine, clock, events[clock.arriving])
            if status != DONE:
                return status
            release(clock, events)
        left = _wake(engine, clock, slot, window_end, left)
        if left < 0:
            return -left
        if window_end >= end:
            clock.now = until
            return DONE
        clock.slot += 1
        if clock.slot & last == 0:
            next_round(clock, event_slots, events)
            row = engine.cell_slots[last + 1]
            while row >= 0:
                following = engine.links[row].after
                _list(clock, engine.cell_slots, engine.links, engine.cells[row], engine.modes[row], row)
                row = following


@inlined
def _arrive(engine: EngineArrays, clock: Clock, event: Event) -> int:
    """Deliver a spike to all targets that it has not reached yet; returns as :func:`run`."""
    targets, weights, slots, t = engine.target, engine.weight, engine.cell_slots, event.time
    first, last = event.target, event.target + event.n - 1
    alike = event.n > 0 and engine.modes[targets[first] >> 1].kind >= 0  # all as the first, or nearly all
    if event.after >= 0:
        _fetch_ahead(engine, engine.events[event.after], alike)
    n, stop = max(event.n, 1), clock.arrived + _PIECE
    for k in range(clock.arrived, min(n, stop)):
        target, weight = event.target, event.weight
        if event.n > 0:
            target, weight = targets[first + k], weights[first + k]
            _fetch(engine.cells, engine.modes, targets[min(first + k + _AHEAD, last)] >> 1, alike)
        elif target < 0:
            target = engine.plastic[~target].target
        row = target >> 1
        cell, modes = engine.cells[row], engine.modes[row]
        if modes.wake <= t and modes.t < t if modes.kind >= 0 else cell.wake <= t and cell.t < t:
            status = _pass(engine, row, nextafter(t, inf))
            if status != DONE:
                clock.arrived = k
                return status
        if event.n == 0 and event.target < 0:
            synapse, slow = engine.plastic[~event.target], slow_of(engine.slow, ~event.target)
            weight = transmit(synapse, slow, engine.rules[synapse.rule], cell, engine.events, t)
            event.target = target
        if modes.kind >= 0:
            kind = engine.kinds[modes.kind]
            _add(clock, slots, engine.links, modes, kind, cell, row, target & 1, weight, t)
        else:
            _deliver(clock, slots, engine.links, cell, engine.work[0], row, target & 1, weight, t)
    if n > stop:
        clock.arrived = stop
        return PAUSED
    return DONE


@inlined
def _add(
    clock: Clock, slots: Array, links: Array, modes: Modes, kind: Kind, cell: Cell, row: int,
    inhibitory: int, weight: float, t: float,
) -> None:  # fmt: skip
    """Deliver a spike to a neuron that is a sum of exponentials, and plan its next update."""
    if kind.t != t:
        set_time(kind, t)
    deliver(modes, kind, cell, inhibitory, weight)
    if modes.wake < modes.listed:  # else an earlier entry stays
        modes.listed = schedule(clock, slots, links, modes.wake, row)


@inlined
def _deliver(
    clock: Clock, slots: Array, links: Array, cell: Cell, work: Work, row: int, inhibitory: int,
    weight: float, t: float,
) -> None:  # fmt: skip
    """Deliver a spike to another neuron, and plan its next update."""
    move(cell, t)
    receive(cell, inhibitory, weight)
    if is_linear(cell):
        plan(cell, work)
    else:  # once for all arrivals at this time
        cell.on_wake, cell.wake = START, t
    if cell.wake < cell.listed:
        cell.listed = schedule(clock, slots, links, cell.wake, row)


@inlined
def _wake(engine: EngineArrays, clock: Clock, slot: int, end: float, left: int) -> int:
    """Process the scheduled updates of the neurons in a window before ``end``.

    Args:
        engine: the arrays.
        clock: the one of the engine.
        slot: the list of the window.
        end: a time in it, or its end.
        left: how many neurons may be updated.

    Returns:
        How many are left, 0 or more; or the negative of what :func:`run` returns early.
    """
    cells, every = engine.cells, engine.modes
    row = engine.cell_slots[slot]
    while row >= 0:
        following = engine.links[row].after
        if following >= 0:
            prefetch(every, following, 0)
        if (every[row].wake if every[row].kind >= 0 else cells[row].wake) < end:
            if left <= 0:
                return -PAUSED
            left -= 1
            status = _pass(engine, row, end)
            if status != DONE:
                return -status
        _list(clock, engine.cell_slots, engine.links, cells[row], every[row], row)
        row = following
    return max(left, 0)


@inlined
def _list(clock: Clock, slots: Array, links: Array, cell: Cell, modes: Modes, row: int) -> None:
    """Move a neuron in the calendar to its next update."""
    listed = schedule(clock, slots, links, modes.wake if modes.kind >= 0 else cell.wake, row)
    if modes.kind >= 0:
        modes.listed = listed
    else:
        cell.listed = listed


@inlined
def _pass(engine: EngineArrays, row: int, end: float) -> int:
    """Process all scheduled updates of a neuron before ``end``; returns as :func:`run`."""
    clock, work, spikes, first = engine.clock[0], engine.work[0], engine.spikes, engine.first
    plastic, first_plastic = engine.plastic, engine.first_plastic
    cell, modes = engine.cells[row], engine.modes[row]
    n = 0
    while n < _PIECE and (modes.wake if modes.kind >= 0 else cell.wake) < end:
        n += 1
        if modes.kind >= 0 and postpone(modes, engine.kinds[modes.kind], cell):
            continue
        if cell.on_wake == SEARCH:
            search(cell, work)
            modes.wake, modes.on_wake = cell.wake, cell.on_wake
            prefetch(engine.bundle, first[cell.id], 0)  # it fires soon
            prefetch(engine.delay, first[cell.id], 0)
            continue
        if cell.on_wake == FIRE:
            if clock.n_spikes == len(spikes) or clock.n_free <= first[cell.id + 1] - first[cell.id]:
                return FULL
            spike = spikes[clock.n_spikes]
            spike.time, spike.id = cell.wake, cell.id
            clock.n_spikes += 1
            _send(engine, cell.id, cell.wake)
            if len(first_plastic) > 0 and first_plastic[row] < first_plastic[row + 1]:
                onto, after = first_plastic[row], first_plastic[row + 1]
                store_spike(cell, onto, after, plastic, engine.slow, engine.rules, clock, engine.events)
            fire(cell)
        elif cell.wake > cell.t:  # a neuron that starts now is already there
            move(cell, cell.wake)
        if not plan(cell, work):
            clock.failed = cell.id
            return DIVERGED
        if modes.kind >= 0:
            freeze(modes, engine.kinds[modes.kind], cell)
    return DONE if n < _PIECE else PAUSED


@inlined
def _fetch(cells: Array, modes: Array, row: int, of_modes: bool) -> None:
    """Prefetch the part of a neuron that every event needs."""
    if of_modes:
        prefetch(modes, row, 0)
        return
    for byte in range(HOT, COLD, CACHE_LINE):
        prefetch(cells, row, byte)


@inlined
def _fetch_ahead(engine: EngineArrays, event: Event, alike: bool) -> None:
    """Prefetch the first neuron of the next event, and the first target of the one after it."""
    if event.n > 0:
        _fetch(engine.cells, engine.modes, engine.target[event.target] >> 1, alike)
    if event.after >= 0 and engine.events[event.after].n > 0:
        prefetch(engine.target, engine.events[event.after].target, 0)
        prefetch(engine.weight, engine.events[event.after].target, 0)


@inlined
def _send(engine: EngineArrays, neuron: int, time: float) -> None:
    """Send a spike of a neuron to all its targets."""
    clock, slots, events = engine.clock[0], engine.event_slots, engine.events
    s, last = engine.first[neuron], engine.first[neuron + 1]
    while s < last:
        n, target, weight = abs(engine.bundle[s]), s, time
        if n == 0:
            target, weight = engine.target[s], engine.weight[s]
            if len(engine.dynamics) > 0 and engine.dynamics[s] >= 0:
                weight *= released_share(engine.short_term[engine.dynamics[s]], time)
        post(clock, slots, events, time + engine.delay[s], target, weight, n)
        while engine.bundle[s] < 0:
            s -= engine.bundle[s]
        s += max(abs(engine.bundle[s]), 1)


@jit
def emit(places: Array, neurons: Array, times: Array, begin: int) -> int:
    """Send spikes of source cells, from number ``begin`` on.

    Returns:
        The number of spikes sent; fewer than all if events need more room.
    """
    engine = opened(EngineArrays, places)
    clock = engine.clock[0]
    for k in range(begin, len(neurons)):
        if clock.n_free < engine.first[neurons[k] + 1] - engine.first[neurons[k]]:
            return k
        _send(engine, neurons[k], times[k])
    return len(neurons)


@jit
def inject(places: Array, neurons: Array, times: Array, weights: Array, inhibitory: int, begin: int) -> int:
    """Schedule events at neurons (global ids), from number ``begin`` on; returns as :func:`emit`."""
    engine = opened(EngineArrays, places)
    clock, slots, events, row_of = engine.clock[0], engine.event_slots, engine.events, engine.row_of
    for k in range(begin, len(neurons)):
        if clock.n_free == 0:
            return k
        post(clock, slots, events, times[k], 2 * row_of[neurons[k]] + inhibitory, weights[k], 0)
    return len(neurons)


@jit
def spread(places: Array) -> bool:
    """Fix the present weights of all spikes in transit; false if there is no room."""
    engine = opened(EngineArrays, places)
    clock, slots, events = engine.clock[0], engine.event_slots, engine.events
    for index in range(len(events)):
        event = events[index]
        first, n, sent = event.target, event.n, event.weight
        if n == 0:
            continue
        begin, last = first, first + n
        while sent > -inf and engine.bundle[begin] < 0:
            begin, last = last, last + abs(engine.bundle[last])
        if last - first > clock.n_free:
            return False
        event.target, event.weight, event.n = engine.target[first], engine.weight[first], 0
        for s in range(first + 1, last):
            arrival = event.time if s < first + n else sent + engine.delay[s]
            post(clock, slots, events, arrival, engine.target[s], engine.weight[s], 0)
    return True


@jit
def set_currents(places: Array, currents: Array) -> None:
    """Set constant currents (nA, by global id); neurons with the same current are not updated."""
    engine = opened(EngineArrays, places)
    for row in range(len(engine.cells)):
        cell, modes = engine.cells[row], engine.modes[row]
        if currents[cell.id] != cell.current:
            _begin_anew(engine, row)
            cell.current = currents[cell.id]
            if modes.kind >= 0:
                freeze(modes, engine.kinds[modes.kind], cell)


@jit
def begin_anew(engine: EngineArrays, rows: Array) -> None:
    """Advance cells to the present time, so that their parameters can change."""
    for row in rows:
        _begin_anew(engine, row)


@jit
def read(places: Array, neurons: Array, variable: int, out: Array) -> None:
    """Store a state variable of neurons (global ids): its number in ``READABLE``."""
    engine = opened(EngineArrays, places)
    now = engine.clock[0].now
    for k in range(len(neurons)):
        row = engine.row_of[neurons[k]]
        cell, modes = engine.cells[row], engine.modes[row]
        if modes.kind >= 0:  # such cells show no other variable
            out[k] = voltage_of(modes, engine.kinds[modes.kind], cell, now)
        elif variable == 0:
            out[k] = voltage_at(cell, now)
        elif variable <= 2:
            out[k] = state_at(cell, 1, now)
        else:
            out[k] = remaining_at(cell, variable - 3, now - cell.t)


@jit
def _begin_anew(engine: EngineArrays, row: int) -> None:
    """Advance a cell to the present time and schedule a new prediction; its record is to be frozen again."""
    clock, cell, modes = engine.clock[0], engine.cells[row], engine.modes[row]
    if modes.kind >= 0:
        thaw(modes, engine.kinds[modes.kind], cell)
    move(cell, clock.now)
    cell.on_wake, cell.wake = START, clock.now
    cell.listed = schedule(clock, engine.cell_slots, engine.links, cell.wake, row)
    modes.wake, modes.listed = cell.wake, cell.listed
