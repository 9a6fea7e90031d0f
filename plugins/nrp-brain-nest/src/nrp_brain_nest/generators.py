"""Spike generators: trains from outside, handed to NEST window by window."""

from __future__ import annotations

from typing import Any

import numpy as np
from nrp_core.brain.grid import Grid
from nrp_core.brain.network import FloatArray, IntArray


class SpikeGenerators:
    """Generators with a train each; they are numbered in the order in which they are added.

    Args:
        nest: the module.
        grid: its.
        weighted: whether each spike has a weight of its own.
    """

    def __init__(self, nest: Any, grid: Grid, *, weighted: bool) -> None:
        self._nest, self._grid, self._weighted = nest, grid, weighted
        self._nodes: Any = None
        self._size = 0
        self._waiting: list[tuple[IntArray, IntArray, FloatArray]] = []

    def add(self, n: int) -> tuple[IntArray, IntArray]:
        """Make generators and return their numbers and NEST's ids of them."""
        nodes = self._nest.Create("spike_generator", n)
        self._nodes = nodes if self._nodes is None else self._nodes + nodes
        numbers = np.arange(self._size, self._size + n)
        self._size += n
        return numbers, np.array(nodes.tolist())

    def send(self, numbers: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Let generators emit spikes at grid points; they may lie beyond the window to come."""
        self._waiting.append((numbers, steps, weights))

    def feed(self, until_step: int) -> None:
        """Give NEST everything up to the end of a window."""
        if not self._waiting:
            return
        numbers, steps, weights = map(np.concatenate, zip(*self._waiting, strict=True))
        later = steps > until_step
        self._waiting = [(numbers[later], steps[later], weights[later])] if later.any() else []
        order = np.lexsort((steps, numbers))
        order = order[~later[order]]
        if not order.size:
            return
        numbers, weights = numbers[order], weights[order]
        times_ms = self._grid.time_ms(steps[order])
        busy, first = np.unique(numbers, return_index=True)
        trains = zip(np.split(times_ms, first[1:]), np.split(weights, first[1:]), strict=True)
        self._nodes[busy.tolist()].set(
            [
                {"spike_times": times, "spike_weights": own} if self._weighted else {"spike_times": times}
                for times, own in trains
            ]
        )
