"""The initial state of neurons."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.host.constants import resting_gates
from nrp_brain_spinnaker.host.conversion import to_accum
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.hodgkin_huxley import FINE_BITS, OPEN
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.models import CONDUCTANCE_SCALE, GSYN, ISYN, CellModel
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Population
from nrp_core.errors import NetworkError, did_you_mean

GATES = {"m": kinds.GATE_M, "h": kinds.GATE_H, "n": kinds.GATE_N}
ROWS = {"v": kinds.V, "u": kinds.U, "w": kinds.W, **GATES}
"""The row of each variable of a membrane."""


def load_state(cells: Cells, own: slice, population: Population, model: CellModel, step: int) -> None:
    """Set the initial values of a population; by default gates are at their steady state for the voltage.

    Raises:
        NetworkError: a value does not fit the machine's numbers or the cells have no such variable.
    """
    if model.neuron == kinds.IZHIKEVICH:
        cells.state[kinds.H, own] = step
    for name, values in population.initial_values.items():
        if name not in model.state_variables:
            hint = did_you_mean(name, model.state_variables)
            raise NetworkError(
                f"population '{population.label}' ({population.cell_type}) has no '{name}'{hint}"
            )
        _set(cells, own, model, name, values, population.label)
    if model.neuron == kinds.HODGKIN_HUXLEY:
        cells.state[kinds.V_FINE, own] = cells.state[kinds.V, own] << FINE_BITS
        _rest_gates(cells, own, [name for name in GATES if name not in population.initial_values])


def _set(cells: Cells, own: slice, model: CellModel, name: str, values: FloatArray, label: str) -> None:
    if name in GATES:
        cells.state[GATES[name], own] = np.rint(values * OPEN)
        return
    scale = state_scale(model, name)
    try:
        raw = to_accum(values * scale, f"initial value '{name}'")
    except ValueError as error:
        raise NetworkError(f"population '{label}': {error}") from None
    if name in (*GSYN, *ISYN):
        cells.synapse_state[int(name.endswith("inh")), kinds.VALUE, own] = raw
    else:
        cells.state[ROWS[name], own] = raw


def state_scale(model: CellModel, name: str) -> int:
    """Return the factor with which a variable is stored."""
    if name in (*GSYN, *ISYN):
        return model.weight_scale
    return CONDUCTANCE_SCALE if name == "w" else 1


def _rest_gates(cells: Cells, own: slice, names: list[str]) -> None:
    above = cells.state[kinds.V, own] - cells.constants[kinds.V_OFFSET, own]
    for voltage in np.unique(above).tolist():
        gates = dict(zip(GATES, resting_gates(voltage), strict=True))
        neurons = np.flatnonzero(above == voltage) + own.start
        for name in names:
            cells.state[GATES[name], neurons] = gates[name]
