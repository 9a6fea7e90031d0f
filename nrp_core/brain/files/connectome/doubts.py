"""Tables of edges that can be read, and whose numbers are probably not numbers of synapses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from nrp_core.brain.network.data import Network, Projection

_ROUNDED: Final = 1e-3
_LARGE: Final = 0.5
"""The share of edges from a neuron to itself that no nervous system has."""
_REPEATED: Final = 0.1
"""The share of edges that are equal to another one; more than in a table with a row for each neuropil."""


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
    most = _REPEATED * len(counts)
    is_likely = sum(map(_repeated_pairs, network.projections)) > most  # a third of the time for millions
    repeated = sum(map(_repeats, network.projections)) if is_likely else 0
    if repeated > most:
        yield f"{repeated} of {len(counts)} edges repeat another one, with the same number of synapses"
    selves = sum(
        int((np.asarray(one.pre_index) == np.asarray(one.post_index)).sum()) for one in network.projections
    )
    if selves > _LARGE * len(counts):
        yield f"{selves} of {len(counts)} edges join a neuron with itself"


def _repeated_pairs(edges: Projection) -> int:
    """Return how many edges join the same neurons as another one."""
    pairs = edges.pre_index * (np.int64(edges.post_index.max(initial=0)) + 1) + edges.post_index
    pairs.sort()
    return int(np.count_nonzero(pairs[1:] == pairs[:-1]))


def _repeats(edges: Projection) -> int:
    """Return how many edges are equal to another one."""
    order = np.lexsort((edges.weight, edges.post_index, edges.pre_index))
    columns = (np.asarray(one)[order] for one in (edges.pre_index, edges.post_index, edges.weight))
    return int(np.logical_and.reduce([one[1:] == one[:-1] for one in columns]).sum())
