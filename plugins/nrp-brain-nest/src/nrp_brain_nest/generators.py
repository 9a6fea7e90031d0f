"""Spike generators: external spike trains, passed to NEST window by window."""

from __future__ import annotations

from typing import Any

import numpy as np
from nrp_core.brain import FloatArray, Grid, IntArray, TrainQueue

from nrp_brain_nest.status import put


class SpikeGenerators:
    """Generators with one spike train each, numbered in the order of creation.

    Args:
        nest: the module.
        grid: NEST's time grid.
        weighted: whether each spike has its own weight.
    """

    def __init__(self, nest: Any, grid: Grid, *, weighted: bool) -> None:
        self._nest, self._weighted = nest, weighted
        self._queue = TrainQueue(grid)
        self._nodes: Any = None
        self._size = 0

    def add(self, n: int) -> tuple[IntArray, IntArray]:
        """Create generators; return their numbers and NEST ids."""
        nodes = self._nest.Create("spike_generator", n)
        self._nodes = nodes if self._nodes is None else self._nodes + nodes
        numbers = np.arange(self._size, self._size + n)
        self._size += n
        return numbers, np.array(nodes.tolist())

    def send(self, numbers: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Add spikes of generators at grid points, which may be after the next window."""
        self._queue.put(numbers, steps, weights)

    def feed(self, until_step: int) -> None:
        """Pass all spikes up to the end of a window to NEST."""
        busy, trains = self._queue.take(until_step)
        if trains:
            names = ("spike_times", "spike_weights")[: 1 + self._weighted]
            nodes = self._nodes if busy.size == self._size else self._nodes[busy.tolist()]
            put(nodes, [dict(zip(names, train, strict=False)) for train in trains])
