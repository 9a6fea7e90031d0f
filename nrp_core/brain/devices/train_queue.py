"""Queues of spikes on a time grid, until a simulator takes those of its next window."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.grid import Grid

Train = tuple[list[float], list[float]]
"""Times (ms, ascending) and weights."""


class TrainQueue:
    """Queued spikes by the number of their emitter.

    Args:
        grid: the simulator's time grid.
    """

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._waiting: list[tuple[IntArray, IntArray, FloatArray]] = []

    def put(self, emitters: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Add spikes: numbers of emitters, points of the grid, weights, each of shape ``(n,)``."""
        self._waiting.append((emitters, steps, weights))

    def take(self, until_step: int) -> tuple[IntArray, list[Train]]:
        """Return and remove the spikes up to a grid point: the emitters, ascending, and a train for each."""
        if not self._waiting:
            return np.empty(0, np.int64), []
        emitters, steps, weights = map(np.concatenate, zip(*self._waiting, strict=True))
        later = steps > until_step
        self._waiting = [(emitters[later], steps[later], weights[later])] if later.any() else []
        order = np.lexsort((steps, emitters))
        order = order[~later[order]]
        if not order.size:
            return order, []
        emitters = emitters[order]
        times_ms, sizes = self._grid.time_ms(steps[order]).tolist(), weights[order].tolist()
        first = [0, *(np.flatnonzero(emitters[1:] != emitters[:-1]) + 1).tolist()]
        borders = pairwise([*first, emitters.size])
        return emitters[first], [(times_ms[a:b], sizes[a:b]) for a, b in borders]
