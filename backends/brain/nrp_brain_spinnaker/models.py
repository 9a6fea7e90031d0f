"""The supported cell types and synapse laws, and the kernels of cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from nrp_brain_spinnaker.machine import kinds
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

Semantics = Literal["pynn", "released"]

EXTENDED_SYNAPSES: Final = frozenset({TSODYKS_MARKRAM})
"""Synapse laws that the released software lacks."""
SYNAPSES: Final = frozenset({STATIC, STDP, *EXTENDED_SYNAPSES})

CONDUCTANCE_SCALE = 1024
"""Conductances are sent as 1024 times their value in uS, so that small ones keep their bits."""


@dataclass(frozen=True, slots=True)
class CellModel:
    """A cell type on the machine.

    Args:
        synapse, input, neuron: the kernels, codes of :mod:`~nrp_brain_spinnaker.machine.kinds`.
        current_scale: the factor for an injected current in nA.
        weights_in_mv: whether a weight is a voltage jump in mV where the machine uses a current.
        extension: whether the released software lacks it.
    """

    synapse: int
    input: int
    neuron: int
    current_scale: float = 1.0
    weights_in_mv: bool = False
    extension: bool = False

    @property
    def is_conductance_based(self) -> bool:
        """Whether weights are conductances in uS."""
        return self.input in (kinds.CONDUCTANCE, kinds.FINE_CONDUCTANCE)

    @property
    def weight_scale(self) -> int:
        """The factor for a weight on the machine."""
        return CONDUCTANCE_SCALE if self.is_conductance_based else 1

    @property
    def parameters(self) -> tuple[str, ...]:
        """PyNN's names of the membrane's parameters."""
        return _PARAMETERS[self.neuron]

    @property
    def state_variables(self) -> tuple[str, ...]:
        """PyNN's names of the state variables that can be initialised and read."""
        synaptic = () if self.weights_in_mv or self.input == kinds.JUMP else (*GSYN, *ISYN)
        return (*_STATE[self.neuron], *synaptic)

    def substeps(self, step_us: int) -> int:
        """Return the number of updates in a time step for accuracy; 1 for the machine's own cells."""
        return -(-step_us // _LONGEST_STEP_US.get(self.neuron, step_us))


def _extension(synapse: int, neuron: int) -> CellModel:
    return CellModel(synapse, kinds.FINE_CONDUCTANCE, neuron, extension=True)


GSYN = ("gsyn_exc", "gsyn_inh")
ISYN = ("isyn_exc", "isyn_inh")

_LEAKY = ("tau_m", "cm", "v_rest", "v_reset", "v_thresh", "tau_refrac")
_PARAMETERS = {
    kinds.LIF: _LEAKY,
    kinds.IZHIKEVICH: ("a", "b", "c", "d"),
    kinds.ADAPTIVE_EXPONENTIAL: (*_LEAKY, "v_spike", "delta_T", "a", "b", "tau_w"),
    kinds.HODGKIN_HUXLEY: (
        "gbar_Na", "gbar_K", "g_leak", "cm", "v_offset", "e_rev_Na", "e_rev_K", "e_rev_leak",
    ),
}  # fmt: skip
_STATE = {
    kinds.LIF: ("v",),
    kinds.IZHIKEVICH: ("v", "u"),
    kinds.ADAPTIVE_EXPONENTIAL: ("v", "w"),
    kinds.HODGKIN_HUXLEY: ("v", "m", "h", "n"),
}
_LONGEST_STEP_US = {kinds.ADAPTIVE_EXPONENTIAL: 25, kinds.HODGKIN_HUXLEY: 20}

_RELEASED = {
    "IF_curr_exp": CellModel(kinds.EXPONENTIAL, kinds.CURRENT, kinds.LIF),
    "IF_cond_exp": CellModel(kinds.EXPONENTIAL, kinds.CONDUCTANCE, kinds.LIF),
    "IF_curr_alpha": CellModel(kinds.ALPHA, kinds.CURRENT, kinds.LIF),
    "IF_curr_delta": CellModel(kinds.DELTA, kinds.IMPULSE, kinds.LIF),
    "IZK_curr_exp": CellModel(kinds.EXPONENTIAL, kinds.CURRENT, kinds.IZHIKEVICH),
    "IZK_cond_exp": CellModel(kinds.EXPONENTIAL, kinds.CONDUCTANCE, kinds.IZHIKEVICH),
    "Izhikevich": CellModel(kinds.EXPONENTIAL, kinds.CURRENT, kinds.IZHIKEVICH),
    "IF_cond_alpha": _extension(kinds.PEAKED_ALPHA, kinds.LIF),
    "EIF_cond_exp_isfa_ista": _extension(kinds.EXPONENTIAL, kinds.ADAPTIVE_EXPONENTIAL),
    "EIF_cond_alpha_isfa_ista": _extension(kinds.PEAKED_ALPHA, kinds.ADAPTIVE_EXPONENTIAL),
    "HH_cond_exp": _extension(kinds.EXPONENTIAL, kinds.HODGKIN_HUXLEY),
}
_PYNN = _RELEASED | {
    "IF_curr_alpha": CellModel(kinds.PEAKED_ALPHA, kinds.CURRENT, kinds.LIF),
    "IF_curr_delta": CellModel(kinds.DELTA, kinds.IMPULSE, kinds.LIF, weights_in_mv=True),
    # in PyNN the current is in nA, in the model's equation it is divided by a capacitance in pF
    "Izhikevich": CellModel(kinds.DELTA, kinds.JUMP, kinds.IZHIKEVICH, current_scale=1000.0),
}


def cell_models(semantics: Semantics) -> Mapping[str, CellModel]:
    """Return the cell types by PyNN name, with PyNN's or the released software's meaning."""
    return _PYNN if semantics == "pynn" else _RELEASED


STATE_VARIABLES = frozenset(name for model in _RELEASED.values() for name in model.state_variables)
"""Readable state: voltage (mV), the membrane's other variables, conductances (uS) or currents (nA)."""
