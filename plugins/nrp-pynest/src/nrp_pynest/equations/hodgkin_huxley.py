"""Hodgkin and Huxley's cells of NEST, which spike at the first grid point after the peak of the voltage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from nrp_core.network.equations.cell import CellEquations
from nrp_pynest.equations.model import EquationModel, units_of
from nrp_pynest.equations.receptors import Receptor, alpha_current, every, lines_of

_BEFORE: Final = "dnow/dt = 0.0*mV/ms : mV\ndbefore/dt = 0.0*mV/ms : mV\n"
_CURRENTS: Final = every(alpha_current, ("ex", "in"))
_CONDUCTANCES: Final = {
    receptor: Receptor(f"dg_{name}/dt = -g_{name}/tau_syn_{name} : nS", f"g_{name} += weight")
    for receptor, name in (("excitatory", "ex"), ("inhibitory", "in"))
}
_UNITS: Final = {
    **units_of("C_m", "pF"), **units_of("g_Na g_K g_L", "nS"), **units_of("E_Na E_K E_L", "mV"),
    **units_of("t_ref tau_syn_ex tau_syn_in", "ms"), **units_of("i_offset", "pA"),
}  # fmt: skip


def _cell(
    equations: str, receptors: Mapping[str, Receptor], units: Mapping[str, str], least: str = "0.0*mV"
) -> CellEquations:
    """Return a cell that spikes when its voltage falls for the first time from above a value."""
    return CellEquations(
        equations=lines_of(receptors.values()) + "\n" + equations + _BEFORE,
        threshold=f"v >= {least} and v < before",
        refractory="t_ref",
        receptors={name: one.effect for name, one in receptors.items()},
        units=units,
        on_step="before = now; now = v",
    )


# Hodgkin & Huxley (1952, J Physiol 117:500)
_SQUID: Final = _cell(
    """
I_Na = g_Na*Act_m**3*Inact_h*(v - E_Na) : pA
I_K = g_K*Act_n**4*(v - E_K) : pA
dv/dt = (i_offset + I_syn_ex + I_syn_in - I_Na - I_K - g_L*(v - E_L))/C_m : mV
open_m = 1.0/exprel(-(v + 40.0*mV)/(10.0*mV))/ms : Hz
open_h = 0.07*exp(-(v + 65.0*mV)/(20.0*mV))/ms : Hz
open_n = 0.1/exprel(-(v + 55.0*mV)/(10.0*mV))/ms : Hz
close_m = 4.0*exp(-(v + 65.0*mV)/(18.0*mV))/ms : Hz
close_h = 1.0/(1.0 + exp(-(v + 35.0*mV)/(10.0*mV)))/ms : Hz
close_n = 0.125*exp(-(v + 65.0*mV)/(80.0*mV))/ms : Hz
dAct_m/dt = open_m*(1.0 - Act_m) - close_m*Act_m : 1
dInact_h/dt = open_h*(1.0 - Inact_h) - close_h*Inact_h : 1
dAct_n/dt = open_n*(1.0 - Act_n) - close_n*Act_n : 1
""",
    _CURRENTS,
    _UNITS,
)
# Traub & Miles (1991, Neuronal Networks of the Hippocampus), with the values of Brette et al. (2007, J Comput
# Neurosci 23:349)
_TRAUB: Final = _cell(
    """
I_Na = g_Na*Act_m**3*Inact_h*(v - E_Na) : pA
I_K = g_K*Act_n**4*(v - E_K) : pA
I_syn = g_ex*(v - E_ex) + g_in*(v - E_in) : pA
dv/dt = (i_offset - I_syn - I_Na - I_K - g_L*(v - E_L))/C_m : mV
u = (v - V_T)/mV : 1
open_n = 0.16/exprel((15.0 - u)/5.0)/ms : Hz
close_n = 0.5*exp((10.0 - u)/40.0)/ms : Hz
open_m = 1.28/exprel((13.0 - u)/4.0)/ms : Hz
close_m = 1.4/exprel((u - 40.0)/5.0)/ms : Hz
open_h = 0.128*exp((17.0 - u)/18.0)/ms : Hz
close_h = 4.0/(1.0 + exp((40.0 - u)/5.0))/ms : Hz
dAct_m/dt = open_m*(1.0 - Act_m) - close_m*Act_m : 1
dInact_h/dt = open_h*(1.0 - Inact_h) - close_h*Inact_h : 1
dAct_n/dt = open_n*(1.0 - Act_n) - close_n*Act_n : 1
""",
    _CONDUCTANCES,
    _UNITS | units_of("V_T E_ex E_in", "mV"),
    "V_T + 30.0*mV",
)
# Mancilla et al. (2007, J Neurosci 27:2058); its gap junctions are those of the network.
_BASKET: Final = _cell(
    """
I_Na = g_Na*Act_m**3*Act_h*(v - E_Na) : pA
I_K = (g_Kv1*Inact_n**4 + g_Kv3*Inact_p**2)*(v - E_K) : pA
dv/dt = (i_offset + I_syn_ex + I_syn_in - I_Na - I_K - g_L*(v - E_L))/C_m : mV
u = v/mV : 1
open_m = 540.0/exprel(-(u - 75.5)/13.5)/ms : Hz
close_m = 1.2262*exp(-u/42.248)/ms : Hz
open_h = 0.0035*exp(-u/24.186)/ms : Hz
close_h = 0.0884/exprel(-(51.25 + u)/5.2)/ms : Hz
open_p = 11.8/exprel(-(u - 95.0)/11.8)/ms : Hz
close_p = 0.025*exp(-u/22.222)/ms : Hz
open_n = 0.0322/exprel(-(u + 44.0)/2.3)/ms : Hz
close_n = 0.0043*exp(-(u + 44.0)/34.0)/ms : Hz
dAct_m/dt = open_m*(1.0 - Act_m) - close_m*Act_m : 1
dAct_h/dt = open_h*(1.0 - Act_h) - close_h*Act_h : 1
dInact_p/dt = open_p*(1.0 - Inact_p) - close_p*Inact_p : 1
dInact_n/dt = open_n*(1.0 - Inact_n) - close_n*Inact_n : 1
""",
    _CURRENTS,
    {name: unit for name, unit in _UNITS.items() if name != "g_K"} | units_of("g_Kv1 g_Kv3", "nS"),
)


def _model(
    cell: CellEquations, defaults: Mapping[str, Any], start_mv: float, gates: Mapping[str, float], *more: str
) -> EquationModel:
    initial = {"V_m": start_mv, **gates}
    return EquationModel(lambda _lengths: cell, defaults, initial, ("V_m", *gates, *more))


def _share(opens: Any, closes: Any) -> float:
    return float(opens / (opens + closes))


def _basket_gates(u: float) -> dict[str, float]:
    """Return the equilibrium of the gates of ``hh_psc_alpha_gap`` at a voltage, mV."""
    exp = np.exp
    return {
        "Act_m": _share(40.0 * (u - 75.5) / (1.0 - exp(-(u - 75.5) / 13.5)), 1.2262 * exp(-u / 42.248)),
        "Act_h": _share(0.0035 * exp(-u / 24.186), 0.017 * (51.25 + u) / (1.0 - exp(-(51.25 + u) / 5.2))),
        "Inact_p": _share((u - 95.0) / (1.0 - exp(-(u - 95.0) / 11.8)), 0.025 * exp(-u / 22.222)),
        "Inact_n": _share(
            0.014 * (u + 44.0) / (1.0 - exp(-(u + 44.0) / 2.3)), 0.0043 * exp(-(u + 44.0) / 34.0)
        ),
    }


_ALPHA: Final = {"t_ref": 2.0, "tau_syn_ex": 0.2, "tau_syn_in": 2.0, "I_e": 0.0}
HODGKIN_HUXLEY: Final[Mapping[str, EquationModel]] = {
    "hh_psc_alpha": _model(
        _SQUID,
        {**_ALPHA, "C_m": 100.0, "g_Na": 12000.0, "g_K": 3600.0, "g_L": 30.0, "E_Na": 50.0, "E_K": -77.0,
         "E_L": -54.402},
        -65.0,
        {"Act_m": 0.05293248525724958, "Inact_h": 0.5961207535084603, "Act_n": 0.3176769140606974},
        "I_syn_ex", "I_syn_in",
    ),
    "hh_psc_alpha_gap": _model(
        _BASKET,
        {"C_m": 40.0, "g_Na": 4500.0, "g_Kv1": 9.0, "g_Kv3": 9000.0, "g_L": 10.0, "E_Na": 74.0, "E_K": -90.0,
         "E_L": -70.0, **_ALPHA},
        -69.60401191631222,
        _basket_gates(-69.60401191631222),
        "I_syn_ex", "I_syn_in",
    ),
    "hh_cond_exp_traub": _model(
        _TRAUB,
        {"C_m": 200.0, "g_Na": 20000.0, "g_K": 6000.0, "g_L": 10.0, "E_Na": 50.0, "E_K": -90.0, "E_L": -60.0,
         "V_T": -63.0, "E_ex": 0.0, "E_in": -80.0, "t_ref": 2.0, "tau_syn_ex": 5.0, "tau_syn_in": 10.0,
         "I_e": 0.0},
        -60.0,
        # NEST starts from rates at the absolute voltage, not at that relative to V_T.
        {"Act_m": 9.895563096746586e-09, "Inact_h": 0.999999999106396, "Act_n": 2.551577051602551e-07},
        "g_ex", "g_in",
    ),
}  # fmt: skip
"""The models by NEST's names."""
