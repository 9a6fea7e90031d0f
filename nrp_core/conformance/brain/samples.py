"""Sample cells: for every standard cell, parameters and inputs with a known response."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nrp_core.brain.network.cells import CELLS


@dataclass(frozen=True, slots=True)
class Sample:
    """A cell that rests without input.

    Args:
        cell_type: PyNN's name.
        parameters: the parameters that differ from PyNN's defaults.
        current_na: a current at which it fires regularly, nA.
        strong: a weight with which one excitatory spike makes it fire once.
        weak: a weight whose potential stays far below the threshold.
        rest_mv: its resting potential, if not ``v_rest`` or PyNN's initial value.
        loses_refractory_input: whether synapses stand still in the refractory period, and arriving spikes are
            lost. Else the membrane alone is clamped.
    """

    cell_type: str
    parameters: Mapping[str, float] = field(default_factory=dict, hash=False)
    current_na: float = 0.8
    strong: float = 5.0
    weak: float = 0.1
    rest_mv: float | None = None
    loses_refractory_input: bool = False

    @property
    def all_parameters(self) -> dict[str, float]:
        """All parameters, by PyNN's names."""
        defaults = {name: known.default for name, known in CELLS[self.cell_type].parameters.items()}
        return {**defaults, **self.parameters}

    @property
    def initial_values(self) -> dict[str, float]:
        """The resting potential, mV."""
        initial = {name: known.default for name, known in CELLS[self.cell_type].state.items()}
        rest_mv = self.parameters.get("v_rest", self.rest_mv)
        if rest_mv is not None:
            initial["v"] = rest_mv
        return {name: value for name, value in initial.items() if name in ("v", "u", "w")}

    @property
    def inhibitory_sign(self) -> int:
        """The sign of a weight on the inhibitory receptor."""
        return 1 if "_cond_" in self.cell_type else -1


_LEAKY = {  # the reset is below the resting potential, so that tests can tell them apart
    "v_rest": -65.0, "v_reset": -68.0, "v_thresh": -50.0, "tau_m": 10.0, "cm": 0.25, "tau_refrac": 10.0,
}  # fmt: skip
_CURRENTS = _LEAKY | {"tau_syn_E": 2.0, "tau_syn_I": 3.0}
_ADAPTIVE = {"tau_refrac": 10.0, "tau_syn_E": 2.0, "v_reset": -66.0}
_CONDUCTANCES = _CURRENTS | {"e_rev_E": 0.0, "e_rev_I": -75.0}

SAMPLES = {
    sample.cell_type: sample
    for sample in (  # in the order in which a test prefers them
        Sample("IF_cond_alpha", _CONDUCTANCES, strong=0.05, weak=0.001),
        Sample("IF_cond_exp", _CONDUCTANCES, strong=0.1, weak=0.002),
        Sample("IF_curr_exp", _CURRENTS),
        Sample("IF_curr_alpha", _CURRENTS, strong=3.0, weak=0.05),
        Sample("IF_curr_delta", _LEAKY, strong=20.0, weak=2.0),
        Sample("IF_curr_exp_frozen", _CURRENTS, strong=300.0, weak=4.0, loses_refractory_input=True),
        Sample("EIF_cond_alpha_isfa_ista", _ADAPTIVE, 1.0, 0.1, 0.001),
        Sample("EIF_cond_exp_isfa_ista", _ADAPTIVE, 1.0, 0.2, 0.002),
        Sample("Izhikevich", {"d": 8.0}, 0.01, 60.0, 1.0),
        Sample("IZK_curr_exp", {"d": 8.0, "tau_syn_E": 2.0, "tau_syn_I": 3.0}, 10.0, 30.0, 1.0),
        Sample("IZK_cond_exp", {"d": 8.0, "tau_syn_E": 2.0, "tau_syn_I": 3.0}, 10.0, 0.4, 0.01),
        Sample("HH_cond_exp", {"tau_syn_E": 2.0}, 0.5, 0.1, 0.001, rest_mv=-64.76462926),
    )
}
