"""State variables of neurons on a grid, and the check that they are finite."""

from __future__ import annotations

from math import isfinite

import numpy as np

from nrp_brain_event.grid.records import Grid, V, X
from nrp_brain_event.handles import opened
from nrp_brain_event.kernels import READABLE
from nrp_brain_event.neuron import voltage_at
from nrp_brain_event.records import Array
from nrp_brain_event.runge_kutta import state_at
from nrp_brain_event.synapses import remaining_at
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit


def read(grid: Grid, rows: IntArray, variable: str) -> FloatArray:
    """Return the present values of a state variable of rows."""
    if variable == "v":
        of = grid.runs[np.searchsorted(grid.runs["first"], rows, "right") - 1]
        above_rest = grid.state[V, rows]
        values = of["v_rest"] + np.where(np.isnan(above_rest), of["reset"], above_rest)
    else:
        values = grid.state[X + (variable == "gsyn_inh"), rows]
    now = float(grid.clock["step"][0] * grid.clock["h"][0])
    _read_cells(grid.cells, grid.cell_rows[rows], READABLE.index(variable), now, values)
    return values


def lost_row(grid: Grid) -> int:
    """Return a row whose voltage is not a number; there must be one, see :func:`is_lost`."""
    lost = ~np.isfinite(grid.state[V])
    for run in grid.runs[grid.runs["n_waiting"] > 0]:
        places = (run["head"] + np.arange(run["n_waiting"])) % (run["last"] - run["first"])
        lost[grid.queue[run["first"] + places]] = False
    return int(np.argmax(lost))


@jit
def is_lost(places: Array) -> bool:
    """Return whether a voltage is not a number; those of refractory rows are NaN by design."""
    grid = opened(Grid, places)
    n = 0
    for row in range(len(grid.drive)):
        n += not isfinite(grid.state[V, row])
    for k in range(len(grid.runs)):
        n -= grid.runs[k].n_waiting
    return n > 0


@jit
def _read_cells(cells: Array, indices: IntArray, variable: int, now: float, out: FloatArray) -> None:
    for k in range(len(indices)):
        if indices[k] >= 0:
            cell = cells[indices[k]]
            if variable == 0:
                out[k] = voltage_at(cell, now)
            elif variable <= 2:
                out[k] = state_at(cell, 1, now)
            else:
                out[k] = remaining_at(cell, variable - 3, now - cell.t)
