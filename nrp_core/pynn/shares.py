"""The synapses of a script's projections in the network that runs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network
from nrp_core.brain.pynn.populations import ids_of, parts_of
from nrp_core.brain.pynn.simulator import State


class Shares:
    """The projections of the network that the projections of a script became.

    A projection between assemblies becomes one for each pair of populations.

    Args:
        state: the state of the script.
        network: the network that runs.
    """

    def __init__(self, state: State, network: Network) -> None:
        self._network = network
        parts = iter(network.projections)
        self._parts = {
            projection: list(islice(parts, len(_owners(projection.pre)) * len(_owners(projection.post))))
            for projection in state.projections
        }
        self._found: dict[Any, list[tuple[str, Any]]] = {}

    def __contains__(self, projection: Any) -> bool:
        return projection in self._parts

    def of(self, projection: Any) -> list[tuple[str, Any]]:
        """Return the label of each share of a script's projection, and the index of its synapses in that."""
        if projection not in self._found:
            self._found[projection] = list(self._split(projection))
        return self._found[projection]

    def _split(self, projection: Any) -> Iterator[tuple[str, Any]]:
        parts = self._parts[projection]
        if len(parts) == 1:  # all of them; a list of these would be larger than the network
            yield parts[0].label, slice(None)
            return
        pre = ids_of(projection.pre)[projection.pre_index]
        post = ids_of(projection.post)[projection.post_index]
        for part in parts:
            inside = _of(self._network, part.pre, pre) & _of(self._network, part.post, post)
            yield part.label, np.flatnonzero(inside)


def _owners(cells: Any) -> set[Any]:
    return {part._owner() for part in parts_of(cells)}


def _of(network: Network, label: str, ids: IntArray) -> npt.NDArray[np.bool_]:
    first = network.offsets[label]
    inside: npt.NDArray[np.bool_] = (ids >= first) & (ids < first + network.populations[label].size)
    return inside
