"""PyNN's standard cells that the engine simulates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL,
    ALPHA,
    CONDUCTANCE,
    EXPONENTIAL,
    FROZEN,
    HODGKIN_HUXLEY,
    IZHIKEVICH,
    JUMP,
    LINEAR,
)
from nrp_core._support.arrays import IntArray
from nrp_core.errors import DivergedError
from nrp_core.findings.refusals import no_variable
from nrp_core.network.data import Network

TIME_CONSTANTS: Final = {"tau_syn_E": 0, "tau_syn_I": 1}
"""PyNN's names, and the synapse that they belong to."""
GATES: Final = ("m", "h", "n")

_INTEGRATE_AND_FIRE = ("v_rest", "v_reset", "v_thresh", "tau_m", "cm", "tau_refrac", "i_offset")
_REVERSALS = ("e_rev_E", "e_rev_I")
_ADAPTIVE = ("v_spike", "a", "b", "delta_T", "tau_w")
_CHANNELS = ("gbar_Na", "gbar_K", "g_leak", "v_offset", "e_rev_Na", "e_rev_K", "e_rev_leak")


@dataclass(frozen=True, slots=True)
class CellType:
    """How the engine simulates one of PyNN's standard cells.

    Args:
        membrane: kind, see :mod:`nrp_brain_event.records`.
        synapse: kind, see the same module.
        parameters: PyNN's names.
        initial: the state variables that a network may set, with PyNN's initial values; the gates of
            HH_cond_exp are not among them, see :func:`nrp_brain_event.cells.load_cells`.
    """

    membrane: int
    synapse: int
    parameters: tuple[str, ...]
    initial: dict[str, float]

    @property
    def state_variables(self) -> tuple[str, ...]:
        """PyNN's names of the variables that can be read while running."""
        synaptic = () if self.membrane in (LINEAR, IZHIKEVICH) else ("gsyn_exc", "gsyn_inh")
        return (*self.initial, *synaptic)


def _linear(synapse: int) -> CellType:
    constants = () if synapse == JUMP else tuple(TIME_CONSTANTS)
    return CellType(LINEAR, synapse, (*_INTEGRATE_AND_FIRE, *constants), {"v": -65.0})


def _conductance(synapse: int) -> CellType:
    parameters = (*_INTEGRATE_AND_FIRE, *TIME_CONSTANTS, *_REVERSALS)
    return CellType(CONDUCTANCE, synapse, parameters, {"v": -65.0})


def _adaptive_exponential(synapse: int) -> CellType:
    parameters = (*_INTEGRATE_AND_FIRE, *TIME_CONSTANTS, *_REVERSALS, *_ADAPTIVE)
    return CellType(ADAPTIVE_EXPONENTIAL, synapse, parameters, {"v": -70.6, "w": 0.0})


CELL_TYPES: Final = {
    "IF_curr_exp": _linear(EXPONENTIAL),
    "IF_curr_alpha": _linear(ALPHA),
    "IF_curr_delta": _linear(JUMP),
    "IF_curr_exp_frozen": _linear(FROZEN),
    "IF_cond_exp": _conductance(EXPONENTIAL),
    "IF_cond_alpha": _conductance(ALPHA),
    "EIF_cond_exp_isfa_ista": _adaptive_exponential(EXPONENTIAL),
    "EIF_cond_alpha_isfa_ista": _adaptive_exponential(ALPHA),
    "Izhikevich": CellType(IZHIKEVICH, JUMP, ("a", "b", "c", "d", "i_offset"), {"v": -70.0, "u": -14.0}),
    "HH_cond_exp": CellType(
        HODGKIN_HUXLEY,
        EXPONENTIAL,
        ("cm", "i_offset", *TIME_CONSTANTS, *_REVERSALS, *_CHANNELS),
        {"v": -65.0},
    ),
}


def require_variable(network: Network, variable: str, neurons: IntArray) -> None:
    """Check that all of these neurons (global ids) have a state variable.

    Raises:
        CapabilityError: a neuron does not have it.
    """
    for label, first in network.offsets.items():
        population = network.populations[label]
        kind, own = CELL_TYPES.get(population.cell_type), population.equations
        shown = own.model.unit_of(variable) is not None if own else kind and variable in kind.state_variables
        if not shown and ((neurons >= first) & (neurons < first + population.size)).any():
            raise no_variable(label, variable)


def diverged(network: Network, neuron: int, t_ns: int) -> DivergedError:
    """Return the error for a neuron (global id) whose state is not finite."""
    label, index = network.label_of(neuron)
    return DivergedError(
        f"cell {index} of population '{label}' cannot be integrated any further; look for "
        "extreme weights or currents",
        t_ns=t_ns,
    )
