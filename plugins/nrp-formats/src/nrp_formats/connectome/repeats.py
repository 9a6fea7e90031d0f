"""Rows of a table of edges that are there twice, found in a sample of the pairs of cells."""

from __future__ import annotations

from typing import Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray
from nrp_formats.connectome.places import MIX

MOST: Final = 1 << 20
"""Rows kept; of larger tables, a half of the pairs, a quarter, ... are looked at, with all their rows."""


class Repeats:
    """Counts rows with the pair and the number of synapses of another row."""

    def __init__(self) -> None:
        self._halvings = 0
        self._keys = np.empty(0, np.int64)
        self._counts = np.empty(0)

    @property
    def are_exact(self) -> bool:
        """Whether all rows were looked at."""
        return not self._halvings

    def add(self, keys: IntArray, counts: FloatArray) -> None:
        """Add rows: the pair of cells of each as one number, and its synapses."""
        mine = self._chosen(keys)
        self._keys = np.concatenate([self._keys, keys[mine]])
        self._counts = np.concatenate([self._counts, counts[mine]])
        while len(self._keys) > MOST:
            self._halvings += 1
            mine = self._chosen(self._keys)
            self._keys, self._counts = self._keys[mine], self._counts[mine]

    def found(self) -> tuple[int, int]:
        """Return how many of the rows that were looked at repeat another one, and how many there were."""
        order = np.lexsort((self._counts, self._keys))
        keys, counts = self._keys[order], self._counts[order]
        return int(((keys[1:] == keys[:-1]) & (counts[1:] == counts[:-1])).sum()), len(keys)

    def _chosen(self, keys: IntArray) -> slice | BoolArray:
        if not self._halvings:
            return slice(None)
        chosen: BoolArray = keys.astype(np.uint64) * MIX >> np.uint64(64 - self._halvings) == 0
        return chosen
