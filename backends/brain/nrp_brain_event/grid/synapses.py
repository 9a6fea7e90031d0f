"""What spikes do at their synapses: a kernel for each kind of synapses that a network has."""

from __future__ import annotations

from collections.abc import Callable

from nrp_brain_event.grid.delivery import Arrive, delivering
from nrp_brain_event.grid.records import PLASTIC, Grid, GridClock, Segment, Table
from nrp_brain_event.handles import opened
from nrp_brain_event.plasticity import store_spike, transmit
from nrp_brain_event.records import Array
from nrp_brain_event.synapse_kernels import released_share
from nrp_core._support.jit import inlined

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
        store_spike(memory, grid.plastic[first:last], grid.rules, grid.pool[0], grid.stored)
    return 0


@inlined
def transmitted(grid: Grid, row: int, arrival: float) -> float:
    """Return the weight with which a spike arrives over the plastic synapse in a row."""
    synapse = grid.plastic[row]
    memory = grid.memories[synapse.target >> 1]
    return transmit(synapse, grid.rules[synapse.rule], memory, grid.stored, arrival)


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
