"""Neurons without a closed form on the grid: adaptive exponential, Izhikevich, Hodgkin-Huxley.

Each is integrated as in the exact mode. Arrivals are on the grid. A threshold crossing resets the neuron at
its exact time; the spike gets the time of the next grid point, and there is at most one in a step.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.neuron import fire, move, plan
from nrp_brain_event.records import FIRE, Cell, Work, constant
from nrp_brain_event.records import JUMP as JUMP_SYNAPSE
from nrp_brain_event.synaptic_inputs import arrive
from nrp_core._support.jit import jit

QUIET: Final = constant(0)
FIRED: Final = constant(1)
DIVERGED: Final = constant(2)


@jit
def update_cell(cell: Cell, work: Work, excitation: float, inhibition: float, t: float) -> int:
    """Advance a neuron to the grid point t (ms) and apply its input there; return the result."""
    what = QUIET
    while cell.wake <= t:
        if cell.on_wake == FIRE:
            if what == FIRED:
                break
            what = FIRED
            fire(cell)
            cell.free_at = max(cell.free_at, t)
        else:
            move(cell, cell.wake)
        if not plan(cell, work):
            return DIVERGED
    if excitation != 0.0 or inhibition != 0.0:
        move(cell, t)
        if cell.synapse != JUMP_SYNAPSE:
            arrive(cell, 0, excitation)
            arrive(cell, 1, inhibition)
        elif t >= cell.free_at:
            cell.path[0, 0] += excitation + inhibition
        if not plan(cell, work):
            return DIVERGED
    return what


@jit
def set_cell_current(cell: Cell, work: Work, current: float, t: float) -> bool:
    """Set the current (nA) into a neuron from the grid point t on; false if it cannot be integrated."""
    if current == cell.current:
        return True
    move(cell, t)
    cell.current = current
    return plan(cell, work)
