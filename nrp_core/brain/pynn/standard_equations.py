"""PyNN's standard cells that are given as equations here; they run where other cells in equations do."""

from __future__ import annotations

from functools import cache

from pyNN.standardmodels import cells

from nrp_core.brain.pynn.equation_cells import equation_cell


@cache
def cells_in_equations() -> dict[str, type]:
    """Return the cell types by PyNN's names, with PyNN's parameters and defaults."""
    return {"IF_cond_exp_gsfa_grr": _adapting()}


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
