"""Spike generators of NEST: external spike trains, passed window by window. Importing this loads NEST."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from nest import nestkernel_api
from nrp_core.brain import FloatArray, Grid, IntArray, TrainQueue


class Trains:
    """Spike trains of generators, numbered in the order of addition.

    Args:
        grid: NEST's time grid.
    """

    def __init__(self, grid: Grid) -> None:
        self._queue = TrainQueue(grid)
        self._nodes: Any = None

    def add(self, generators: Any) -> IntArray:
        """Add generators and return their numbers."""
        first = 0 if self._nodes is None else len(self._nodes)
        self._nodes = generators if self._nodes is None else self._nodes + generators
        return np.arange(first, first + len(generators))

    def send(self, numbers: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Add spikes of generators at grid points, which may be after the next window."""
        self._queue.put(numbers, steps, weights)

    def feed(self, until_step: int) -> None:
        """Pass all spikes up to the end of a window to NEST."""
        busy, trains = self._queue.take(until_step)
        if trains:
            nodes = self._nodes if busy.size == len(self._nodes) else self._nodes[busy.tolist()]
            put(nodes, [{"spike_times": times, "spike_weights": weights} for times, weights in trains])


def put(nodes: Any, values: Sequence[Mapping[str, object]]) -> None:
    """Set individual values for each node. NEST's ``set`` first looks up each node, at 6 us a node."""
    nestkernel_api.llapi_set_nc_status(nodes._datum, values)
