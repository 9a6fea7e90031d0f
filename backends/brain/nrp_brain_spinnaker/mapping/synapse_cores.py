"""Cores for synapses alone, which share a chip with the core of the neurons that they serve.

With a time step of 1 ms and more a core has the time for both; below, the software of the machine gives the
synapses onto each slice of a population cores of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Final

from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.mapping.memory import longest_row
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.synapses.stdp import STDP

_SHARED_FROM_US: Final = 1000
_STATIC_EVENTS_PER_S: Final = 13e6
_PLASTIC_EVENTS_PER_S: Final = 1.4e6
"""What the software plans for one core, wherever a projection onto it is plastic."""


def synapse_cores(onto: Sequence[Wires], options: SpinnakerOptions) -> int:
    """Return how many cores each slice of a population has for its synapses; 0: its neurons' core has them.

    Args:
        onto: the projections onto the population.
        options: the user's.
    """
    if options.step_us >= _SHARED_FROM_US:
        return 0
    plastic = any(part.projection.synapse_type == STDP for part in onto)
    rows = sum(part.n_pre * longest_row(part, options.neurons_per_core) for part in onto)
    return ceil(
        rows * options.spikes_per_second / (_PLASTIC_EVENTS_PER_S if plastic else _STATIC_EVENTS_PER_S)
    )
