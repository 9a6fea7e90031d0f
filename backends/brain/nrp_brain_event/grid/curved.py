"""Neurons without a closed form on the grid: adaptive exponential, Izhikevich, Hodgkin-Huxley.

Each is integrated as in the exact mode. Arrivals are on the grid. A threshold crossing resets the neuron at
its exact time; the spike gets the time of the next grid point, and there is at most one in a step.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid.records import Grid, X
from nrp_brain_event.handles import opened
from nrp_brain_event.neuron import fire, move, plan
from nrp_brain_event.records import FIRE, Array, Cell, Work, constant
from nrp_brain_event.records import JUMP as JUMP_SYNAPSE
from nrp_brain_event.synaptic_inputs import arrive
from nrp_core._support.jit import jit

_QUIET: Final = constant(0)
_FIRED: Final = constant(1)
_DIVERGED: Final = constant(2)


def update_curved(places: Array, number: int, step: int) -> int:
    """Advance the neurons of a run to a grid point, apply their input, and list those that fire."""
    grid = opened(Grid, places)
    clock, run = grid.clock[0], grid.runs[number]
    arrived, arrived_inhibition = grid.state[X], grid.state[X + 1]
    for row in range(run.first, run.last):
        cell = grid.cells[grid.cell_rows[row]]
        what = _update_cell(cell, grid.work[0], arrived[row], arrived_inhibition[row], step * clock.h)
        arrived[row] = arrived_inhibition[row] = 0.0
        if what == _DIVERGED:
            clock.failed = grid.ids[row]
        elif what == _FIRED:
            grid.fired[clock.n_fired] = row
            clock.n_fired += 1
    return 0


def set_curved_current(places: Array, row: int, current: float) -> int:
    """Set the current (nA) into the neuron in a row from now on; 0 if it cannot be integrated."""
    grid = opened(Grid, places)
    clock, cell = grid.clock[0], grid.cells[grid.cell_rows[row]]
    if current == cell.current:
        return 1
    move(cell, clock.step * clock.h)
    cell.current = current
    return int(plan(cell, grid.work[0]))


@jit
def _update_cell(cell: Cell, work: Work, excitation: float, inhibition: float, t: float) -> int:
    """Advance a neuron to the grid point t (ms) and apply its input there; return the result."""
    what = _QUIET
    while cell.wake <= t:
        if cell.on_wake == FIRE:
            if what == _FIRED:
                break
            what = _FIRED
            fire(cell)
            cell.free_at = max(cell.free_at, t)
        else:
            move(cell, cell.wake)
        if not plan(cell, work):
            return _DIVERGED
    if excitation != 0.0 or inhibition != 0.0:
        move(cell, t)
        if cell.synapse != JUMP_SYNAPSE:
            arrive(cell, 0, excitation)
            arrive(cell, 1, inhibition)
        elif t >= cell.free_at:
            cell.path[0, 0] += excitation + inhibition
        if not plan(cell, work):
            return _DIVERGED
    return what
