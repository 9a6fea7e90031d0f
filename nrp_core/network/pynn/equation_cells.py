"""Cells with names of their own in equations: those of PyNN, of sPyNNaker, and of the Allen Institute."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from functools import cache
from math import e
from typing import Any, Final

from pyNN.parameters import ArrayParameter
from pyNN.standardmodels import cells

from nrp_core.network.cells import CellType
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.pynn.equation_models import bound, equation_cell

_PARTS: Final = range(3)
"""The exponentials of a filter of the cell with a random threshold, as many as PyNN has by default."""


_GLIF: Final = "Teeter et al. (2018), Nat Commun 9:709, with the defaults of NEST's `glif_psc`"
_LEVELS: Final = range(1, 6)
SOURCES: Final = {
    "IF_cond_exp_gsfa_grr": "Muller et al. (2007), Neural Computation 19:2958",
    "GIF_cond_exp": "Pozzorini et al. (2015), PLoS Comput Biol 11:e1004275",
    **dict.fromkeys(("Izhikevich_cond_dual", "IF_curr_dual_exp", "IF_curr_exp_sEMD"), "sPyNNaker 7.4.1"),
    **dict.fromkeys((f"GLIF{level}_curr_alpha" for level in _LEVELS), _GLIF),
}
"""The source of each cell."""


@cache
def cells_in_equations() -> dict[str, type]:
    """Return the cell types by their names, with the parameters and defaults of their sources."""
    return {
        "IF_cond_exp_gsfa_grr": _adapting(),
        "GIF_cond_exp": _stochastic(),
        "Izhikevich_cond_dual": _izhikevich_dual(),
        "IF_curr_dual_exp": _leaky_dual("IF_curr_dual_exp", "isyn_exc + isyn_exc2"),
        "IF_curr_exp_sEMD": _motion_detector(),
        **{f"GLIF{level}_curr_alpha": _glif(level) for level in _LEVELS},
    }


def _adapting() -> type:
    """Return the cell of Muller et al. (2007), Neural Computation 19."""
    pynn = cells.IF_cond_exp_gsfa_grr
    return equation_cell(
        """
        dv/dt = (v_rest - v)/tau_m + (gsyn_exc*(e_rev_E - v) + gsyn_inh*(e_rev_I - v) + g_s*(e_rev_sfa - v)
            + g_r*(e_rev_rr - v) + i_offset)/cm : mV (unless refractory)
        dg_s/dt = -g_s/tau_sfa : nS
        dg_r/dt = -g_r/tau_rr : nS
        dgsyn_exc/dt = -gsyn_exc/tau_syn_E : uS
        dgsyn_inh/dt = -gsyn_inh/tau_syn_I : uS
        """.replace("\n            +", " +"),
        threshold="v > v_thresh",
        reset="v = v_reset; g_s += q_sfa; g_r += q_rr",
        refractory="tau_refrac",
        receptors={"excitatory": "gsyn_exc", "inhibitory": "gsyn_inh"},
        parameters={name: f"{value} {pynn.units[name]}" for name, value in pynn.default_parameters.items()},
        initial={name: f"{value} {pynn.units[name]}" for name, value in pynn.default_initial_values.items()},
        name="IF_cond_exp_gsfa_grr",
    )


def _stochastic() -> type:
    """Return the cell of Pozzorini et al. (2015), PLoS Comput Biol 11:e1004275.

    It spikes with the intensity ``lambda0 exp((v - v_t) / delta_v)``, and each spike adds to a current and to
    the threshold, which decay as sums of exponentials.
    """
    pynn = cells.GIF_cond_exp
    decays = [
        f"d{part}_{k}/dt = -{part}_{k}/tau_{part}_{k} : {unit}"
        for part, unit in (("eta", "nA"), ("gamma", "mV"))
        for k in _PARTS
    ]
    jumps = [f"{part}_{k} += a_{part}_{k}" for part in ("eta", "gamma") for k in _PARTS]
    several = [name for name, value in pynn.default_parameters.items() if isinstance(value, ArrayParameter)]
    units = {name: pynn.units[name] for name in pynn.default_parameters if name not in several}
    units |= {f"{name}_{k}": pynn.units[name] for name in several for k in _PARTS}
    equations = CellEquations(
        """
        isyn = gsyn_exc*(e_rev_E - v) + gsyn_inh*(e_rev_I - v) : nA
        dv/dt = (v_rest - v)/tau_m + (isyn - i_eta + i_offset)/cm : mV (unless refractory)
        i_eta = eta_0 + eta_1 + eta_2 : nA (recorded)
        v_t = v_t_star + gamma_0 + gamma_1 + gamma_2 : mV (recorded)
        dgsyn_exc/dt = -gsyn_exc/tau_syn_E : uS
        dgsyn_inh/dt = -gsyn_inh/tau_syn_I : uS
        """
        + "\n".join(decays),
        threshold="rand() < -expm1(-lambda0*exp(min((v - v_t)/delta_v, 500))*dt)",
        reset="; ".join(["v = v_reset", *jumps]),
        refractory="tau_refrac",
        receptors={"excitatory": "gsyn_exc", "inhibitory": "gsyn_inh"},
        units=units,
    )
    return bound(
        CellType("GIF_cond_exp", str(pynn.__doc__), {}),
        equations,
        default_parameters=pynn.default_parameters,
        default_initial_values=pynn.default_initial_values,
        units=pynn.units,
        recordable=pynn.recordable,
    )


def _izhikevich_dual() -> type:
    """Return sPyNNaker's ``Izhikevich_cond_dual``, with its defaults.

    As in sPyNNaker, a current of 1 nA moves the voltage by 1 mV/ms.
    """
    return equation_cell(
        """
        gsyn_exc = isyn_exc + isyn_exc2 : uS (recorded)
        gsyn_inh = isyn_inh : uS (recorded)
        current = gsyn_exc*(e_rev_E - v) + gsyn_inh*(e_rev_I - v) : nA
        dv/dt = (0.04*v*v/mV + 5*v + 140*mV)/ms - u + (current + i_offset)*mV/(nA*ms) : mV
        du/dt = a*(b*v - u) : mV/ms
        disyn_exc/dt = -isyn_exc/tau_syn_E : uS
        disyn_exc2/dt = -isyn_exc2/tau_syn_E2 : uS
        disyn_inh/dt = -isyn_inh/tau_syn_I : uS
        """,
        threshold="v >= 30*mV",
        reset="v = c; u += d",
        parameters={
            "a": "0.02 /ms", "b": "0.2 /ms", "c": "-65 mV", "d": "2 mV/ms", "i_offset": "0 nA",
            "tau_syn_E": "5 ms", "tau_syn_E2": "5 ms", "tau_syn_I": "5 ms", "e_rev_E": "0 mV",
            "e_rev_I": "-70 mV",
        },
        receptors={"excitatory": "isyn_exc", "excitatory2": "isyn_exc2", "inhibitory": "isyn_inh"},
        initial={"v": "-70 mV", "u": "-14 mV/ms"},
        name="Izhikevich_cond_dual",
    )  # fmt: skip


def _leaky_dual(name: str, excitation: str, more: str = "", **others: Any) -> type:
    """Return a leaky cell of sPyNNaker with two excitatory receptors and an inhibitory one.

    Args:
        name: its name.
        excitation: the excitatory current.
        more: further equations.
        others: further arguments of :func:`equation_cell`.
    """
    own = others.pop("parameters", {})
    return equation_cell(
        f"""
        gsyn_exc = {excitation} : nA (recorded)
        gsyn_inh = isyn_inh : nA (recorded)
        dv/dt = (v_rest - v)/tau_m + (gsyn_exc - gsyn_inh + i_offset)/cm : mV (unless refractory)
        disyn_exc/dt = -isyn_exc/tau_syn_E : nA
        disyn_exc2/dt = -isyn_exc2/tau_syn_E2 : nA
        disyn_inh/dt = -isyn_inh/tau_syn_I : nA
        {more}
        """,
        threshold="v >= v_thresh", reset="v = v_reset", refractory="tau_refrac",
        parameters={
            "tau_m": "20 ms", "cm": "1 nF", "v_rest": "-65 mV", "v_reset": "-65 mV", "v_thresh": "-50 mV",
            "tau_syn_E": "5 ms", "tau_syn_E2": "5 ms", "tau_syn_I": "5 ms", "tau_refrac": "0.1 ms",
            "i_offset": "0 nA", **own,
        },
        receptors={
            "excitatory": "isyn_exc", "excitatory2": "isyn_exc2", "inhibitory": "isyn_inh -= weight",
        },
        initial={"v": "-65 mV"}, name=name, **others,
    )  # fmt: skip


def _motion_detector() -> type:
    """Return sPyNNaker's ``IF_curr_exp_sEMD``, the spiking elementary motion detector.

    Excitation is the second input times the value that the first one had when the second began. As on the
    machine this is decided in each step; an input of less than the machine's smallest current is 0.
    """
    return _leaky_dual(
        "IF_curr_exp_sEMD",
        "isyn_exc2*multiplicator*scaling_factor",
        "dmultiplicator/dt = 0*nA/ms : nA\n        dexc2_old/dt = 0*nA/ms : nA",
        on_step="multiplicator += int(multiplicator == 0*nA and exc2_old < 2**-15*nA)*isyn_exc; "
        "multiplicator *= int(isyn_exc2 >= 0.001*nA); exc2_old = isyn_exc2",
        parameters={"scaling_factor": "1 /nA"},
    )


_E: Final = f"{e!r}"
_DIVERTED, _FED_BACK, _ADAPTED = (2, 4, 5), (3, 4, 5), (5,)
"""The levels whose reset and threshold depend on spikes, those with currents after spikes, and the one whose
threshold follows the voltage."""


def _glif(level: int) -> type:
    """Return a generalised leaky cell of Teeter et al. (2018), Nat Commun 9:709, with alpha synapses.

    Defaults, and the rules for the refractory period, in which currents and threshold wait, are those of
    NEST's ``glif_psc``.
    """
    held = "(unless refractory)"
    values = {
        "v_rest": "-78.85 mV", "v_thresh": "-51.68 mV", "cm": "0.05872 nF", "tau_m": "6.2269353128 ms",
        "tau_refrac": "3.75 ms", "tau_syn_E": "2 ms", "tau_syn_I": "2 ms", "i_offset": "0 nA",
    }  # fmt: skip
    lines, resets, currents, threshold = [], [], "", "v_thresh"
    if level in _FED_BACK:
        for k, (amplitude, decay) in enumerate((("-0.00918 nA", "0.003 /ms"), ("-0.19894 nA", "0.1 /ms"))):
            values |= {f"asc_amps_{k}": amplitude, f"asc_decay_{k}": decay, f"asc_r_{k}": "1"}
            currents += f" + asc_{k}"
            lines.append(f"dasc_{k}/dt = -asc_decay_{k}*asc_{k} : nA {held}")
            resets.append(f"asc_{k} = asc_{k}*asc_r_{k}*exp(-asc_decay_{k}*tau_refrac) + asc_amps_{k}")
    if level in _DIVERTED:
        values |= {"voltage_reset_fraction": "0.2", "voltage_reset_add": "18.51 mV"}
        values |= {"th_spike_add": "0.37 mV", "th_spike_decay": "0.009 /ms"}
        lines.append(f"dth_spike/dt = -th_spike_decay*th_spike : mV {held}")
        resets.append("v = v_rest + voltage_reset_fraction*(v - v_rest) + voltage_reset_add")
        resets.append("th_spike = th_spike*exp(-th_spike_decay*tau_refrac) + th_spike_add")
        threshold += " + th_spike"
    else:
        values["v_reset"] = "-78.85 mV"
        resets.append("v = v_reset")
    if level in _ADAPTED:
        values |= {"th_voltage_index": "0.005 /ms", "th_voltage_decay": "0.09 /ms"}
        lines.append(
            f"dth_voltage/dt = th_voltage_index*(v - v_rest) - th_voltage_decay*th_voltage : mV {held}"
        )
        threshold += " + th_voltage"
    synapses = [
        line
        for end in ("exc", "inh")
        for line in (
            f"disyn_{end}/dt = ({_E}*rise_{end} - isyn_{end})/tau_syn_{end[0].upper()} : nA",
            f"drise_{end}/dt = -rise_{end}/tau_syn_{end[0].upper()} : nA",
        )
    ]
    membrane = f"(v_rest - v)/tau_m + (isyn_exc + isyn_inh + i_offset{currents})/cm"
    return equation_cell(
        "\n".join([f"dv/dt = {membrane} : mV {held}", *lines, *synapses]),
        threshold=f"v > {threshold}", reset="; ".join(resets), refractory="tau_refrac", parameters=values,
        receptors={"excitatory": "rise_exc", "inhibitory": "rise_inh"}, initial={"v": "-78.85 mV"},
        name=f"GLIF{level}_curr_alpha",
    )  # fmt: skip
