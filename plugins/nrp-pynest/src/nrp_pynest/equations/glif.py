"""The generalised leaky integrate-and-fire models of the Allen Institute.

Teeter et al. (2018, Nat Commun 9:709). A refractory cell keeps its voltage, threshold and after-spike
currents.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from nrp_core.network.equations.cell import CellEquations
from nrp_pynest.equations.model import EquationModel, Lengths, Values, numbered, summed, units_of
from nrp_pynest.equations.receptors import (
    Receptor,
    alpha_current,
    every,
    lines_of,
    spread_arrived,
    two_alpha_currents,
)

_MEMBRANE: Final = """
threshold = V_th + threshold_spike + threshold_voltage : mV (recorded)
I = i_offset : pA (recorded)
dv/dt = (i_offset + ASCurrents_sum + I_syn - g*(v - E_L))/C_m : mV (unless refractory)
dthreshold_spike/dt = -th_spike_decay*threshold_spike : mV (unless refractory)
voltage_effect = adapting_threshold*th_voltage_index*(v - E_L) : V/s
dthreshold_voltage/dt = voltage_effect - th_voltage_decay*threshold_voltage : mV (unless refractory)
dnow/dt = 0.0*mV/ms : mV
dbefore/dt = 0.0*mV/ms : mV
"""
_UNITS: Final = {
    **units_of("C_m", "pF"), **units_of("g", "nS"), **units_of("t_ref", "ms"), **units_of("i_offset", "pA"),
    **units_of("E_L V_th V_reset voltage_reset_add th_spike_add", "mV"),
    **units_of("voltage_reset_fraction spike_dependent_threshold after_spike_currents", "1"),
    **units_of("adapting_threshold", "1"),
    **units_of("th_spike_decay th_voltage_index th_voltage_decay", "1/ms"),
}  # fmt: skip
_DEFAULTS: Final[Mapping[str, Any]] = {
    "C_m": 58.72, "g": 9.43, "E_L": -78.85, "V_th": -51.68, "V_reset": -78.85, "t_ref": 3.75, "I_e": 0.0,
    "voltage_reset_fraction": 0.2, "voltage_reset_add": 18.51, "th_spike_add": 0.37, "th_spike_decay": 0.009,
    "th_voltage_index": 0.005, "th_voltage_decay": 0.09, "spike_dependent_threshold": False,
    "after_spike_currents": False, "adapting_threshold": False, "asc_init": (0.0, 0.0),
    "asc_decay": (0.003, 0.1), "asc_amps": (-9.18, -198.94), "asc_r": (1.0, 1.0),
}  # fmt: skip
_RESET: Final = (
    "v = E_L + spike_dependent_threshold*(voltage_reset_fraction*(before - E_L) + voltage_reset_add)"
    " + (1.0 - spike_dependent_threshold)*(V_reset - E_L)",
    "threshold_spike = spike_dependent_threshold*(threshold_spike*exp(-th_spike_decay*t_ref) + th_spike_add)",
)


def _glif(kind: Callable[[str], Receptor], ports: str, on_step: Callable[[str], str]) -> EquationModel:
    def cell_of(lengths: Lengths) -> CellEquations:
        receptors = every(kind, numbered(lengths[ports]))
        after = numbered(lengths["asc_decay"])
        after_spike = [f"dASC_{k}/dt = -asc_decay_{k}*ASC_{k} : pA (unless refractory)" for k in after]
        jumps = [f"ASC_{k} = asc_amps_{k} + ASC_{k}*asc_r_{k}*exp(-asc_decay_{k}*t_ref)" for k in after]
        lists = {f"asc_{name}_{k}": unit for k in after for name, unit in _AFTER}
        return CellEquations(
            equations=lines_of(receptors.values())
            + f"\nI_syn = {summed('I_syn', len(receptors), 'pA')} : pA (recorded)\n"
            + "\n".join(after_spike)
            + f"\nASCurrents_sum = after_spike_currents*({summed('ASC', len(after), 'pA')}) : pA (recorded)"
            + _MEMBRANE,
            threshold="v > threshold",
            reset="; ".join((*_RESET, *jumps)),
            refractory="t_ref",
            receptors={name: one.effect for name, one in receptors.items()},
            units=_UNITS
            | lists
            | {name: unit for one in receptors.values() for name, unit in one.units.items()},
            on_step="".join(map(on_step, numbered(lengths[ports]))) + "before = now; now = v",
        )

    times = {ports: (2.0,)} if ports == "tau_syn" else {**_SLOW, ports: (2.0,)}
    return EquationModel(
        cell_of, {**_DEFAULTS, **times}, {"V_m": -78.85}, _RECORDABLES, ports,
        derive=_initial_currents,
    )  # fmt: skip


def _initial_currents(values: Values) -> Values:
    """Return the after-spike currents at time 0."""
    given = {name: one for name, one in values.items() if name.startswith("asc_init_")}
    return {f"ASC_{name.removeprefix('asc_init_')}": one for name, one in given.items()}


_AFTER: Final = (("decay", "1/ms"), ("amps", "pA"), ("r", "1"))
_SLOW: Final = {"tau_syn_slow": (6.0,), "amp_slow": (0.3,)}
_RECORDABLES: Final = (
    "V_m", "I", "I_syn", "threshold", "threshold_spike", "threshold_voltage", "ASCurrents_sum",
)  # fmt: skip
GLIF: Final[Mapping[str, EquationModel]] = {
    "glif_psc": _glif(alpha_current, "tau_syn", lambda _name: ""),
    "glif_psc_double_alpha": _glif(two_alpha_currents, "tau_syn_fast", spread_arrived),
}
"""The models by NEST's names."""
