"""Leaky, adaptive exponential and stochastic integrate-and-fire models with any number of receptors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from nrp_core.network.equations.cell import CellEquations
from nrp_pynest.equations.model import (
    EquationModel,
    Lengths,
    Values,
    numbered,
    summed,
    unit_peak,
    units_of,
)
from nrp_pynest.equations.receptors import (
    Receptor,
    alpha_conductance,
    beta_conductance,
    every,
    exponential_conductance,
    exponential_current,
    lines_of,
)

Kind = Callable[[str], Receptor]

# Brette & Gerstner (2005, J Neurophysiol 94:3637); as in NEST, nothing rises above V_peak.
_ADAPTIVE: Final = """
cut = min(v, V_peak) : mV
dv/dt = (g_L*Delta_T*exp((cut - V_th)/Delta_T) - g_L*(cut - E_L) + I_syn - w + i_offset)/C_m : mV (unless refractory)
dw/dt = (a*(cut - E_L) - w)/tau_w : pA
"""  # noqa: E501 - one equation
_ADAPTIVE_UNITS: Final = {
    **units_of("C_m", "pF"), **units_of("g_L a", "nS"), **units_of("E_L V_th V_peak V_reset Delta_T", "mV"),
    **units_of("tau_w t_ref", "ms"), **units_of("b i_offset", "pA"),
}  # fmt: skip
_ADAPTIVE_DEFAULTS: Final = {
    "C_m": 281.0, "g_L": 30.0, "E_L": -70.6, "V_th": -50.4, "V_peak": 0.0, "V_reset": -60.0, "Delta_T": 2.0,
    "tau_w": 144.0, "t_ref": 0.0, "a": 4.0, "b": 80.5, "I_e": 0.0,
}  # fmt: skip

# Mensi et al. (2012, J Neurophysiol 107:1756) and Pozzorini et al. (2015, PLoS Comput Biol 11:e1004275).
_STOCHASTIC_UNITS: Final = {
    **units_of("C_m", "pF"), **units_of("g_L", "nS"), **units_of("E_L V_T_star V_reset Delta_V", "mV"),
    **units_of("t_ref", "ms"), **units_of("lambda_0", "Hz"), **units_of("i_offset", "pA"),
}  # fmt: skip
_STOCHASTIC_DEFAULTS: Final = {
    "C_m": 80.0, "g_L": 4.0, "E_L": -70.0, "V_T_star": -35.0, "V_reset": -55.0, "Delta_V": 0.5, "t_ref": 4.0,
    "lambda_0": 1.0, "I_e": 0.0, "q_sfa": (), "tau_sfa": (), "q_stc": (), "tau_stc": (),
}  # fmt: skip


def _receptors(kind: Kind, ports: str, lengths: Lengths) -> tuple[dict[str, Receptor], str]:
    """Return the receptors of cells by name, and the line of their sum."""
    names = numbered(lengths[ports]) if ports else ["ex", "in"]
    total = " + ".join(f"I_syn_{name}" for name in names)
    return every(kind, names), f"I_syn = {total} : pA\n"


def _adaptive(kind: Kind, ports: str) -> Callable[[Lengths], CellEquations]:
    def cell_of(lengths: Lengths) -> CellEquations:
        receptors, total = _receptors(kind, ports, lengths)
        return CellEquations(
            equations=lines_of(receptors.values()) + "\n" + total + _ADAPTIVE,
            threshold="v >= V_peak",
            reset="v = V_reset; w += b",
            refractory="t_ref",
            receptors={name: one.effect for name, one in receptors.items()},
            units=_ADAPTIVE_UNITS | _units(receptors),
        )

    return cell_of


def _stochastic(kind: Kind, ports: str) -> Callable[[Lengths], CellEquations]:
    def cell_of(lengths: Lengths) -> CellEquations:
        receptors, total = _receptors(kind, ports, lengths)
        n_sfa, n_stc = lengths["q_sfa"], lengths["q_stc"]
        adaptation = [f"dsfa_{k}/dt = -sfa_{k}/tau_sfa_{k} : mV" for k in numbered(n_sfa)]
        adaptation += [f"dstc_{k}/dt = -stc_{k}/tau_stc_{k} : pA" for k in numbered(n_stc)]
        jumps = [f"sfa_{k} += q_sfa_{k}" for k in numbered(n_sfa)]
        jumps += [f"stc_{k} += q_stc_{k}" for k in numbered(n_stc)]
        lists = {f"q_sfa_{k}": "mV" for k in numbered(n_sfa)} | {f"q_stc_{k}": "pA" for k in numbered(n_stc)}
        times = [f"tau_sfa_{k}" for k in numbered(n_sfa)] + [f"tau_stc_{k}" for k in numbered(n_stc)]
        return CellEquations(
            equations="\n".join((lines_of(receptors.values()), total, *adaptation))
            + f"\nE_sfa = V_T_star + {summed('sfa', n_sfa, 'mV')} : mV (recorded)\n"
            f"I_stc = {summed('stc', n_stc, 'pA')} : pA (recorded)\n"
            "dv/dt = (i_offset + I_syn - I_stc - g_L*(v - E_L))/C_m : mV (unless refractory)",
            threshold="rand() < -expm1(-lambda_0*exp((v - E_sfa)/Delta_V)*dt)",
            reset="; ".join(("v = V_reset", *jumps)),
            refractory="t_ref",
            receptors={name: one.effect for name, one in receptors.items()},
            units=_STOCHASTIC_UNITS | _units(receptors) | lists | dict.fromkeys(times, "ms"),
        )

    return cell_of


def _units(receptors: Mapping[str, Receptor]) -> dict[str, str]:
    return {name: unit for one in receptors.values() for name, unit in one.units.items()}


def _peaks(values: Values) -> Values:
    """Return the factors of receptors whose conductance rises and decays."""
    ends = [name.removeprefix("tau_rise_") for name in values if name.startswith("tau_rise_")]
    return {f"unit_peak_{k}": unit_peak(values[f"tau_decay_{k}"], values[f"tau_rise_{k}"]) for k in ends}


_TIME: Final = {"tau_syn": (2.0,)}
_SIGNS: Final = {"tau_syn_ex": 2.0, "tau_syn_in": 2.0}
_REVERSAL: Final = {"E_rev": (0.0,)}
_RISE: Final = {"tau_rise": (2.0,), "tau_decay": (20.0,)}
_AEIF: Final = {
    "aeif_cond_alpha_multisynapse": EquationModel(
        _adaptive(alpha_conductance, "E_rev"), {**_ADAPTIVE_DEFAULTS, **_REVERSAL, **_TIME},
        {"V_m": -70.6}, ("V_m", "w"), "E_rev",
    ),
    "aeif_cond_beta_multisynapse": EquationModel(
        _adaptive(beta_conductance, "E_rev"), {**_ADAPTIVE_DEFAULTS, **_REVERSAL, **_RISE},
        {"V_m": -70.6}, ("V_m", "w"), "E_rev", derive=_peaks,
    ),
}  # fmt: skip
_GIF: Final = {
    name: EquationModel(
        _stochastic(kind, ports), {**_STOCHASTIC_DEFAULTS, **more}, {"V_m": -70.0},
        ("V_m", "E_sfa", "I_stc"), ports,
    )
    for name, kind, ports, more in (
        ("gif_psc_exp", exponential_current, "", _SIGNS),
        ("gif_psc_exp_multisynapse", exponential_current, "tau_syn", _TIME),
        ("gif_cond_exp_multisynapse", exponential_conductance, "tau_syn", {**_TIME, **_REVERSAL}),
    )
}  # fmt: skip
INTEGRATE_AND_FIRE: Final[Mapping[str, EquationModel]] = {**_AEIF, **_GIF}
"""The models by NEST's names."""
