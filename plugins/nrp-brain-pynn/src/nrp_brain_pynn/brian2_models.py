"""PyNN's models for Brian2, with corrections of deviations from PyNN.

Importing this loads Brian2.
"""

from __future__ import annotations

from typing import Any, Final

import brian2
import pyNN.brian2 as sim
from pyNN.brian2.standardmodels.cells import leaky_iaf
from pyNN.brian2.standardmodels.synapses import StaticSynapse
from pyNN.standardmodels import StandardSynapseType, build_translations, synapses

_STABLE_MS: Final = 0.05
"""Maximum step for Hodgkin-Huxley cells with a method of higher order."""


class CurrentAlpha(sim.IF_curr_alpha):  # type: ignore[misc]
    """PyNN's cells, corrected: their inhibitory currents decay with the excitatory time constant."""

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
    """PyNN's cells, corrected: their conductance jumps instead of rising."""

    post_synaptic_variables = {"excitatory": "ye", "inhibitory": "yi"}  # noqa: RUF012


class Cells(brian2.NeuronGroup):  # type: ignore[misc]
    """Cells with individual parameters; PyNN's groups share some, and are refractory a step too short.

    Brian2 counts from the beginning of the step in which a cell fires; here the spike is at its end.
    """

    more = """v_thresh : volt
              v_reset : volt
              held : second"""
    threshold: str = "v > v_thresh"
    reset: str | None = "v = v_reset"
    method: str | tuple[str, ...] = ("exact", "euler", "heun")  # Brian2's default
    refractory: Any = "ceil(held / dt - 1e-6) * dt + dt"

    def __init__(self, size: int, equations: Any, **parameters: Any) -> None:
        super().__init__(
            size, equations + brian2.Equations(self.more), method=self.method,
            threshold=self.threshold, reset=self.reset, refractory=self.refractory,
            clock=sim.simulator.state.network.clock,
        )  # fmt: skip
        for name, values in parameters.items():
            setattr(self, name, values)
        self.add_attribute("initial_values")
        self.initial_values: dict[str, Any] = {}

    def initialize(self) -> None:
        """Start from the initial values."""
        for name, values in self.initial_values.items():
            setattr(self, name, values)


class SecondOrderCells(Cells):
    """Conductances need a better method than Euler's: with it membranes reach their threshold too soon."""

    method = "rk2"


class AdaptiveCells(SecondOrderCells):
    """A spike that has begun is cut before its exponential overflows."""

    more = """v_reset : volt
              b : amp
              held : second"""
    threshold, reset = "v > v_spike or v > v_thresh + 5 * delta_T", "v = v_reset; w += b"


class IzhikevichCells(Cells):
    """Cells without a refractory time."""

    more = ""
    threshold, reset, refractory = "v >= 30*mV", "v = v_reset; u += d", 0 * brian2.ms


class HodgkinHuxleyCells(Cells):
    """PyNN's group diverges with steps of 0.1 ms, and spikes in each step above the threshold."""

    more = ""
    threshold, reset, method = "v > -40*mV", None, "exponential_euler"
    refractory = threshold

    def __init__(self, size: int, equations: Any, **parameters: Any) -> None:
        if sim.simulator.state.dt <= _STABLE_MS:
            self.method = "rk4"
        super().__init__(size, equations, **parameters)


def _of(group: type[Cells], cell_type: Any) -> Any:
    """Return PyNN's description of a cell type, with cells of a group."""
    names = dict(cell_type.translations)
    if "tau_refrac" in names:  # PyNN uses one value for a group for this name
        names |= build_translations(("tau_refrac", "held", brian2.ms))
    members = {"brian2_model": group, "translations": names, "__doc__": cell_type.__doc__}
    return type(cell_type.__name__, (cell_type,), members)


PUT_RIGHT: Final = {
    "IF_curr_exp": _of(Cells, sim.IF_curr_exp),
    "IF_curr_alpha": _of(Cells, CurrentAlpha),
    "IF_curr_delta": _of(Cells, sim.IF_curr_delta),
    "IF_cond_exp": _of(SecondOrderCells, sim.IF_cond_exp),
    "IF_cond_alpha": _of(SecondOrderCells, sim.IF_cond_alpha),
    "EIF_cond_exp_isfa_ista": _of(AdaptiveCells, sim.EIF_cond_exp_isfa_ista),
    "EIF_cond_alpha_isfa_ista": _of(AdaptiveCells, AdaptiveAlpha),
    "Izhikevich": _of(IzhikevichCells, sim.Izhikevich),
    "HH_cond_exp": _of(HodgkinHuxleyCells, sim.HH_cond_exp),
}
"""Groups by the name of the cell type."""


class TsodyksMarkramSynapse(StandardSynapseType):  # type: ignore[misc]
    """The model of Tsodyks, Uziel & Markram (2000), J Neurosci 20:RC50; PyNN's resources never recover.

    Between two spikes the active resources become inactive ones with the time constant of the target's
    synapses, and these recover. Variables must not have the names of cell variables.
    """

    default_parameters = synapses.TsodyksMarkramSynapse.default_parameters
    eqs = """weight : %(weight_units)s
             U : 1
             tau_syn : second
             tau_rec : second
             tau_facil : second
             active : 1
             inactive : 1
             usage : 1
             last : second"""
    pre = """fade = exp(-(t - last) / tau_syn)
             recovery = exp(-(t - last) / tau_rec)
             inactive = inactive * recovery + active * (fade - recovery) * tau_rec / (tau_syn - tau_rec)
             active = active * fade
             usage = usage * exp(-(t - last) / tau_facil)
             usage = usage + U * (1 - usage)
             released = usage * (1 - active - inactive)
             %(syn_var)s += weight * released
             active = active + released
             last = t"""
    post = None
    initial_conditions: Final[dict[str, float]] = {}
    translations = build_translations(
        *((name, name) for name in ("weight", "delay", "U", "tau_rec", "tau_facil"))
    )
    _get_minimum_delay = StaticSynapse._get_minimum_delay
    _set_target_type = StaticSynapse._set_target_type
