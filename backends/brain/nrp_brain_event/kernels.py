"""The compiled functions that the brain calls: run, add spikes, change currents, read.

Functions that are called in every step take the ``places`` of a :class:`~nrp_brain_event.handles.Handle`.
"""

from __future__ import annotations

from math import inf, nextafter
from typing import Final

from nrp_brain_event.agenda import gather, next_round, post, release, reschedule, schedule
from nrp_brain_event.compiled_laws import released_share
from nrp_brain_event.handles import opened
from nrp_brain_event.linear import is_linear, search
from nrp_brain_event.neuron import fire, move, plan, receive, voltage_at
from nrp_brain_event.plasticity import store_spike, transmit
from nrp_brain_event.records import (
    COLD,
    DIVERGED,
    DONE,
    FIRE,
    FULL,
    HOT,
    SEARCH,
    START,
    WAKE,
    Array,
    Clock,
    EngineArrays,
    Event,
)
from nrp_brain_event.runge_kutta import state_at
from nrp_brain_event.synaptic_inputs import remaining_at
from nrp_core._support.arrays import CACHE_LINE
from nrp_core._support.jit import inlined, jit, prefetch

READABLE = ("v", "u", "w", "gsyn_exc", "gsyn_inh")
"""State variables by number, see :func:`read`."""

_AHEAD: Final = 8
"""Number of neurons that are prefetched."""


@jit
def run(places: Array, until: float, end: float) -> int:
    """Simulate everything up to and including ``until``; ``end`` is the next number after it.

    Returns:
        ``DONE``; ``FULL`` if events or spikes need more room (enlarge the arrays and call again);
        ``DIVERGED`` if a neuron cannot be integrated.
    """
    engine = opened(EngineArrays, places)
    clock, cells, events = engine.clock[0], engine.cells, engine.events
    event_slots, cell_slots, links = engine.event_slots, engine.cell_slots, engine.links
    last = len(event_slots) - 2
    while True:
        window_end = min((clock.slot + 1) * clock.width, end)
        slot = clock.slot & last
        if clock.arriving < 0 and event_slots[slot] >= 0:
            gather(clock, event_slots, events, engine.sorting, window_end)
        while clock.arriving >= 0:
            status = _arrive(engine, clock, cells, events[clock.arriving])
            if status != DONE:
                return status
            release(clock, events)
        status = _wake(engine, clock, cells, links, slot, window_end)
        if status != DONE:
            return status
        if window_end >= end:
            clock.now = until
            return DONE
        clock.slot += 1
        if clock.slot & last == 0:
            next_round(clock, event_slots, cell_slots, events, links, cells)


@inlined
def _arrive(engine: EngineArrays, clock: Clock, cells: Array, event: Event) -> int:
    """Deliver a spike to all targets that it has not reached yet; returns as :func:`run`."""
    targets, weights, slots, t = engine.target, engine.weight, engine.cell_slots, event.time
    first, last = event.target, event.target + event.n - 1
    for k in range(clock.arrived, max(event.n, 1)):
        target, weight = event.target, event.weight
        if event.n > 0:
            target, weight = targets[first + k], weights[first + k]
            _fetch(cells, targets[min(first + k + _AHEAD, last)] >> 1)
        elif target < 0:
            target = engine.plastic[~target].target
        row = target >> 1
        cell = cells[row]
        if cell.wake <= t and cell.t < t:
            status = _pass(engine, row, nextafter(t, inf))
            if status != DONE:
                clock.arrived = k
                return status
        move(cell, t)
        if event.n == 0 and event.target < 0:
            synapse = engine.plastic[~event.target]
            event.target, weight = (
                target,
                transmit(synapse, engine.rules[synapse.rule], cell, engine.events, t),
            )
        receive(cell, target & 1, weight)
        if is_linear(cell):
            plan(cell, engine.work[0])
        else:  # once for all arrivals at this time
            cell.on_wake, cell.wake = START, t
        schedule(clock, slots, engine.links, cell, row)
    return DONE


@inlined
def _wake(engine: EngineArrays, clock: Clock, cells: Array, links: Array, slot: int, end: float) -> int:
    """Process the scheduled updates of the neurons in a window before ``end``; returns as :func:`run`."""
    row = engine.cell_slots[slot]
    while row >= 0:
        following = links[row].after
        if following >= 0:
            prefetch(cells, following, WAKE)
        if cells[row].wake < end:
            status = _pass(engine, row, end)
            if status != DONE:
                return status
        reschedule(clock, engine.cell_slots, links, cells[row], row)
        row = following
    return DONE


@inlined
def _pass(engine: EngineArrays, row: int, end: float) -> int:
    """Process all scheduled updates of a neuron before ``end``; returns as :func:`run`."""
    clock, work, spikes, first = engine.clock[0], engine.work[0], engine.spikes, engine.first
    plastic, first_plastic = engine.plastic, engine.first_plastic
    cell = engine.cells[row]
    while cell.wake < end:
        if cell.on_wake == SEARCH:
            search(cell, work)
            continue
        if cell.on_wake == FIRE:
            if clock.n_spikes == len(spikes) or clock.n_free <= first[cell.id + 1] - first[cell.id]:
                return FULL
            spike = spikes[clock.n_spikes]
            spike.time, spike.id = cell.wake, cell.id
            clock.n_spikes += 1
            _send(engine, cell.id, cell.wake)
            if len(first_plastic) > 0 and first_plastic[row] < first_plastic[row + 1]:
                onto = plastic[first_plastic[row] : first_plastic[row + 1]]
                store_spike(cell, onto, engine.rules, clock, engine.events)
            fire(cell)
        elif cell.wake > cell.t:  # a neuron that starts now is already there
            move(cell, cell.wake)
        if not plan(cell, work):
            clock.failed = cell.id
            return DIVERGED
    return DONE


@inlined
def _fetch(cells: Array, row: int) -> None:
    """Prefetch the part of a neuron that every event needs."""
    for byte in range(HOT, COLD, CACHE_LINE):
        prefetch(cells, row, byte)


@inlined
def _send(engine: EngineArrays, neuron: int, time: float) -> None:
    """Send a spike of a neuron to all its targets."""
    clock, slots, events = engine.clock[0], engine.event_slots, engine.events
    s, last = engine.first[neuron], engine.first[neuron + 1]
    while s < last:
        n, target, weight = engine.bundle[s], s, 0.0
        if n == 0:
            target, weight = engine.target[s], engine.weight[s]
            if len(engine.dynamics) > 0 and engine.dynamics[s] >= 0:
                weight *= released_share(engine.short_term[engine.dynamics[s]], time)
        post(clock, slots, events, time + engine.delay[s], target, weight, n)
        s += max(n, 1)


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
        first, n = event.target, event.n
        if n > clock.n_free:
            return False
        if n > 0:
            event.target, event.weight, event.n = engine.target[first], engine.weight[first], 0
        for s in range(first + 1, first + n):
            post(clock, slots, events, event.time, engine.target[s], engine.weight[s], 0)
    return True


@jit
def set_currents(places: Array, currents: Array) -> None:
    """Set constant currents (nA, by global id); neurons with the same current are not updated."""
    engine = opened(EngineArrays, places)
    cells = engine.cells
    for row in range(len(cells)):
        cell = cells[row]
        if currents[cell.id] != cell.current:
            _begin_anew(engine, row)
            cell.current = currents[cell.id]


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
        cell = engine.cells[engine.row_of[neurons[k]]]
        if variable == 0:
            out[k] = voltage_at(cell, now)
        elif variable <= 2:
            out[k] = state_at(cell, 1, now)
        else:
            out[k] = remaining_at(cell, variable - 3, now - cell.t)


@jit
def _begin_anew(engine: EngineArrays, row: int) -> None:
    """Advance a cell to the present time and schedule a new prediction."""
    clock, cells = engine.clock[0], engine.cells
    cell = cells[row]
    move(cell, clock.now)
    cell.on_wake, cell.wake = START, clock.now
    schedule(clock, engine.cell_slots, engine.links, cell, row)
