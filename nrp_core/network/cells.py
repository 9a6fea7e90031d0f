"""Every cell type with its parameters, independent of simulators.

Limits, PyNN's classes, file readers and conformance samples follow the table :data:`CELLS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.network.parameters import (
    FRACTION,
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INFINITE,
    NUMBER,
    POSITIVE,
    RATE,
    Parameter,
)


@dataclass(frozen=True, slots=True)
class CellType:
    """One of PyNN's standard cells.

    Args:
        name: PyNN's name, e.g. ``IF_cond_alpha``.
        summary: one sentence, for documentation.
        parameters: parameters by PyNN name, with PyNN's defaults and units.
        state: state variables with their initial values.
        weight_unit: the weight unit of synapses onto it; empty for sources, which receive none.
        stands_for: unsupported PyNN classes whose nearest equivalent this is.
    """

    name: str
    summary: str
    parameters: Mapping[str, Parameter]
    state: Mapping[str, Parameter] = field(default_factory=dict)
    weight_unit: str = ""
    stands_for: tuple[str, ...] = ()


CONDUCTANCES: Final = {
    "gsyn_exc": Parameter(0.0, "uS", NOT_NEGATIVE),
    "gsyn_inh": Parameter(0.0, "uS", NOT_NEGATIVE),
}
CURRENTS: Final = {"isyn_exc": Parameter(0.0, "nA"), "isyn_inh": Parameter(0.0, "nA")}
CURRENT_INPUT: Final = {"i_offset": Parameter(0.0, "nA")}


def synaptic_times(excitatory: float, inhibitory: float) -> dict[str, Parameter]:
    """Return the time constants of both receptors."""
    return {
        "tau_syn_E": Parameter(excitatory, "ms", POSITIVE),
        "tau_syn_I": Parameter(inhibitory, "ms", POSITIVE),
    }


def reversal_potentials(inhibitory: float) -> dict[str, Parameter]:
    """Return the reversal potentials of both receptors; the excitatory one is 0 mV."""
    return {"e_rev_E": Parameter(0.0, "mV"), "e_rev_I": Parameter(inhibitory, "mV")}


# Leaky integrate-and-fire cells with a fixed threshold.

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

IF_CURR_EXP: Final = CellType(
    "IF_curr_exp",
    "Leaky integrate-and-fire with exponentially decaying synaptic currents.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0)},
    {**_VOLTAGE, **CURRENTS},
    weight_unit="nA",
)
IF_CURR_ALPHA: Final = CellType(
    "IF_curr_alpha",
    "Leaky integrate-and-fire with alpha-shaped synaptic currents, which peak at the weight.",
    {**_MEMBRANE, **synaptic_times(0.5, 0.5)},
    {**_VOLTAGE, **CURRENTS},
    weight_unit="nA",
)
IF_CURR_DELTA: Final = CellType(
    "IF_curr_delta",
    "Leaky integrate-and-fire whose voltage jumps by the weight.",
    _MEMBRANE,
    _VOLTAGE,
    weight_unit="mV",
)
IF_CURR_EXP_FROZEN: Final = CellType(
    "IF_curr_exp_frozen",
    "Leaky integrate-and-fire whose exponential synaptic input is reset by a spike and, like the voltage, "
    "frozen in the refractory period, when arriving spikes are lost (Shiu et al. 2024, Nature 634:210); a "
    "weight is the voltage to which its input would lead if it stayed.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0)},
    _VOLTAGE,
    weight_unit="mV",
)
IF_COND_EXP: Final = CellType(
    "IF_cond_exp",
    "Leaky integrate-and-fire with exponentially decaying synaptic conductances.",
    {**_MEMBRANE, **synaptic_times(5.0, 5.0), **reversal_potentials(-70.0)},
    {**_VOLTAGE, **CONDUCTANCES},
    weight_unit="uS",
    stands_for=("IF_facets_hardware1",),
)
IF_COND_ALPHA: Final = CellType(
    "IF_cond_alpha",
    "Leaky integrate-and-fire with alpha-shaped synaptic conductances, which peak at the weight.",
    {**_MEMBRANE, **synaptic_times(0.3, 0.5), **reversal_potentials(-70.0)},
    {**_VOLTAGE, **CONDUCTANCES},
    weight_unit="uS",
)

# Izhikevich's cell (2003, IEEE Transactions on Neural Networks 14:1569).
#
# PyNN's has a voltage that jumps by weights; those of sPyNNaker have synapses that decay exponentially, and
# an input that enters the equation in nA as it is, so that their ``i_offset`` is 1000 times PyNN's.

PEAK_MV: Final = 30.0
"""The voltage at which the cell spikes."""

_RECOVERY: Final = {
    "a": Parameter(0.02, "/ms"),
    "b": Parameter(0.2, "/ms"),
    "c": Parameter(-65.0, "mV"),
    "d": Parameter(2.0, "mV/ms"),
    **CURRENT_INPUT,
}
_IZK_STATE: Final = {"v": Parameter(-70.0, "mV"), "u": Parameter(-14.0, "mV/ms")}

IZHIKEVICH: Final = CellType(
    "Izhikevich",
    "Izhikevich's quadratic cell with recovery; its voltage jumps by the weight.",
    _RECOVERY,
    _IZK_STATE,
    weight_unit="mV",
)
IZK_CURR_EXP: Final = CellType(
    "IZK_curr_exp",
    "Izhikevich's cell of sPyNNaker, with exponentially decaying synaptic currents.",
    {**_RECOVERY, **synaptic_times(5.0, 5.0)},
    {**_IZK_STATE, **CURRENTS},
    weight_unit="nA",
)
IZK_COND_EXP: Final = CellType(
    "IZK_cond_exp",
    "Izhikevich's cell of sPyNNaker, with exponentially decaying synaptic conductances.",
    {**_RECOVERY, **synaptic_times(5.0, 5.0), **reversal_potentials(-70.0)},
    {**_IZK_STATE, **CONDUCTANCES},
    weight_unit="uS",
)

# Adaptive exponential integrate-and-fire cells (Brette & Gerstner 2005, J Neurophysiol 94:3637).

_EIF_PARAMETERS: Final = {
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
_EIF_STATE: Final = {"v": Parameter(-70.6, "mV"), "w": Parameter(0.0, "nA"), **CONDUCTANCES}

EIF_COND_EXP: Final = CellType(
    "EIF_cond_exp_isfa_ista",
    "Adaptive exponential integrate-and-fire with exponentially decaying synaptic conductances.",
    _EIF_PARAMETERS,
    _EIF_STATE,
    weight_unit="uS",
)
EIF_COND_ALPHA: Final = CellType(
    "EIF_cond_alpha_isfa_ista",
    "Adaptive exponential integrate-and-fire with alpha-shaped synaptic conductances.",
    _EIF_PARAMETERS,
    _EIF_STATE,
    weight_unit="uS",
)

# Hodgkin-Huxley cells after Traub & Miles (1991, Neuronal Networks of the Hippocampus).

HH_COND_EXP: Final = CellType(
    "HH_cond_exp",
    "A Hodgkin-Huxley cell of one compartment with exponentially decaying synaptic conductances; it fires as "
    "its voltage passes -20 mV.",
    {
        "gbar_Na": Parameter(20.0, "uS", NOT_NEGATIVE),
        "gbar_K": Parameter(6.0, "uS", NOT_NEGATIVE),
        "g_leak": Parameter(0.01, "uS", NOT_NEGATIVE),
        "cm": Parameter(0.2, "nF", POSITIVE),
        "v_offset": Parameter(-63.0, "mV"),
        "e_rev_Na": Parameter(50.0, "mV"),
        "e_rev_K": Parameter(-90.0, "mV"),
        "e_rev_leak": Parameter(-65.0, "mV"),
        **reversal_potentials(-80.0),
        **synaptic_times(0.2, 2.0),
        **CURRENT_INPUT,
    },
    {
        "v": Parameter(-65.0, "mV"),
        **CONDUCTANCES,
        "h": Parameter(1.0, limit=FRACTION),
        "m": Parameter(0.0, limit=FRACTION),
        "n": Parameter(0.0, limit=FRACTION),
    },
    weight_unit="uS",
    stands_for=("MultiCompartmentNeuron",),
)

# Cells that only emit spikes.

_WINDOW: Final = {
    "start": Parameter(0.0, "ms", NUMBER),
    "duration": Parameter(1e10, "ms", NOT_NEGATIVE_OR_INFINITE),
}

SOURCE_POISSON: Final = CellType(
    "SpikeSourcePoisson",
    "Independent spikes at a mean rate.",
    {
        "rate": Parameter(1.0, "Hz", RATE),
        **_WINDOW,
    },
    stands_for=("SpikeSourceInhGamma",),
)
SOURCE_REFRACTORY: Final = CellType(
    "SpikeSourcePoissonRefractory",
    "Independent spikes at a mean rate, each followed by a dead time.",
    {"rate": Parameter(1.0, "Hz", RATE), "tau_refrac": Parameter(0.0, "ms", NOT_NEGATIVE), **_WINDOW},
)
SOURCE_GAMMA: Final = CellType(
    "SpikeSourceGamma",
    "Spikes whose intervals have a gamma distribution of shape alpha, with a mean of alpha / beta seconds.",
    {"alpha": Parameter(2.0, "dimensionless", POSITIVE), "beta": Parameter(1.0, "Hz", RATE), **_WINDOW},
)
SOURCE_ARRAY: Final = CellType("SpikeSourceArray", "Spikes at given times, ``spike_times`` (ms).", {})

CELLS: Final[Mapping[str, CellType]] = {
    cell.name: cell
    for cell in (
        IF_CURR_EXP,
        IF_CURR_ALPHA,
        IF_CURR_DELTA,
        IF_CURR_EXP_FROZEN,
        IF_COND_EXP,
        IF_COND_ALPHA,
        IZHIKEVICH,
        IZK_CURR_EXP,
        IZK_COND_EXP,
        EIF_COND_EXP,
        EIF_COND_ALPHA,
        HH_COND_EXP,
        SOURCE_POISSON,
        SOURCE_REFRACTORY,
        SOURCE_GAMMA,
        SOURCE_ARRAY,
    )
}


def settled_gates(v_mv: FloatArray) -> dict[str, FloatArray]:
    """Return the steady states of the gates m, h and n of a Hodgkin-Huxley cell, by PyNN name.

    Args:
        v_mv: voltages above the model's offset, shape ``(n,)``.
    """
    rates = {
        "m": (0.32 * _over_exponential(13.0 - v_mv, 4.0), 0.28 * _over_exponential(v_mv - 40.0, 5.0)),
        "h": (0.128 * np.exp((17.0 - v_mv) / 18.0), 4.0 / (np.exp((40.0 - v_mv) / 5.0) + 1.0)),
        "n": (0.032 * _over_exponential(15.0 - v_mv, 5.0), 0.5 * np.exp((10.0 - v_mv) / 40.0)),
    }
    return {gate: opening / (opening + closing) for gate, (opening, closing) in rates.items()}


def _over_exponential(x: FloatArray, scale: float) -> FloatArray:
    """Return ``x / (exp(x / scale) - 1)`` and its limit at 0."""
    safe = np.where(x == 0.0, 1.0, x)
    return np.where(x == 0.0, scale, safe / np.expm1(safe / scale))
