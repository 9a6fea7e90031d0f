"""PyNN's standard cells as NEST's models: names, and factors from PyNN's units to NEST's.

PyNN uses nF, nA and uS, NEST uses pF, pA and nS.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

MILLI: Final = 1000.0
"""Factor from PyNN's units to NEST's: pF in nF, pA in nA, nS in uS."""

CURRENT_CELL: Final = "NestCell"
"""The cell type of neurons of a native script, about whose model nothing else is known."""
CONDUCTANCE_CELL: Final = "Nest_cond_cell"
"""Likewise, if weights onto some of the neurons are conductances."""

Names = Mapping[str, tuple[str, float]]
Drive = Literal["current", "conductance", "jump"]

_INTEGRATE_AND_FIRE: Final[Names] = {
    "v_rest": ("E_L", 1.0),
    "v_reset": ("V_reset", 1.0),
    "v_thresh": ("V_th", 1.0),
    "tau_refrac": ("t_ref", 1.0),
    "cm": ("C_m", MILLI),
    "i_offset": ("I_e", MILLI),
}
_TIME_CONSTANTS: Final[Names] = {"tau_syn_E": ("tau_syn_ex", 1.0), "tau_syn_I": ("tau_syn_in", 1.0)}
_REVERSALS: Final[Names] = {"e_rev_E": ("E_ex", 1.0), "e_rev_I": ("E_in", 1.0)}
_MEMBRANE: Final[Names] = {"tau_m": ("tau_m", 1.0)}
_LEAK_FROM_TAU: Final[Names] = {"tau_m": ("g_L", 1.0)}
"""A membrane given by its leak: ``g_L = C_m / tau_m``, see :func:`nrp_brain_nest.cells.nest_parameters`."""
_ADAPTATION: Final[Names] = {
    "v_spike": ("V_peak", 1.0),
    "a": ("a", 1.0),  # nS in both
    "b": ("b", MILLI),
    "delta_T": ("Delta_T", 1.0),
    "tau_w": ("tau_w", 1.0),
}
_IZHIKEVICH: Final[Names] = {
    "a": ("a", 1.0),
    "b": ("b", 1.0),
    "c": ("c", 1.0),
    "d": ("d", 1.0),
    "i_offset": ("I_e", MILLI),  # PyNN's convention: 1 nA is 1000 of the model's own unit
}
_HODGKIN_HUXLEY: Final[Names] = {
    "gbar_Na": ("g_Na", MILLI),
    "gbar_K": ("g_K", MILLI),
    "g_leak": ("g_L", MILLI),
    "cm": ("C_m", MILLI),
    "v_offset": ("V_T", 1.0),
    "e_rev_Na": ("E_Na", 1.0),
    "e_rev_K": ("E_K", 1.0),
    "e_rev_leak": ("E_L", 1.0),
    "i_offset": ("I_e", MILLI),
}

_VOLTAGE: Final[Names] = {"v": ("V_m", 1.0)}
_CONDUCTANCES: Final[Names] = {"gsyn_exc": ("g_ex", MILLI), "gsyn_inh": ("g_in", MILLI)}
_GATES: Final[Names] = {"m": ("Act_m", 1.0), "h": ("Inact_h", 1.0), "n": ("Act_n", 1.0)}


@dataclass(frozen=True)
class CellType:
    """NEST's model of one of PyNN's standard cells.

    Args:
        model: NEST's name.
        drive: the effect of a synapse: a current, a conductance, or a jump of the voltage.
        parameters: NEST's name and the factor to its unit, by PyNN's name.
        state: the same for the state variables.
        initial: PyNN's initial values.
        fixed: NEST's parameters that PyNN's cells do not have.
    """

    model: str
    drive: Drive
    parameters: Names
    state: Names = field(default_factory=lambda: _VOLTAGE)
    initial: Mapping[str, float] = field(default_factory=lambda: {"v": -65.0})
    fixed: Mapping[str, float] = field(default_factory=dict)

    @property
    def readable(self) -> frozenset[str]:
        """PyNN's names of the state variables that can be read while running."""
        return frozenset(self.state)


def _adaptive(model: str) -> CellType:
    parameters = {**_INTEGRATE_AND_FIRE, **_LEAK_FROM_TAU, **_TIME_CONSTANTS, **_REVERSALS, **_ADAPTATION}
    state = {**_VOLTAGE, **_CONDUCTANCES, "w": ("w", MILLI)}
    return CellType(model, "conductance", parameters, state, {"v": -70.6, "w": 0.0}, {"gsl_error_tol": 1e-9})


def _conductance(model: str) -> CellType:
    parameters = {**_INTEGRATE_AND_FIRE, **_LEAK_FROM_TAU, **_TIME_CONSTANTS, **_REVERSALS}
    return CellType(model, "conductance", parameters, {**_VOLTAGE, **_CONDUCTANCES})


def _current(model: str) -> CellType:
    return CellType(model, "current", {**_INTEGRATE_AND_FIRE, **_MEMBRANE, **_TIME_CONSTANTS})


CELL_TYPES: Final[Mapping[str, CellType]] = {
    "IF_curr_exp": _current("iaf_psc_exp"),
    "IF_curr_alpha": _current("iaf_psc_alpha"),
    "IF_curr_delta": CellType("iaf_psc_delta", "jump", {**_INTEGRATE_AND_FIRE, **_MEMBRANE}),
    "IF_cond_exp": _conductance("iaf_cond_exp"),
    "IF_cond_alpha": _conductance("iaf_cond_alpha"),
    "EIF_cond_exp_isfa_ista": _adaptive("aeif_cond_exp"),
    "EIF_cond_alpha_isfa_ista": _adaptive("aeif_cond_alpha"),
    "Izhikevich": CellType(
        "izhikevich", "jump", _IZHIKEVICH, {**_VOLTAGE, "u": ("U_m", 1.0)}, {"v": -70.0, "u": -14.0}
    ),
    "HH_cond_exp": CellType(
        "hh_cond_exp_traub", "conductance",
        {**_HODGKIN_HUXLEY, **_TIME_CONSTANTS, **_REVERSALS},
        {**_VOLTAGE, **_GATES},
    ),
}  # fmt: skip

APPROXIMATE: Final = frozenset({"Izhikevich", "HH_cond_exp"})
"""Cells that NEST integrates by Euler steps, and whose spikes it reports at the peak of the voltage."""
