"""Neurons of the lazy grid as the plain grid would hold them, without moving them."""

from __future__ import annotations

from math import nan

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.lazy.neuron import bring
from nrp_brain_event.grid.lazy.records import Lazy
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.jit import jit


@jit
def show(grid: Grid, lazy: Lazy, row: int, step: int) -> None:
    """Write the present state of a neuron into that of the plain grid."""
    state, before = grid.state, lazy.neurons[row : row + 1].copy()
    neuron = lazy.neurons[row]
    kind = lazy.kinds[neuron.kind]
    bring(neuron, lazy.courses, kind, grid.drive[row], step)
    is_held = step <= neuron.free and kind.refractory + kind.frozen > 0
    state[grid_records.V, row] = nan if is_held else neuron.v
    if kind.jump:
        state[grid_records.V, row] += neuron.x[0]
    else:
        for k in range(2 - kind.single):
            state[grid_records.X + k, row] = neuron.x[k]
            if kind.alpha:
                state[grid_records.S + k, row] = neuron.s[k]
    lazy.neurons[row : row + 1] = before


@jit
def show_all(places: Array, own: Array, rows: Array) -> None:
    """Write the present state of neurons into that of the plain grid."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    for k in range(len(rows)):
        show(grid, lazy, rows[k], grid.clock[0].step)
