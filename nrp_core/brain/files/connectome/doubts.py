"""Tables of edges that can be read, and whose numbers are probably not numbers of synapses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from nrp_core.brain.network.data import Network

_ROUNDED: Final = 1e-3
_LARGE: Final = 0.5
"""The share of edges from a neuron to itself that no nervous system has."""


def doubts_about(network: Network, unit_mv: float) -> Iterator[str]:
    """Yield a sentence for each property of a table of edges that no connectome has.

    Args:
        network: the network that was made of it.
        unit_mv: weight of one synapse in it.
    """
    counts = np.concatenate([np.empty(0), *(np.abs(one.weight) / unit_mv for one in network.projections)])
    broken = np.abs(counts - np.round(counts)) > _ROUNDED * np.maximum(counts, 1.0)
    if broken.any():
        first = counts[np.argmax(broken)]
        yield (
            f"{int(broken.sum())} of {len(counts)} edges have no whole number of synapses, the first "
            f"{first:.3g}: are they shares or weights? A synapse is a weight of --unit-mv"
        )
    selves = sum(
        int((np.asarray(one.pre_index) == np.asarray(one.post_index)).sum()) for one in network.projections
    )
    if selves > _LARGE * len(counts):
        yield f"{selves} of {len(counts)} edges join a neuron with itself"
