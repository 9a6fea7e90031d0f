"""NEST's models of cells that have no standard cell of PyNN: as equations, with NEST's names and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.network.equations.cell import CellEquations


@dataclass(frozen=True)
class EquationModel:
    """A model as equations.

    Args:
        cell: the equations; an injected current is the parameter ``i_offset``, which is NEST's ``I_e``.
        defaults: the defaults of NEST's parameters.
        initial: the state at time 0, as far as it is not 0.
        recordables: the variables that a multimeter can record.
    """

    cell: CellEquations
    defaults: Mapping[str, float]
    initial: Mapping[str, float] = field(default_factory=dict)
    recordables: tuple[str, ...] = ()

    @property
    def parameters(self) -> dict[str, str]:
        """NEST's names of the parameters, by their names in the equations."""
        return {name: "I_e" if name == "i_offset" else name for name in self.cell.units}


# The alpha-shaped current of a spike peaks at its weight after the time constant.
_ALPHA: Final = """
dI_syn_ex/dt = (exp(1.0)*y_ex - I_syn_ex)/tau_syn_ex : pA
dy_ex/dt = -y_ex/tau_syn_ex : pA
dI_syn_in/dt = (exp(1.0)*y_in - I_syn_in)/tau_syn_in : pA
dy_in/dt = -y_in/tau_syn_in : pA
"""
_HODGKIN_HUXLEY_UNITS: Final = {
    "C_m": "pF", "g_Na": "nS", "g_K": "nS", "g_L": "nS", "E_Na": "mV", "E_K": "mV", "E_L": "mV",
    "t_ref": "ms", "tau_syn_ex": "ms", "tau_syn_in": "ms", "i_offset": "pA",
}  # fmt: skip
# Hodgkin & Huxley (1952, J Physiol 117:500); a spike is at the first grid point after the peak.
_HH_PSC_ALPHA: Final = EquationModel(
    CellEquations(
        equations=_ALPHA
        + """
I_Na = g_Na*Act_m**3*Inact_h*(V_m - E_Na) : pA
I_K = g_K*Act_n**4*(V_m - E_K) : pA
dV_m/dt = (i_offset + I_syn_ex + I_syn_in - I_Na - I_K - g_L*(V_m - E_L))/C_m : mV
open_m = 1.0/exprel(-(V_m + 40.0*mV)/(10.0*mV))/ms : Hz
open_h = 0.07*exp(-(V_m + 65.0*mV)/(20.0*mV))/ms : Hz
open_n = 0.1/exprel(-(V_m + 55.0*mV)/(10.0*mV))/ms : Hz
close_m = 4.0*exp(-(V_m + 65.0*mV)/(18.0*mV))/ms : Hz
close_h = 1.0/(1.0 + exp(-(V_m + 35.0*mV)/(10.0*mV)))/ms : Hz
close_n = 0.125*exp(-(V_m + 65.0*mV)/(80.0*mV))/ms : Hz
dAct_m/dt = open_m*(1.0 - Act_m) - close_m*Act_m : 1
dInact_h/dt = open_h*(1.0 - Inact_h) - close_h*Inact_h : 1
dAct_n/dt = open_n*(1.0 - Act_n) - close_n*Act_n : 1
dnow/dt = 0.0*mV/ms : mV
dbefore/dt = 0.0*mV/ms : mV
""",
        threshold="V_m >= 0.0*mV and V_m < before",
        refractory="t_ref",
        receptors={"excitatory": "y_ex += weight", "inhibitory": "y_in += weight"},
        units=_HODGKIN_HUXLEY_UNITS,
        on_step="before = now; now = V_m",
    ),
    {"C_m": 100.0, "g_Na": 12000.0, "g_K": 3600.0, "g_L": 30.0, "E_Na": 50.0, "E_K": -77.0, "E_L": -54.402,
     "t_ref": 2.0, "tau_syn_ex": 0.2, "tau_syn_in": 2.0, "I_e": 0.0},
    {"V_m": -65.0, "now": -65.0, "before": -65.0, "Act_m": 0.05293248525724958,
     "Inact_h": 0.5961207535084603, "Act_n": 0.3176769140606974},
    ("V_m", "Act_m", "Inact_h", "Act_n", "I_syn_ex", "I_syn_in"),
)  # fmt: skip

EQUATIONS: Final[Mapping[str, EquationModel]] = {"hh_psc_alpha": _HH_PSC_ALPHA}
