"""Neurons of the lazy grid as the plain grid would hold them, without moving them."""

from __future__ import annotations

from math import nan

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.lazy.neuron import bring
from nrp_brain_event.grid.lazy.records import FREE, Lazy, S, V, X
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.jit import jit


@jit
def show(grid: Grid, lazy: Lazy, row: int, step: int) -> None:
    """Write the present state of a neuron into that of the plain grid."""
    kind, state = lazy.kinds[lazy.kind_of[row]], grid.state
    before = lazy.neurons[row].copy()
    bring(lazy.neurons, lazy.courses, kind, row, grid.drive[row], step)
    now = lazy.neurons[row].copy()
    lazy.neurons[row] = before
    state[grid_records.V, row] = nan if step <= now[FREE] and kind.refractory + kind.frozen > 0 else now[V]
    if kind.jump:
        state[grid_records.V, row] += now[X]
        return
    for k in range(2 - kind.single):
        state[grid_records.X + k, row] = now[X + k]
        if kind.alpha:
            state[grid_records.S + k, row] = now[S + k]


@jit
def show_all(places: Array, own: Array, rows: Array) -> None:
    """Write the present state of neurons into that of the plain grid."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    for k in range(len(rows)):
        show(grid, lazy, rows[k], grid.clock[0].step)
