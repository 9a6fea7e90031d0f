"""Leaky integrate-and-fire cells with a fixed threshold."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import (
    CONDUCTANCES,
    CURRENT_INPUT,
    CURRENTS,
    CellType,
    reversal_potentials,
    synaptic_times,
)
from nrp_core.brain.network.parameters import NOT_NEGATIVE, NUMBER, POSITIVE, Parameter

_MEMBRANE: Final = {
    "v_rest": Parameter(-65.0, "mV"),
    "cm": Parameter(1.0, "nF", POSITIVE),
    "tau_m": Parameter(20.0, "ms", POSITIVE),
    "tau_refrac": Parameter(0.1, "ms", NOT_NEGATIVE),
    "v_reset": Parameter(-65.0, "mV"),
    "v_thresh": Parameter(-50.0, "mV", NUMBER),
    **CURRENT_INPUT,
}
_VOLTAGE: Final = {"v": Parameter(-65.0, "mV")}

CURR_EXP: Final = CellType(
    "IF_curr_exp",
    "Leaky integrate-and-fire with exponentially decaying synaptic currents.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0)},
    {**_VOLTAGE, **CURRENTS},
    weight_unit="nA",
)
CURR_ALPHA: Final = CellType(
    "IF_curr_alpha",
    "Leaky integrate-and-fire with alpha-shaped synaptic currents, which peak at the weight.",
    {**_MEMBRANE, **synaptic_times(0.5, 0.5)},
    {**_VOLTAGE, **CURRENTS},
    weight_unit="nA",
)
CURR_DELTA: Final = CellType(
    "IF_curr_delta",
    "Leaky integrate-and-fire whose voltage jumps by the weight.",
    _MEMBRANE,
    _VOLTAGE,
    weight_unit="mV",
)
CURR_EXP_FROZEN: Final = CellType(
    "IF_curr_exp_frozen",
    "Leaky integrate-and-fire whose exponential synaptic input is reset by a spike and, like the voltage, "
    "frozen in the refractory period, when arriving spikes are lost (Shiu et al. 2024, Nature 634:210); a "
    "weight is the voltage to which its input would lead if it stayed.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0)},
    _VOLTAGE,
    weight_unit="mV",
)
COND_EXP: Final = CellType(
    "IF_cond_exp",
    "Leaky integrate-and-fire with exponentially decaying synaptic conductances.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0), **reversal_potentials(-70.0)},
    {**_VOLTAGE, **CONDUCTANCES},
    weight_unit="uS",
    stands_for=("IF_facets_hardware1",),
)
COND_ALPHA: Final = CellType(
    "IF_cond_alpha",
    "Leaky integrate-and-fire with alpha-shaped synaptic conductances, which peak at the weight.",
    {**_MEMBRANE, **synaptic_times(0.3, 0.5), **reversal_potentials(-70.0)},
    {**_VOLTAGE, **CONDUCTANCES},
    weight_unit="uS",
)
