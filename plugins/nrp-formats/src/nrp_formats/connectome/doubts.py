"""Tables of edges that can be read, and whose numbers are probably not numbers of synapses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Network
from nrp_formats.connectome.repeats import Repeats
from nrp_formats.connectome.sums import PART

_ROUNDED: Final = 1e-3
_LARGE: Final = 0.5
"""The share of edges from a neuron to itself that no nervous system has."""
_REPEATED: Final = 0.1
"""The share of edges that are equal to another one; more than in a table with a row for each neuropil."""


def doubts_about(network: Network, unit_mv: float, repeats: Repeats) -> Iterator[str]:
    """Yield a sentence for each property of a table of edges that no connectome has.

    Args:
        network: the network that was made of it.
        unit_mv: weight of one synapse in it.
        repeats: the rows of the table that are there twice.
    """
    n_edges = sum(one.size for one in network.projections)
    broken = [part for part in map(_broken, _counts(network, unit_mv)) if len(part)]
    if broken:
        yield (
            f"{sum(map(len, broken))} of {n_edges} edges have no whole number of synapses, the first "
            f"{broken[0][0]:.3g}: are they shares or weights? A synapse is a weight of --unit-mv"
        )
    repeated, rows = repeats.found()
    if repeated > _REPEATED * rows:
        many = f"{repeated} of {rows}" if repeats.are_exact else f"about {repeated / rows:.0%} of all"
        yield f"{many} edges repeat another one, with the same number of synapses"
    selves = sum(int((pre == post).sum()) for one in network.projections for pre, post in one.pairs())
    if selves > _LARGE * n_edges:
        yield f"{selves} of {n_edges} edges join a neuron with itself"


def _counts(network: Network, unit_mv: float) -> Iterator[FloatArray]:
    """Yield the numbers of synapses of all edges in parts."""
    for one in network.projections:
        for first in range(0, one.size, PART):
            yield np.abs(one.weight[first : first + PART]) / unit_mv


def _broken(counts: FloatArray) -> FloatArray:
    return counts[np.abs(counts - np.round(counts)) > _ROUNDED * np.maximum(counts, 1.0)]
