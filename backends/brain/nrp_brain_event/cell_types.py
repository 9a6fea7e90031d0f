"""PyNN's standard cells that the engine knows, and what makes their parameters possible."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL, ALPHA, CONDUCTANCE, EXPONENTIAL, HODGKIN_HUXLEY, IZHIKEVICH, JUMP, LINEAR,
)  # fmt: skip

_INTEGRATE_AND_FIRE = ("v_rest", "v_reset", "tau_m", "cm", "tau_refrac", "i_offset", "v_thresh")
TIME_CONSTANTS = ("tau_syn_E", "tau_syn_I")
_SYNAPSES = (*TIME_CONSTANTS, "e_rev_E", "e_rev_I")
_ADAPTIVE = ("v_spike", "a", "b", "delta_T", "tau_w")
_IZHIKEVICH = ("a", "b", "c", "d", "i_offset")
_HODGKIN_HUXLEY = (
    "gbar_Na", "gbar_K", "g_leak", "cm", "v_offset", "e_rev_Na", "e_rev_K", "e_rev_leak", "i_offset",
)  # fmt: skip

POSITIVE = frozenset({"tau_m", "cm", "tau_syn_E", "tau_syn_I", "tau_w"})
NOT_NEGATIVE = frozenset({"tau_refrac", "delta_T", "gbar_Na", "gbar_K", "g_leak"})
MAY_BE_INFINITE = frozenset({"v_thresh", "v_spike"})

IZHIKEVICH_PEAK_MV: Final = 30.0
HODGKIN_HUXLEY_THRESHOLD_MV: Final = -20.0


@dataclass(frozen=True)
class CellType:
    """How the engine simulates one of PyNN's standard cells.

    Args:
        membrane, synapse: kinds, see :mod:`nrp_brain_event.records`.
        parameters: PyNN's names.
        initial: PyNN's initial values of the state variables.
    """

    membrane: int
    synapse: int
    parameters: tuple[str, ...]
    initial: dict[str, float] = field(default_factory=lambda: {"v": -65.0})

    @property
    def state_variables(self) -> tuple[str, ...]:
        """PyNN's names of what can be read while running."""
        if self.membrane in (LINEAR, IZHIKEVICH):
            return tuple(self.initial)
        return (*(name for name in self.initial if name not in "mhn"), "gsyn_exc", "gsyn_inh")


def _adaptive_exponential(synapse: int) -> CellType:
    parameters = (*_INTEGRATE_AND_FIRE, *_SYNAPSES, *_ADAPTIVE)
    return CellType(ADAPTIVE_EXPONENTIAL, synapse, parameters, {"v": -70.6, "w": 0.0})


CELL_TYPES: Final = {
    "IF_curr_exp": CellType(LINEAR, EXPONENTIAL, (*_INTEGRATE_AND_FIRE, *TIME_CONSTANTS)),
    "IF_curr_alpha": CellType(LINEAR, ALPHA, (*_INTEGRATE_AND_FIRE, *TIME_CONSTANTS)),
    "IF_curr_delta": CellType(LINEAR, JUMP, _INTEGRATE_AND_FIRE),
    "IF_cond_exp": CellType(CONDUCTANCE, EXPONENTIAL, (*_INTEGRATE_AND_FIRE, *_SYNAPSES)),
    "IF_cond_alpha": CellType(CONDUCTANCE, ALPHA, (*_INTEGRATE_AND_FIRE, *_SYNAPSES)),
    "EIF_cond_exp_isfa_ista": _adaptive_exponential(EXPONENTIAL),
    "EIF_cond_alpha_isfa_ista": _adaptive_exponential(ALPHA),
    "Izhikevich": CellType(IZHIKEVICH, JUMP, _IZHIKEVICH, {"v": -70.0, "u": -14.0}),
    "HH_cond_exp": CellType(HODGKIN_HUXLEY, EXPONENTIAL, (*_HODGKIN_HUXLEY, *_SYNAPSES)),
}
