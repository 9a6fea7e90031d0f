"""The compiled functions that the brain calls: run, let spikes in, change currents, read."""

from __future__ import annotations

from typing import Final

from nrp_brain_event.agenda import gather, next_round, post, schedule
from nrp_brain_event.neuron import advance, fire, move, voltage_at
from nrp_brain_event.records import COLD, DIVERGED, DONE, FIRE, FULL, HOT, START, Array, Engine
from nrp_brain_event.runge_kutta import state_at
from nrp_brain_event.short_term import released_share
from nrp_brain_event.spike_timing import remember
from nrp_brain_event.synapses import remaining_at
from nrp_core.jit import CACHE_LINE, borrowed, inlined, jit, prefetch

READABLE = ("v", "u", "w", "gsyn_exc", "gsyn_inh")
"""State variables by number, see :func:`read`."""

_AHEAD: Final = 5
"""How many neurons are fetched before they are needed."""


@jit
def run(engine: Engine, until: float, end: float) -> int:
    """Simulate everything up to and including ``until``; ``end`` is the next number after it.

    Returns:
        ``DONE``; ``FULL`` where events or spikes need more room (give it and call again);
        ``DIVERGED`` where a neuron cannot be integrated.
    """
    clock, work, spikes = borrowed(engine.clock)[0], borrowed(engine.work)[0], borrowed(engine.spikes)
    cells, events, first = borrowed(engine.cells), borrowed(engine.events), borrowed(engine.first)
    event_slots, cell_slots = borrowed(engine.event_slots), borrowed(engine.cell_slots)
    ready, rules = borrowed(engine.ready), borrowed(engine.rules)
    plastic, first_plastic = borrowed(engine.plastic), borrowed(engine.first_plastic)
    last = len(event_slots) - 2
    while True:
        window_end = min((clock.slot + 1) * clock.width, end)
        slot = clock.slot & last
        if clock.n_ready == 0 and (event_slots[slot] >= 0 or cell_slots[slot] >= 0):
            gather(clock, event_slots, cell_slots, events, cells, plastic, ready, window_end)
        while clock.n_ready > 0:
            row = ready[clock.n_ready - 1]
            cell = cells[row]
            _fetch(cells, ready[max(clock.n_ready - 1 - _AHEAD, 0)])
            if not advance(cell, clock, events, plastic, rules, work, window_end):
                clock.failed = cell.id
                return DIVERGED
            if cell.on_wake == FIRE and cell.wake < window_end:
                if clock.n_spikes == len(spikes) or clock.n_free <= first[cell.id + 1] - first[cell.id]:
                    return FULL
                spike = spikes[clock.n_spikes]
                spike.time, spike.id = cell.wake, cell.id
                clock.n_spikes += 1
                _send(engine, cell.id, cell.wake)
                if len(first_plastic) > 0 and first_plastic[row] < first_plastic[row + 1]:
                    onto = plastic[first_plastic[row] : first_plastic[row + 1]]
                    remember(cell, onto, rules, clock, events)
                fire(cell)
            else:
                cell.ready = 0
                schedule(clock, cell_slots, cells, row)
                clock.n_ready -= 1
        if window_end >= end:
            clock.now = until
            return DONE
        clock.slot += 1
        if clock.slot & last == 0:
            next_round(clock, event_slots, cell_slots, events, cells)


@inlined
def _fetch(cells: Array, row: int) -> None:
    """Let the processor fetch what every event needs of a neuron."""
    for byte in range(HOT, COLD, CACHE_LINE):
        prefetch(cells, row, byte)


@inlined
def _send(engine: Engine, neuron: int, time: float) -> None:
    """Put a spike of a neuron on its way to all its targets."""
    clock, slots, events = borrowed(engine.clock)[0], borrowed(engine.event_slots), borrowed(engine.events)
    first, target, delay = borrowed(engine.first), borrowed(engine.target), borrowed(engine.delay)
    weights, dynamics = borrowed(engine.weight), borrowed(engine.dynamics)
    short_term = borrowed(engine.short_term)
    for s in range(first[neuron], first[neuron + 1]):
        weight = weights[s]
        if len(dynamics) > 0 and dynamics[s] >= 0:
            weight *= released_share(short_term[dynamics[s]], time)
        post(clock, slots, events, time + delay[s], target[s], weight)


@jit
def emit(engine: Engine, neurons: Array, times: Array, begin: int) -> int:
    """Put spikes of source cells on their way, from number ``begin`` on.

    Returns:
        How many of all are done; less than all where events need more room.
    """
    clock = borrowed(engine.clock)[0]
    for k in range(begin, len(neurons)):
        if clock.n_free < engine.first[neurons[k] + 1] - engine.first[neurons[k]]:
            return k
        _send(engine, neurons[k], times[k])
    return len(neurons)


@jit
def inject(engine: Engine, neurons: Array, times: Array, weights: Array, inhibitory: int, begin: int) -> int:
    """Let events arrive at neurons (global ids), from number ``begin`` on; returns as :func:`emit`."""
    clock = borrowed(engine.clock)[0]
    slots, events, row_of = borrowed(engine.event_slots), borrowed(engine.events), borrowed(engine.row_of)
    for k in range(begin, len(neurons)):
        if clock.n_free == 0:
            return k
        post(clock, slots, events, times[k], 2 * row_of[neurons[k]] + inhibitory, weights[k])
    return len(neurons)


@jit
def set_currents(engine: Engine, currents: Array) -> None:
    """Hold these currents (nA, by global id) from now on; neurons whose current stays are not touched."""
    cells = engine.cells
    for row in range(len(cells)):
        cell = cells[row]
        if currents[cell.id] != cell.current:
            _begin_anew(engine, row)
            cell.current = currents[cell.id]


@jit
def begin_anew(engine: Engine, rows: Array) -> None:
    """Bring cells to what they are now, so that their parameters can change."""
    for row in rows:
        _begin_anew(engine, row)


@jit
def read(engine: Engine, neurons: Array, variable: int, out: Array) -> None:
    """Store a state variable of neurons (global ids): its number in ``READABLE``."""
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
def _begin_anew(engine: Engine, row: int) -> None:
    """Bring a cell to what it is now and let its course be planned anew."""
    clock, cells = engine.clock[0], engine.cells
    cell = cells[row]
    move(cell, clock.now)
    cell.on_wake, cell.wake = START, clock.now
    schedule(clock, engine.cell_slots, cells, row)
