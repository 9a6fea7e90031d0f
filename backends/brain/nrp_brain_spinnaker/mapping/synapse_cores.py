"""Synapse-only cores, on the same chip as the core of their neurons.

With a time step of 1 ms or more a core has time for both; with a shorter one the software uses separate cores
for the synapses onto each slice of a population.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Final

from nrp_brain_spinnaker.hardware import SYNAPSE_CORES
from nrp_brain_spinnaker.hints import Hints
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.mapping.memory import longest_row
from nrp_core.brain.network.synapses import STDP

_SHARED_FROM_US: Final = 1000
_STATIC_EVENTS_PER_S: Final = 13e6
_PLASTIC_EVENTS_PER_S: Final = 1.4e6
"""The software's limits for one core with a plastic projection."""


def synapse_cores(
    onto: Sequence[Wires], hints: Hints, *, direct: Sequence[Wires], n_poisson: int, alone: bool = False
) -> int:
    """Return the number of synapse-only cores of each slice of a population.

    Args:
        onto: the projections onto the population.
        hints: the hints of the population.
        direct: those of them that may pass such a core by.
        n_poisson: the number of them that come from Poisson sources.
        alone: whether its synapses need such a core, as with rewards.
    """
    options = hints.options
    if hints.synapse_cores is not None:
        return hints.synapse_cores
    if any(part.projection.rewiring is not None for part in onto):
        return 1  # the software has them on one such core only
    if options.step_us >= _SHARED_FROM_US and not alone:
        return 0
    plastic = any(part.projection.synapse_type == STDP for part in onto)
    limit = _PLASTIC_EVENTS_PER_S if plastic else _STATIC_EVENTS_PER_S

    def needed(parts: Sequence[Wires]) -> int:
        rows = sum(part.n_pre * longest_row(part, options.neurons_per_core) for part in parts)
        return ceil(rows * options.spikes_per_second / limit)

    cores = needed([part for part in onto if part not in direct])
    if cores + n_poisson >= SYNAPSE_CORES:  # no room for sources of their own
        cores = needed(onto)
    return max(cores, 1) if alone else cores
