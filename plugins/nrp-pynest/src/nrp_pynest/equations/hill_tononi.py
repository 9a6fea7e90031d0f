"""The model of Hill & Tononi (2005, J Neurophysiol 93:1671): intrinsic currents of the thalamus and cortex.

Conductances are relative to the leak, so a current is a voltage; an injected current of 1 pA is one of 1 mV.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from nrp_core.network.equations.cell import CellEquations
from nrp_pynest.equations.model import EquationModel, Lengths, Values, unit_peak, units_of

_RECEPTORS: Final = ("AMPA", "NMDA", "GABA_A", "GABA_B")
"""In the order of their numbers, from 1."""
_CONDUCTANCES: Final = "\n".join(
    f"dg_{name}/dt = peak_{name}*y_{name} - g_{name}/tau_decay_{name} : 1\n"
    f"dy_{name}/dt = -y_{name}/tau_rise_{name} : 1"
    for name in _RECEPTORS
)
# The magnesium block of NMDA closes at once and opens slowly; the intrinsic currents of NEST's ht_neuron.
_MEMBRANE: Final = """
open_NMDA = 1.0/(1.0 + exp(-S_act_NMDA*(v - V_act_NMDA)/mV)) : 1
share = 0.51 - 0.0028*v/mV : 1
slowly_open = share*min(m_fast, open_NMDA) + (1.0 - share)*min(m_slow, open_NMDA) : 1
opened = instant_unblock_NMDA*open_NMDA + (1.0 - instant_unblock_NMDA)*slowly_open : 1
dm_fast/dt = (open_NMDA - min(m_fast, open_NMDA))/tau_Mg_fast_NMDA : 1
dm_slow/dt = (open_NMDA - min(m_slow, open_NMDA))/tau_Mg_slow_NMDA : 1
I_gaba = g_GABA_A*(E_rev_GABA_A - v) + g_GABA_B*(E_rev_GABA_B - v) : mV
I_syn = g_AMPA*(E_rev_AMPA - v) + g_NMDA*opened*(E_rev_NMDA - v) + I_gaba : mV
I_NaP = g_peak_NaP*(1.0 + exp(-(v + 55.7*mV)/(7.7*mV)))**-N_NaP*(E_rev_NaP - v) : mV (recorded)
I_KNa = g_peak_KNa/(1.0 + (0.25/D)**3.5)*(E_rev_KNa - v) : mV (recorded)
I_T = g_peak_T*m_T**N_T*h_T*(E_rev_T - v) : mV (recorded)
I_h = g_peak_h*m_h*(E_rev_h - v) : mV (recorded)
I_leak = g_NaL*(E_Na - v) + g_KL*(E_K - v) : mV
I_spike = ceil(clip(left/ms - 0.001, 0.0, 1.0))*(E_K - v)/tau_spike : V/s
dv/dt = (I_leak + I_syn + I_NaP + I_KNa + I_T + I_h + i_offset/pA*mV)/tau_m + I_spike : mV
dtheta/dt = (theta_eq - theta)/tau_theta : mV
dleft/dt = -1.0 : ms
dD/dt = (tau_D_KNa/ms*0.025/(1.0 + exp(-(v + 10.0*mV)/(5.0*mV))) + 0.001 - D)/tau_D_KNa : 1
tau_m_T = (0.22/(exp(-(v + 132.0*mV)/(16.7*mV)) + exp((v + 16.8*mV)/(18.2*mV))) + 0.13)*ms : ms
dm_T/dt = (1.0/(1.0 + exp(-(v + 59.0*mV)/(6.2*mV))) - m_T)/tau_m_T : 1
opening_T = (56.6 + 0.27*exp((v + 115.2*mV)/(5.0*mV)))/(1.0 + exp((v + 86.0*mV)/(3.2*mV))) : 1
dh_T/dt = (1.0/(1.0 + exp((v + 83.0*mV)/(4.0*mV))) - h_T)/((8.2 + opening_T)*ms) : 1
rate_h = (exp(-14.59 - 0.086*v/mV) + exp(-1.87 + 0.0701*v/mV))/ms : Hz
dm_h/dt = (1.0/(1.0 + exp((v + 75.0*mV)/(5.5*mV))) - m_h)*rate_h : 1
"""
_DEFAULTS: Final[Mapping[str, Any]] = {
    "E_Na": 30.0, "E_K": -90.0, "g_NaL": 0.2, "g_KL": 1.0, "tau_m": 16.0, "theta_eq": -51.0, "tau_theta": 2.0,
    "tau_spike": 1.75, "t_ref": 2.0, "g_peak_AMPA": 0.1, "tau_rise_AMPA": 0.5, "tau_decay_AMPA": 2.4,
    "E_rev_AMPA": 0.0, "g_peak_NMDA": 0.075, "tau_rise_NMDA": 4.0, "tau_decay_NMDA": 40.0, "E_rev_NMDA": 0.0,
    "V_act_NMDA": -25.57, "S_act_NMDA": 0.081, "tau_Mg_slow_NMDA": 22.7, "tau_Mg_fast_NMDA": 0.68,
    "instant_unblock_NMDA": False, "g_peak_GABA_A": 0.33, "tau_rise_GABA_A": 1.0, "tau_decay_GABA_A": 7.0,
    "E_rev_GABA_A": -70.0, "g_peak_GABA_B": 0.0132, "tau_rise_GABA_B": 60.0, "tau_decay_GABA_B": 200.0,
    "E_rev_GABA_B": -90.0, "g_peak_NaP": 1.0, "E_rev_NaP": 30.0, "N_NaP": 3.0, "g_peak_KNa": 1.0,
    "E_rev_KNa": -90.0, "tau_D_KNa": 1250.0, "g_peak_T": 1.0, "E_rev_T": 0.0, "N_T": 2.0, "g_peak_h": 1.0,
    "E_rev_h": -40.0, "I_e": 0.0,
}  # fmt: skip
_OWN: Final = {f"g_peak_{name}" for name in _RECEPTORS}
"""Parameters that only decide on the effects of spikes."""


def _unit(name: str) -> str:
    if name.startswith(("E_", "V_", "theta")):
        return "mV"
    return "ms" if name.startswith("t") else "pA" if name == "I_e" else "1"


def _cell_of(_lengths: Lengths) -> CellEquations:
    units = {
        "i_offset" if name == "I_e" else name: _unit(name) for name in _DEFAULTS if name not in _OWN
    } | units_of(" ".join(f"peak_{name}" for name in _RECEPTORS), "1/ms")
    return CellEquations(
        equations=_CONDUCTANCES + _MEMBRANE,
        threshold="v >= theta and left < 0.001*ms",
        reset="v = E_Na; theta = E_Na; left = t_ref",
        refractory="t_ref",
        receptors={f"receptor{k}": f"y_{name} += weight" for k, name in enumerate(_RECEPTORS, 1)},
        units=units,
        on_step="m_fast = min(m_fast, open_NMDA); m_slow = min(m_slow, open_NMDA)",
    )


def _peaks(values: Values) -> Values:
    """Return the rate (1/ms) by which a spike of weight 1 raises each conductance to its peak."""
    return {
        f"peak_{name}": values[f"g_peak_{name}"]
        * unit_peak(values[f"tau_decay_{name}"], values[f"tau_rise_{name}"])
        for name in _RECEPTORS
    }


def _at_rest() -> dict[str, float]:
    """Return the state at time 0: the leak's equilibrium, with the default parameters."""
    volts = (0.2 * 30.0 + 1.0 * -90.0) / 1.2
    blocked = 1.0 / (1.0 + np.exp(-0.081 * (volts + 25.57)))
    return {
        "V_m": volts, "theta": -51.0, "m_fast": blocked, "m_slow": blocked,
        "D": 1250.0 * 0.025 / (1.0 + np.exp(-(volts + 10.0) / 5.0)) + 0.001,
        "m_T": 1.0 / (1.0 + np.exp(-(volts + 59.0) / 6.2)), "h_T": 1.0 / (1.0 + np.exp((volts + 83.0) / 4.0)),
        "m_h": 1.0 / (1.0 + np.exp((volts + 75.0) / 5.5)),
    }  # fmt: skip


_RECORDABLES: Final = ("V_m", "theta", "I_NaP", "I_KNa", "I_T", "I_h", "g_AMPA", "g_GABA_A", "g_GABA_B")
HILL_TONONI: Final[Mapping[str, EquationModel]] = {
    "ht_neuron": EquationModel(
        _cell_of, _DEFAULTS, _at_rest(), _RECORDABLES, n_ports=len(_RECEPTORS), derive=_peaks
    )
}
"""The model by NEST's name."""
