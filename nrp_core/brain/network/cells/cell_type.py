"""The properties of a cell type, independent of the simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.brain.network.parameters import NOT_NEGATIVE, POSITIVE, Parameter


@dataclass(frozen=True, slots=True)
class CellType:
    """One of PyNN's standard cells.

    Args:
        name: PyNN's name, e.g. ``IF_cond_alpha``.
        summary: one sentence, for documentation.
        parameters: parameters by PyNN name, with PyNN's defaults and units.
        state: state variables with their initial values.
        weight_unit: the weight unit of synapses onto it; empty for sources, which receive none.
        stands_for: unsupported PyNN classes whose nearest equivalent this is.
    """

    name: str
    summary: str
    parameters: Mapping[str, Parameter]
    state: Mapping[str, Parameter] = field(default_factory=dict)
    weight_unit: str = ""
    stands_for: tuple[str, ...] = ()


CONDUCTANCES: Final = {
    "gsyn_exc": Parameter(0.0, "uS", NOT_NEGATIVE),
    "gsyn_inh": Parameter(0.0, "uS", NOT_NEGATIVE),
}
CURRENTS: Final = {"isyn_exc": Parameter(0.0, "nA"), "isyn_inh": Parameter(0.0, "nA")}
CURRENT_INPUT: Final = {"i_offset": Parameter(0.0, "nA")}


def synaptic_times(excitatory: float, inhibitory: float) -> dict[str, Parameter]:
    """Return the time constants of both receptors."""
    return {
        "tau_syn_E": Parameter(excitatory, "ms", POSITIVE),
        "tau_syn_I": Parameter(inhibitory, "ms", POSITIVE),
    }


def reversal_potentials(inhibitory: float) -> dict[str, Parameter]:
    """Return the reversal potentials of both receptors; the excitatory one is 0 mV."""
    return {"e_rev_E": Parameter(0.0, "mV"), "e_rev_I": Parameter(inhibitory, "mV")}
