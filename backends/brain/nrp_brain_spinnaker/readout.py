"""State of neurons between two ticks, in users' units."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.host.conversion import from_accum
from nrp_brain_spinnaker.host.initial_state import GATES, ROWS, state_scale
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.hodgkin_huxley import OPEN
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import Ring, transfer
from nrp_brain_spinnaker.machine.synaptic_inputs import add_arrived, read_values
from nrp_brain_spinnaker.models import GSYN, ISYN, CellModel
from nrp_core._support.arrays import FloatArray


def read(cells: Cells, ring: Ring, tick: int, population: int, model: CellModel, variable: str) -> FloatArray:
    """Return a state variable of a population at the beginning of a tick."""
    own = cells.neurons(population)
    if variable in GATES:
        return np.asarray(cells.state[GATES[variable], own] / OPEN)
    if variable not in (*GSYN, *ISYN):
        return from_accum(cells.state[ROWS[variable], own]) / state_scale(model, variable)
    cells = _with_input(cells, ring, tick, population)
    raw = cells.value[int(variable.endswith("inh")), own]
    if model.input == kinds.CONDUCTANCE:  # the machine uses and records it without the last ten bits
        return from_accum(raw >> 10)
    return from_accum(raw) / model.weight_scale


def _with_input(cells: Cells, ring: Ring, tick: int, population: int) -> Cells:
    """Return the cells with the synaptic values that a machine records: those with the input of the tick."""
    now = ring.slots[[tick & (ring.slots.shape[0] - 1)]]
    cells = cells._replace(synapse_state=cells.synapse_state.copy())
    transfer(cells, Ring(now, ring.device.copy(), ring.saturated.copy()), population, 0)
    add_arrived(cells, population)
    read_values(cells, population)
    return cells
