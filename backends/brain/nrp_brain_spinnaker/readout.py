"""State of neurons between two ticks, in users' units."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.host.conversion import from_accum
from nrp_brain_spinnaker.host.initial_state import GATES, ROWS, state_scale
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.hodgkin_huxley import OPEN
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.synaptic_inputs import read_values
from nrp_brain_spinnaker.models import GSYN, ISYN, CellModel
from nrp_core._support.arrays import FloatArray


def read(cells: Cells, population: int, model: CellModel, variable: str) -> FloatArray:
    """Return a state variable of a population."""
    own = cells.neurons(population)
    if variable in GATES:
        return np.asarray(cells.state[GATES[variable], own] / OPEN)
    if variable not in (*GSYN, *ISYN):
        return from_accum(cells.state[ROWS[variable], own]) / state_scale(model, variable)
    read_values(cells, population)
    raw = cells.value[int(variable.endswith("inh")), own]
    if model.input == kinds.CONDUCTANCE:  # the machine uses and records it without the last ten bits
        return from_accum(raw >> 10)
    return from_accum(raw) / model.weight_scale
