"""PyNN's models for Brian2, put right where they do something else than PyNN says.

Importing this loads Brian2.
"""

from __future__ import annotations

from typing import Any, Final

import brian2
import pyNN.brian2 as sim
from pyNN.brian2.cells import BaseNeuronGroup, ThresholdNeuronGroup
from pyNN.brian2.standardmodels.cells import leaky_iaf
from pyNN.brian2.standardmodels.synapses import StaticSynapse
from pyNN.standardmodels import StandardSynapseType, build_translations, synapses


class CurrentAlpha(sim.IF_curr_alpha):  # type: ignore[misc]
    """PyNN's cells, whose inhibitory currents decay with the excitatory time constant, put right."""

    eqs = leaky_iaf + brian2.Equations(
        """
        die/dt = (exp(1) * ye - ie) / tau_syn_e : amp
        dye/dt = -ye / tau_syn_e                : amp
        dii/dt = (exp(1) * yi - ii) / tau_syn_i : amp
        dyi/dt = -yi / tau_syn_i                : amp
        i_syn = ie + ii                         : amp
        tau_syn_e                               : second
        tau_syn_i                               : second
        """
    )


class AdaptiveAlpha(sim.EIF_cond_alpha_isfa_ista):  # type: ignore[misc]
    """PyNN's cells, whose synapses make the conductance jump, put right: it rises."""

    post_synaptic_variables = {"excitatory": "ye", "inhibitory": "yi"}  # noqa: RUF012


class HodgkinHuxleyGroup(BaseNeuronGroup):  # type: ignore[misc]
    """PyNN's group diverges at steps of 0.1 ms, and spikes in each step above the threshold."""

    def __init__(self, size: int, equations: Any, **parameters: Any) -> None:
        above = "v > -40*mV"
        super().__init__(
            size, equations, above, reset=None, refractory=above, method="exponential_euler", **parameters
        )


class SecondOrderGroup(ThresholdNeuronGroup):  # type: ignore[misc]
    """PyNN's group takes Euler steps, with which a membrane reaches its threshold too soon."""

    def __init__(self, size: int, equations: Any, **parameters: Any) -> None:
        super().__init__(size, equations, method="rk2", **parameters)


def _in_group(cell_type: Any, group: type) -> Any:
    return type(cell_type.__name__, (cell_type,), {"brian2_model": group, "__doc__": cell_type.__doc__})


PUT_RIGHT: Final = {
    "IF_curr_alpha": CurrentAlpha,
    "EIF_cond_alpha_isfa_ista": AdaptiveAlpha,
    "IF_cond_exp": _in_group(sim.IF_cond_exp, SecondOrderGroup),
    "IF_cond_alpha": _in_group(sim.IF_cond_alpha, SecondOrderGroup),
    "HH_cond_exp": _in_group(sim.HH_cond_exp, HodgkinHuxleyGroup),
}
"""By the name of the cell type."""


class TsodyksMarkramSynapse(StandardSynapseType):  # type: ignore[misc]
    """The model of Tsodyks, Uziel & Markram (2000), J Neurosci 20:RC50; PyNN's resources never recover.

    Between two spikes the active resources ``y`` become inactive ones ``z`` with the time constant of the
    target's synapses, and these recover.
    """

    default_parameters = synapses.TsodyksMarkramSynapse.default_parameters
    eqs = """weight : %(weight_units)s
             U : 1
             tau_syn : second
             tau_rec : second
             tau_facil : second
             y : 1
             z : 1
             u : 1
             last : second"""
    pre = """fade = exp(-(t - last) / tau_syn)
             recovery = exp(-(t - last) / tau_rec)
             z = z * recovery + y * (fade - recovery) * tau_rec / (tau_syn - tau_rec)
             y = y * fade
             u = u * exp(-(t - last) / tau_facil)
             u = u + U * (1 - u)
             released = u * (1 - y - z)
             %(syn_var)s += weight * released
             y = y + released
             last = t"""
    post = None
    initial_conditions: Final[dict[str, float]] = {}
    translations = build_translations(
        *((name, name) for name in ("weight", "delay", "U", "tau_rec", "tau_facil"))
    )
    _get_minimum_delay = StaticSynapse._get_minimum_delay
    _set_target_type = StaticSynapse._set_target_type
