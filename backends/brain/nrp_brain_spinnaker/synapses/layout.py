"""The properties of a network that the synapses of every law are loaded with."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_brain_spinnaker.host.cells import Grid
from nrp_brain_spinnaker.models import Semantics
from nrp_core._support.arrays import IntArray


@dataclass(frozen=True, slots=True)
class Layout:
    """The properties of a network on the machine.

    Args:
        n_sources: number of global ids.
        n: number of simulated neurons.
        tau_syn: time constant of the synapse behind each line, s16.15, shape ``(2 n,)``.
        grid: the time step.
        semantics: whose meaning parameters have.
    """

    n_sources: int
    n: int
    tau_syn: IntArray
    grid: Grid
    semantics: Semantics
