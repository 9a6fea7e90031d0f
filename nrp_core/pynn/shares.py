"""The synapses of a script's projections in the network that runs."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network
from nrp_core.brain.pynn.populations import ids_of, parts_of
from nrp_core.brain.pynn.simulator import State

Shares = Mapping[Any, list[tuple[str, IntArray]]]


def shares_of(state: State, network: Network) -> Shares:
    """Return the projections of the network that each projection of a script became.

    A projection between assemblies becomes one for each pair of populations.

    Returns:
        The label of each in the network, and the indices of its synapses in the script's projection.
    """
    parts = iter(network.projections)
    shares = {}
    for projection in state.projections:
        n_parts = len(_owners(projection.pre)) * len(_owners(projection.post))
        pre, post = (
            ids_of(projection.pre)[projection.pre_index],
            ids_of(projection.post)[projection.post_index],
        )
        shares[projection] = [
            (part.label, np.flatnonzero(_of(network, part.pre, pre) & _of(network, part.post, post)))
            for part in islice(parts, n_parts)
        ]
    return shares


def _owners(cells: Any) -> set[Any]:
    return {part._owner() for part in parts_of(cells)}


def _of(network: Network, label: str, ids: IntArray) -> npt.NDArray[np.bool_]:
    first = network.offsets[label]
    inside: npt.NDArray[np.bool_] = (ids >= first) & (ids < first + network.populations[label].size)
    return inside
