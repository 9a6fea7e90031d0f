"""The synapses of a script's projections in the network that runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network
from nrp_core.brain.pynn.populations import ids_of, parts_of
from nrp_core.brain.pynn.simulator import State

Shares = Mapping[Any, list[str]]


def shares_of(state: State, network: Network) -> Shares:
    """Return the labels of the network's projections that each projection of a script became.

    A projection between assemblies becomes one for each pair of populations.
    """
    parts = iter(network.projections)
    return {
        projection: [
            part.label for part in islice(parts, len(_owners(projection.pre)) * len(_owners(projection.post)))
        ]
        for projection in state.projections
    }


def synapses_in(network: Network, shares: Shares, projection: Any) -> Iterator[tuple[str, Any]]:
    """Yield the label of each share of a script's projection, and the index of its synapses in that."""
    labels = shares[projection]
    if len(labels) == 1:  # all of them; a list of these would be larger than the network
        yield labels[0], slice(None)
        return
    pre, post = ids_of(projection.pre)[projection.pre_index], ids_of(projection.post)[projection.post_index]
    parts = {part.label: part for part in network.projections}
    for label in labels:
        part = parts[label]
        yield label, np.flatnonzero(_of(network, part.pre, pre) & _of(network, part.post, post))


def _owners(cells: Any) -> set[Any]:
    return {part._owner() for part in parts_of(cells)}


def _of(network: Network, label: str, ids: IntArray) -> npt.NDArray[np.bool_]:
    first = network.offsets[label]
    inside: npt.NDArray[np.bool_] = (ids >= first) & (ids < first + network.populations[label].size)
    return inside
