"""Advance the lazy grid step by step, in the order of :mod:`nrp_brain_event.grid.advance`."""

from __future__ import annotations

from math import isfinite
from typing import Final

from nrp_brain_event.grid.advance import accept, emit
from nrp_brain_event.grid.delivery import delivering, transmitted
from nrp_brain_event.grid.lazy.neuron import bring, may_fire, receive
from nrp_brain_event.grid.lazy.records import FREE, Lazy, V, X
from nrp_brain_event.grid.lazy.show import show
from nrp_brain_event.grid.probes import take_samples
from nrp_brain_event.grid.records import PLASTIC, Grid, GridClock
from nrp_brain_event.handles import opened
from nrp_brain_event.records import DIVERGED, DONE, FULL, Array
from nrp_brain_event.short_term import released_share
from nrp_core._support.jit import inlined, jit, prefetch

_AHEAD: Final = 12
"""Number of targets that are prefetched."""


@jit
def run(places: Array, own: Array, sources: Array, inputs: Array, weights: Array, until: int) -> int:
    """Advance to a step.

    Args:
        places: places of the arrays of the grid, whose state is not used.
        own: places of the arrays of the lazy grid.
        sources: as for :func:`nrp_brain_event.grid.advance.run`, which also says what is returned.
        inputs: as there.
        weights: as there.
        until: the step.
    """
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    clock = grid.clock[0]
    while clock.step < until:
        step = clock.step + 1
        if not accept(clock, grid, sources, step):
            return FULL
        clock.n_fired = 0
        clock_of = lazy.clock[0]
        clock_of.n_early = _look(clock, grid, lazy, lazy.early, clock_of.n_early, step)
        n_early = clock.n_fired
        _deliver(clock, grid, lazy, step)
        _let_in(clock, grid, lazy, inputs, weights, step)
        clock_of.n_late = _look(clock, grid, lazy, lazy.late, clock_of.n_late, step)
        if clock.failed >= 0:
            return DIVERGED
        grid.fired[:n_early].sort()  # as in the plain grid, so that spikes arrive in the same order
        grid.fired[n_early : clock.n_fired].sort()
        emit(clock, grid, step, n_early)
        clock.step = step
        _sample(grid, lazy, step)
    return DONE


@jit
def _look(clock: GridClock, grid: Grid, lazy: Lazy, rows: Array, n: int, step: int) -> int:
    """Advance the listed neurons, fire those above threshold; return how many stay in the list."""
    neurons, kept, driven = lazy.neurons, 0, lazy.clock[0].driven
    lazy.clock[0].n_checked += n
    for k in range(n):
        row = rows[k]
        kind = lazy.kinds[lazy.kind_of[row]]
        current = grid.drive[row] if driven else 0.0
        bring(neurons, lazy.courses, kind, row, current, step)
        if kind.jump:
            neurons[row, V] += neurons[row, X]
            neurons[row, X] = 0.0
        if not isfinite(neurons[row, V]):
            clock.failed = grid.ids[row]
        if neurons[row, V] >= kind.threshold and step > neurons[row, FREE]:
            grid.fired[clock.n_fired] = row
            clock.n_fired += 1
            neurons[row, V] = kind.reset
            neurons[row, FREE] = step + kind.refractory
            if kind.frozen:
                for receptor in range(2 - kind.single):
                    neurons[row, X + receptor] = 0.0
        if may_fire(neurons, kind, row, current):
            rows[kept] = row
            kept += 1
        else:
            lazy.listed[row] = False
    return kept


@jit
def _arrive(clock: GridClock, grid: Grid, lazy: Lazy, segment: int, step: int) -> None:
    table = grid.tables[grid.segment_table[segment]]
    first, n = grid.segment_start[segment], grid.segment_length[segment]
    variable, base = table.line // len(grid.drive), table.line % len(grid.drive)
    targets, width = grid.targets[first : first + n], lazy.neurons.shape[1]
    lazy.clock[0].n_arrived += n
    for k in range(n):
        prefetch(lazy.neurons, (base + targets[min(k + _AHEAD, n - 1)]) * width, 0)
        weight = table.weight
        if table.dynamic == PLASTIC:
            weight = transmitted(grid, grid.plastic_rows[first + k + table.dynamics], step * clock.h)
        elif table.own:
            weight = grid.weights[first + k + table.weights]
            if table.dynamic:
                weight *= released_share(grid.short_term[first + k + table.dynamics], step * clock.h)
        receive(lazy, grid.drive, base + targets[k], variable, weight, step)


_deliver = delivering(_arrive)


@inlined
def _let_in(clock: GridClock, grid: Grid, lazy: Lazy, inputs: Array, weights: Array, step: int) -> None:
    """Apply the inputs outside the calendar that are due."""
    n_rows = len(grid.drive)
    while clock.n_inputs < inputs.shape[1] and inputs[0, clock.n_inputs] <= step:
        line, synapse, weight = inputs[1, clock.n_inputs], inputs[2, clock.n_inputs], weights[clock.n_inputs]
        if synapse >= 0:
            weight = transmitted(grid, synapse, step * clock.h)
        receive(lazy, grid.drive, line % n_rows, line // n_rows, weight, step)
        clock.n_inputs += 1


@inlined
def _sample(grid: Grid, lazy: Lazy, step: int) -> None:
    """Take the samples that are due at a step."""
    for k in range(len(grid.probes)):
        probe = grid.probes[k]
        if probe.taken < probe.n_steps and grid.probe_steps[probe.step + probe.taken] == step:
            for j in range(probe.row, probe.row + probe.n_rows):
                show(grid, lazy, grid.probe_rows[j], step)
    take_samples(grid, step)
