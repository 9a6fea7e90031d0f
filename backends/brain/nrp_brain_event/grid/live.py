"""Changes of cells of the grid between two runs."""

from __future__ import annotations

import numpy as np

from nrp_brain_event.cells import with_parameters
from nrp_brain_event.grid.equations import blocks as equations
from nrp_brain_event.grid.records import Grid, S, V
from nrp_brain_event.grid.runs import load_runs
from nrp_brain_event.neuron import move
from nrp_brain_event.records import ALPHA, START, Array, CellParameters
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.changes import ParameterChange
from nrp_core.brain.network.data import Network


def change_cells(
    grid: Grid, cells: Array, network: Network, change: ParameterChange, row_of: IntArray
) -> tuple[Grid, Array]:
    """Return the grid and the ``Cell`` in each row under other parameters from now on.

    The state of neurons stays: voltages, synaptic variables, ends of refractory periods.

    Raises:
        NetworkError: a parameter is impossible.
    """
    first_id = network.offsets[change.label]
    rows = row_of[first_id + change.index]
    if network.populations[change.label].equations is not None:
        grid, cells = equations.with_parameters(grid, network, change), cells.copy()
        every = row_of[network.ids_of(change.label)]
        cells["i_offset"][every] = equations.offsets_na(grid, network, change.label)
        return grid, cells
    changed = with_parameters(cells[rows], network.populations[change.label], change.values, first_id)
    before, cells = cells, cells.copy()
    for name in CellParameters.dtype().names or ():
        cells[name][rows] = changed[name]
    own = grid.cell_rows[rows]
    if (own >= 0).all():
        _begin_anew(grid.cells, own, float(grid.clock["step"][0] * grid.clock["h"][0]))
        for name in CellParameters.dtype().names or ():
            grid.cells[name][own] = changed[name]
        return grid, cells
    state = grid.state.copy()
    state[V] += before["v_rest"] - cells["v_rest"]
    alpha = cells["synapse"] == ALPHA
    state[S : S + 2, alpha] *= (cells["tau_syn"] / before["tau_syn"]).T[:, alpha]
    return with_runs(grid._replace(state=state), load_runs(cells, float(grid.clock["h"][0]))), cells


def offsets_of(grid: Grid, cells: Array) -> FloatArray:
    """Return the constant current into each row, nA; 0 for rows that are integrated one by one."""
    offsets: FloatArray = np.where(grid.cell_rows < 0, cells["i_offset"], 0.0)
    return offsets


def with_runs(grid: Grid, runs: Array) -> Grid:
    """Return the grid with its neurons in other runs; refractory ones go on waiting."""
    queue, old = grid.queue.copy(), grid.runs[grid.runs["n_waiting"] > 0]
    places = [
        run["first"] + (run["head"] + np.arange(run["n_waiting"])) % (run["last"] - run["first"])
        for run in old
    ]
    waiting = grid.queue[np.concatenate([np.empty(0, np.int64), *places])]
    waiting = waiting[np.argsort(grid.release[waiting], kind="stable")]
    of = np.searchsorted(runs["first"], waiting, "right") - 1
    for r in np.unique(of):
        mine = waiting[of == r]
        runs["n_waiting"][r] = len(mine)
        queue[runs["first"][r] : runs["first"][r] + len(mine)] = mine
    return grid._replace(runs=runs, queue=queue)


@jit
def _begin_anew(cells: Array, rows: IntArray, now: float) -> None:
    """Advance cells to the present time, and schedule their updates again."""
    for k in range(len(rows)):
        cell = cells[rows[k]]
        move(cell, now)
        cell.on_wake, cell.wake = START, now
