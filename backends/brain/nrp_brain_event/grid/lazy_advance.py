"""Advance the lazy grid step by step, in the order of :mod:`nrp_brain_event.grid.advance`."""

from __future__ import annotations

from math import isfinite
from typing import Final

from nrp_brain_event.grid.advance import accept, emit
from nrp_brain_event.grid.inputs import arrange
from nrp_brain_event.grid.lazy_neuron import IN_LIST, NONE, Lazy, bring, may_fire, receive, show
from nrp_brain_event.grid.records import LOOK_AT_BLOCKS, PLASTIC, TAKE_SAMPLES, Grid, GridClock, Table
from nrp_brain_event.grid.synapses import delivering, transmitted
from nrp_brain_event.handles import call, opened
from nrp_brain_event.records import DIVERGED, DONE, FULL, Array
from nrp_brain_event.synapse_kernels import released_share
from nrp_core._support.jit import borrowed, inlined, jit, prefetch

_AHEAD: Final = 12
"""Number of targets that are prefetched."""


@jit
def run(places: Array, own: Array, until: int) -> int:
    """Advance to a step.

    Args:
        places: places of the arrays of the grid, whose state is not used.
        own: places of the arrays of the lazy grid.
        until: the step.

    Returns:
        ``DONE``, ``FULL`` or ``DIVERGED``, as :func:`nrp_brain_event.grid.advance.run`.
    """
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    clock = grid.clock[0]
    arrange(clock, grid.sources, grid.arrivals)
    while clock.step < until:
        step = clock.step + 1
        if not accept(clock, grid, places, step):
            return FULL
        clock.n_fired = 0
        clock_of = lazy.clock[0]
        if clock_of.n_early > 0:
            clock_of.n_early = _look(clock, grid, lazy, lazy.early, clock_of.n_early, step)
        n_early = clock.n_fired
        _deliver(clock, grid, lazy, step)
        _let_in(clock, grid, lazy, step)
        if clock_of.n_late > 0:
            clock_of.n_late = _look(clock, grid, lazy, lazy.late, clock_of.n_late, step)
        if len(lazy.blocks) > 0:
            call(grid.codes[LOOK_AT_BLOCKS], (places, own, step))
        if clock.failed >= 0:
            return DIVERGED
        grid.fired[:n_early].sort()  # as in the plain grid, so that spikes arrive in the same order
        grid.fired[n_early : clock.n_fired].sort()
        emit(clock, grid, places, step, n_early)
        clock.step = step
        if len(grid.probes) > 0:
            _show_samples(places, own, step)
            call(grid.codes[TAKE_SAMPLES], (places, step))
    return DONE


@jit
def _look(clock: GridClock, grid: Grid, lazy: Lazy, rows: Array, n: int, step: int) -> int:
    """Advance the listed neurons, fire those above threshold; return how many stay in the list."""
    grid, lazy = borrowed(grid), borrowed(lazy)
    neurons, kept, driven = lazy.neurons, 0, lazy.clock[0].driven
    lazy.clock[0].n_checked += n
    for k in range(n):
        row = rows[k]
        neuron = neurons[row]
        kind = lazy.kinds[neuron.kind]
        current = grid.drive[row] if driven else 0.0
        bring(neuron, lazy.courses, kind, current, step)
        if kind.jump:
            neuron.v += neuron.x[0]
            neuron.x[0] = 0.0
        if not isfinite(neuron.v):
            clock.failed = grid.ids[row]
        if neuron.v >= kind.threshold and step > neuron.free:
            grid.fired[clock.n_fired] = row
            clock.n_fired += 1
            neuron.v = kind.reset
            neuron.free = step + kind.refractory
            if kind.frozen:
                neuron.x[0] = neuron.x[1] = 0.0
        if may_fire(neuron, kind, current):
            rows[kept] = row
            kept += 1
        else:
            neuron.listed = 0
    return kept


@inlined
def _arrive(clock: GridClock, grid: Grid, lazy: Lazy, segment: int, step: int) -> None:
    grid, lazy = borrowed(grid), borrowed(lazy)
    passed = grid.segments[segment]
    table, first, n = grid.tables[passed.table], passed.start, passed.length
    variable, base = table.line // len(grid.drive), table.line % len(grid.drive)
    targets, driven = grid.targets[first : first + n], lazy.clock[0].driven
    lazy.clock[0].n_arrived += n
    if table.dynamic:
        for k in range(n):
            row = base + targets[k]
            weight = _modulated(grid, table, first + k, step * clock.h)
            receive(lazy, grid.drive[row], row, variable, weight, step)
        return
    own, weight = table.own, table.weight
    weights = grid.weights[first + table.weights : first + table.weights + n * own]
    for k in range(n):
        _fetch(lazy, base + targets[min(k + _AHEAD, n - 1)])
        row = base + targets[k]
        if own:
            weight = weights[k]
        receive(lazy, grid.drive[row] if driven else 0.0, row, variable, weight, step)


@inlined
def _fetch(lazy: Lazy, row: int) -> None:
    """Prefetch the data of a neuron that an arrival uses."""
    if len(lazy.blocks) > 0 and lazy.owners[row] != NONE:
        owner = lazy.owners[row]
        block = lazy.blocks[owner if owner >= 0 else owner + IN_LIST]
        prefetch(lazy.states, block.state + (row - block.first) * block.width, 0)
    else:
        prefetch(lazy.neurons, row, 0)


@inlined
def _modulated(grid: Grid, table: Table, synapse: int, t: float) -> float:
    """Return the weight with which a spike arrives at a time (ms) over a synapse with dynamics."""
    if table.dynamic == PLASTIC:
        return transmitted(grid, grid.plastic_rows[synapse + table.dynamics], t)
    weight: float = grid.weights[synapse + table.weights]
    return weight * released_share(grid.short_term[synapse + table.dynamics], t)


_deliver = delivering(_arrive)


@inlined
def _let_in(clock: GridClock, grid: Grid, lazy: Lazy, step: int) -> None:
    """Apply the inputs outside the calendar that are due."""
    n_rows = len(grid.drive)
    while clock.arrival < clock.n_arrivals and grid.arrivals[clock.arrival].step <= step:
        arrival = grid.arrivals[clock.arrival]
        row, weight = arrival.target % n_rows, arrival.weight
        if arrival.synapse >= 0:
            weight = transmitted(grid, arrival.synapse, step * clock.h)
        receive(lazy, grid.drive[row], row, arrival.target // n_rows, weight, step)
        clock.arrival += 1


@inlined
def _show_samples(places: Array, own: Array, step: int) -> None:
    """Show the neurons of which samples are due at a step."""
    grid = opened(Grid, places)
    for k in range(len(grid.probes)):
        probe = grid.probes[k]
        if probe.taken < probe.n_steps and grid.probe_steps[probe.step + probe.taken] == step:
            for j in range(probe.row, probe.row + probe.n_rows):
                show(places, own, grid.probe_rows[j], step)
