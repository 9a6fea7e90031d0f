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
from nrp_core._support.arrays import FloatArray, IntArray


def read(cells: Cells, ring: Ring, tick: int, population: int, model: CellModel, variable: str) -> FloatArray:
    """Return a state variable of a population at the beginning of a tick."""
    own = cells.neurons(population)
    if variable in GATES:
        return np.asarray(cells.state[GATES[variable], own] / OPEN)
    if variable not in (*GSYN, *ISYN):
        return from_accum(cells.state[ROWS[variable], own]) / state_scale(model, variable)
    values = _with_input(cells, ring, tick, population)
    raw = values[int(variable.endswith("inh"))]
    if model.input == kinds.CONDUCTANCE:  # the machine uses and records it without the last ten bits
        return from_accum(raw >> 10)
    return from_accum(raw) / model.weight_scale


def _with_input(cells: Cells, ring: Ring, tick: int, population: int) -> IntArray:
    """Return the synaptic values that a machine records, with the input of the tick, shape ``(2, n)``."""
    own, n = cells.neurons(population), cells.ids.size
    size = own.stop - own.start
    parts = cells.populations[[population]]
    parts[0, [kinds.FIRST, kinds.LAST]] = 0, size
    apart = cells._replace(
        populations=parts, synapse_constants=cells.synapse_constants[..., own].copy(),
        synapse_state=cells.synapse_state[..., own].copy(), ids=cells.ids[own].copy(),
        arrived=np.zeros((2, size), np.int64), value=np.empty((2, size), np.int64),
    )  # fmt: skip
    lines = [slice(first + own.start, first + own.stop) for first in (0, n)]
    now = ring.slots[tick & (ring.slots.shape[0] - 1)]
    waiting = (np.concatenate([line[each] for each in lines]) for line in (now, ring.device, ring.saturated))
    slots, device, saturated = waiting
    transfer(apart, Ring(slots[None], device, saturated), 0, 0)
    add_arrived(apart, 0)
    read_values(apart, 0)
    return apart.value
