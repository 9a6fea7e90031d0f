"""NEST's functions about nodes with positions, such as ``GetPosition`` and ``GetTargetNodes``."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import NetworkError
from nrp_pynest.connections import synapses_between
from nrp_pynest.kernel import Kernel, Nodes
from nrp_pynest.spatial import Mask, inside

# ruff: noqa: N802 - the names of NEST


class SpatialFunctions:
    """The functions about nodes with positions.

    Args:
        made: the kernel.
    """

    def __init__(self, made: Kernel) -> None:
        self._made = made

    def _positions(self, nodes: Any) -> FloatArray:
        found = self._made.positions_of(list(map(int, nodes)))
        if found is None:
            raise NetworkError("nest: these nodes have no positions: nest.Create(..., positions=...)")
        return found

    def GetPosition(self, nodes: Any) -> Any:
        """Return the position of one node, or a list of positions."""
        found = [tuple(one) for one in self._positions(nodes).tolist()]
        return found[0] if len(found) == 1 else found

    def _ways(self, start: Any, end: Any) -> FloatArray:
        """Return the way from each of some nodes to each of others; one node or place is paired with all."""
        first, last = (
            np.atleast_2d(one) if isinstance(one, (list, np.ndarray)) else self._positions(one)
            for one in (start, end)
        )
        layer = self._made.group_of(int(end[0])).layer
        assert layer is not None
        return layer.displacement(*np.broadcast_arrays(first, last))

    def Displacement(self, from_arg: Any, to_arg: Any) -> list[tuple[float, ...]]:
        """Return the way from nodes or places to nodes."""
        return [tuple(one) for one in self._ways(from_arg, to_arg).tolist()]

    def Distance(self, from_arg: Any, to_arg: Any) -> list[float]:
        """Return the distance between nodes or places and nodes."""
        return np.sqrt((self._ways(from_arg, to_arg) ** 2).sum(axis=1)).tolist()  # type: ignore[no-any-return]

    def FindCenterElement(self, layer: Any) -> Any:
        """Return the node nearest to the center of a layer."""
        found = self._made.group_of(int(layer[0])).layer
        assert found is not None
        return self.FindNearestElement(layer, found.center.tolist())

    def FindNearestElement(self, layer: Any, locations: Any, find_all: bool = False) -> Any:
        """Return the node nearest to a place, or to each of several places."""
        if np.ndim(locations) > 1:
            return [self.FindNearestElement(layer, one, find_all) for one in locations]
        ways = self._ways(list(locations), layer)
        squares = np.round((ways**2).sum(axis=1), 12)
        nearest = np.flatnonzero(squares == squares.min())
        return layer[nearest] if find_all else layer[int(nearest[0]) : int(nearest[0]) + 1]

    def SelectNodesByMask(self, layer: Any, anchor: Any, mask_obj: Mask) -> Nodes:
        """Return the nodes within a mask around a place."""
        return layer[np.flatnonzero(inside(mask_obj, self._ways(list(anchor), layer)))]  # type: ignore[no-any-return]

    def _partners(self, nodes: Any, layer: Any, model: str | None, *, targets: bool) -> list[Nodes]:
        found = []
        for node in nodes:
            sources, others = ([node], layer) if targets else (layer, [node])
            between = synapses_between(self._made, sources, others, model)
            every = between.get("target" if targets else "source") if len(between) else []
            found.append(Nodes.of(self._made, sorted(set(np.atleast_1d(every).tolist()))))
        return found

    def GetTargetNodes(self, sources: Any, tgt_layer: Any, syn_model: str | None = None) -> list[Nodes]:
        """Return the targets of each source in a layer."""
        return self._partners(sources, tgt_layer, syn_model, targets=True)

    def GetSourceNodes(self, src_layer: Any, targets: Any, syn_model: str | None = None) -> list[Nodes]:
        """Return the sources of each target in a layer."""
        return self._partners(targets, src_layer, syn_model, targets=False)

    def GetTargetPositions(self, sources: Any, tgt_layer: Any, syn_model: str | None = None) -> list[Any]:
        """Return the positions of the targets of each source in a layer."""
        return [self._listed(one) for one in self.GetTargetNodes(sources, tgt_layer, syn_model)]

    def GetSourcePositions(self, src_layer: Any, targets: Any, syn_model: str | None = None) -> list[Any]:
        """Return the positions of the sources of each target in a layer."""
        return [self._listed(one) for one in self.GetSourceNodes(src_layer, targets, syn_model)]

    def _listed(self, nodes: Nodes) -> list[tuple[float, ...]]:
        return [tuple(one) for one in self._positions(nodes).tolist()] if len(nodes) else []
