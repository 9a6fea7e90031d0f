"""PyNN's standard cells that are given as equations here; they run where other cells in equations do."""

from __future__ import annotations

from functools import cache
from typing import Final

from pyNN.parameters import ArrayParameter
from pyNN.standardmodels import cells

from nrp_core.brain.network.cells import CellType
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.pynn.equation_cells import bound, equation_cell

_PARTS: Final = range(3)
"""The exponentials of a filter of the cell with a random threshold, as many as PyNN has by default."""


@cache
def cells_in_equations() -> dict[str, type]:
    """Return the cell types by PyNN's names, with PyNN's parameters and defaults."""
    return {"IF_cond_exp_gsfa_grr": _adapting(), "GIF_cond_exp": _stochastic()}


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
