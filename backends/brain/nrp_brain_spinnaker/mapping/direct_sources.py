"""Poisson sources whose spikes reach one population through the memory of a chip, without a routing key.

The software has such a core for each core of neurons, on the same chip, if the target has synapse-only cores,
and the source has no other projection.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.host.wiring import Wires, sending
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.synapses import STATIC

_POISSON = "SpikeSourcePoisson"


def possible_sources(network: Network, onto: Sequence[Wires], step_us: int) -> list[Wires]:
    """Return the projections onto a population that need no routing if it has synapse-only cores."""
    outgoing = Counter(one.pre for one in sending(network))
    return [
        part for part in onto if outgoing[part.projection.pre] == 1 and _is_direct(network, part, step_us)
    ]


def _is_direct(network: Network, part: Wires, step_us: int) -> bool:
    projection = part.projection
    return (
        network.populations[projection.pre].cell_type == _POISSON
        and part.n_pre == part.post_last - part.post_first
        and projection.origin.connector == "OneToOneConnector"
        and projection.synapse_type == STATIC
        and projection.rewiring is None
        and projection.origin.delay == step_us / 1000
    )


def has_room(network: Network, onto: Sequence[Wires], synapse_cores: int) -> bool:
    """Return whether a chip has room for the cores of all Poisson sources of a population."""
    return n_poisson(network, onto) + synapse_cores + 1 < hardware.CORES_PER_CHIP - 1


def n_poisson(network: Network, onto: Sequence[Wires]) -> int:
    """Return the number of projections from Poisson sources."""
    return sum(network.populations[part.projection.pre].cell_type == _POISSON for part in onto)
