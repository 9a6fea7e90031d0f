"""The properties of a network that the synapses of every law are loaded with."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_brain_spinnaker.host.cells import Grid
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network


@dataclass(frozen=True, slots=True)
class Layout:
    """The properties of a network on the machine.

    Args:
        network: the network.
        options: the options of the user.
        n: number of simulated neurons.
        tau_syn: time constant of the synapse behind each line, s16.15, shape ``(2 n,)``.
        grid: the time step.
    """

    network: Network
    options: SpinnakerOptions
    n: int
    tau_syn: IntArray
    grid: Grid

    @property
    def n_sources(self) -> int:
        """Number of global ids."""
        return self.network.size
