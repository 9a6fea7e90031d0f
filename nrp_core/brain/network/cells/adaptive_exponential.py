"""Adaptive exponential integrate-and-fire cells (Brette & Gerstner 2005, J Neurophysiol 94:3637)."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import (
    CONDUCTANCES,
    CURRENT_INPUT,
    CellType,
    reversal_potentials,
    synaptic_times,
)
from nrp_core.brain.network.parameters import NOT_NEGATIVE, NUMBER, POSITIVE, Parameter

_PARAMETERS: Final = {
    "cm": Parameter(0.281, "nF", POSITIVE),
    "tau_refrac": Parameter(0.1, "ms", NOT_NEGATIVE),
    "v_spike": Parameter(-40.0, "mV", NUMBER),
    "v_reset": Parameter(-70.6, "mV"),
    "v_rest": Parameter(-70.6, "mV"),
    "tau_m": Parameter(9.3667, "ms", POSITIVE),
    **CURRENT_INPUT,
    "a": Parameter(4.0, "nS"),
    "b": Parameter(0.0805, "nA"),
    "delta_T": Parameter(2.0, "mV", NOT_NEGATIVE),
    "tau_w": Parameter(144.0, "ms", POSITIVE),
    "v_thresh": Parameter(-50.4, "mV", NUMBER),
    **synaptic_times(5.0, 5.0),
    **reversal_potentials(-80.0),
}
_STATE: Final = {"v": Parameter(-70.6, "mV"), "w": Parameter(0.0, "nA"), **CONDUCTANCES}

COND_EXP: Final = CellType(
    "EIF_cond_exp_isfa_ista",
    "Adaptive exponential integrate-and-fire with exponentially decaying synaptic conductances.",
    _PARAMETERS,
    _STATE,
    weight_unit="uS",
)
COND_ALPHA: Final = CellType(
    "EIF_cond_alpha_isfa_ista",
    "Adaptive exponential integrate-and-fire with alpha-shaped synaptic conductances.",
    _PARAMETERS,
    _STATE,
    weight_unit="uS",
)
