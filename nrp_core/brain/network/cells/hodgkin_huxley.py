"""Hodgkin-Huxley cells after Traub & Miles (1991, Neuronal Networks of the Hippocampus)."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import (
    CONDUCTANCES,
    CURRENT_INPUT,
    CellType,
    reversal_potentials,
    synaptic_times,
)
from nrp_core.brain.network.parameters import FRACTION, NOT_NEGATIVE, POSITIVE, Parameter

COND_EXP: Final = CellType(
    "HH_cond_exp",
    "A Hodgkin-Huxley cell of one compartment with exponentially decaying synaptic conductances.",
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
