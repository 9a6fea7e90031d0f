"""Edges of a connectome as they are read: one for each pair of cells, in 8 bytes, however often listed."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray

PART: Final = 1 << 20
"""Edges handled at a time."""


class Sums:
    """The synapses from cell to cell, sorted by source, then target.

    New edges are inserted where they belong. The arrays grow in place and are never held twice.

    Attributes:
        degrees: number of edges of each source, shape ``(n_cells,)``.
        post: the target of each edge, 32 bits.
        count: its number of synapses, 32 bits: whole numbers are exact up to 16 million.
    """

    def __init__(self, n_cells: int) -> None:
        self._n = n_cells
        self.degrees = np.zeros(n_cells, np.int64)
        self.post = np.empty(0, np.int32)
        self.count = np.empty(0, np.float32)

    def __len__(self) -> int:
        return len(self.post)

    def add(self, keys: IntArray, counts: FloatArray) -> None:
        """Add edges in any order; the synapses of a pair that is known already are added to its own.

        Args:
            keys: ``source * n_cells + target`` of each.
            counts: synapses of each.
        """
        if not len(keys):
            return
        order = np.argsort(keys, kind="stable")
        keys = keys[order]
        counts = counts[order]
        del order
        first = np.flatnonzero(np.diff(keys, prepend=-1))
        keys, counts = keys[first], np.add.reduceat(counts, first, dtype=float)
        is_new = self._added(keys, counts)
        self._insert(keys[is_new], counts[is_new])

    def only(self, sources: BoolArray) -> Sums:
        """Return the edges of the chosen sources."""
        chosen, mine = Sums(self._n), np.repeat(sources, self.degrees)
        chosen.degrees = np.where(sources, self.degrees, 0)
        chosen.post, chosen.count = self.post[mine], self.count[mine]
        return chosen

    def _added(self, keys: IntArray, counts: FloatArray) -> BoolArray:
        """Add the synapses of known pairs; return which pairs are new. The keys ascend."""
        is_new = np.ones(len(keys), bool)
        for low, high, first, last in self._parts():
            known = self._keys(low, high, first, last)
            mine = slice(*np.searchsorted(keys, (low * self._n, high * self._n)))
            place = np.searchsorted(known, keys[mine])
            place[place == len(known)] = 0
            found = known[place] == keys[mine]
            self.count[first + place[found]] += counts[mine][found]
            is_new[mine] = ~found
        return is_new

    def _insert(self, keys: IntArray, counts: FloatArray) -> None:
        """Insert new pairs, the last ones first, so that nothing is overwritten before it is moved."""
        parts = self._parts() or [(0, self._n, 0, 0)]
        self.post.resize(len(self) + len(keys), refcheck=False)
        self.count.resize(len(self.post), refcheck=False)
        bounds = np.searchsorted(keys, [low * self._n for low, *_ in parts] + [self._n**2])
        for (low, high, first, last), (begin, end) in reversed([*zip(parts, pairwise(bounds), strict=True)]):
            new = slice(begin, end)
            place = np.searchsorted(self._keys(low, high, first, last), keys[new])
            target = slice(first + begin, last + end)
            self.post[target] = np.insert(self.post[first:last], place, keys[new] % self._n)
            self.count[target] = np.insert(self.count[first:last], place, counts[new])
        self.degrees += np.bincount(keys // self._n, minlength=self._n)

    def _parts(self) -> list[tuple[int, int, int, int]]:
        """Return ranges of sources with about as many edges each: first and last source and edge."""
        begins = np.append(0, np.cumsum(self.degrees))
        bounds = np.searchsorted(begins, np.arange(0, len(self), PART), "right") - 1
        cells = np.unique(np.append(bounds, self._n)) if len(self) else np.empty(0, int)
        if len(cells):
            cells[0] = 0
        edges = begins[cells]
        return [*zip(*(one.tolist() for one in (cells[:-1], cells[1:], edges[:-1], edges[1:])), strict=True)]

    def _keys(self, low: int, high: int, first: int, last: int) -> IntArray:
        sources: IntArray = np.repeat(np.arange(low, high), self.degrees[low:high])
        return sources * self._n + self.post[first:last]
