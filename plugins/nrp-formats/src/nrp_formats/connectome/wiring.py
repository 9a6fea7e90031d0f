"""The edges of a table between known neurons, in memory for the pairs of neurons, not for the rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray, IntArray, Projection
from nrp_core.brain.network.indices import Indices
from nrp_formats.connectome.edges import EdgeChunk, read_edges
from nrp_formats.connectome.places import Places
from nrp_formats.connectome.repeats import Repeats
from nrp_formats.connectome.sums import PART, Sums

FEWEST: Final = 1 << 21
"""Rows read before they are summed; of large tables an eighth of the edges so far, which bounds both the time
and the memory."""


@dataclass
class Wiring:
    """The edges between neurons.

    Args:
        n_cells: number of neurons.
        rows: number of rows between known neurons.
        left_out, electrical: number of rows that are not used, as in
            :class:`~nrp_formats.connectome.network.Connectome`.
        repeats: rows that are there twice.
    """

    n_cells: int
    rows: int = 0
    left_out: int = 0
    electrical: int = 0
    repeats: Repeats = field(default_factory=Repeats)

    def __post_init__(self) -> None:
        self.excitatory, self.inhibitory = Sums(self.n_cells), Sums(self.n_cells)
        self._waiting: list[tuple[IntArray, FloatArray]] = []

    def read(self, path: Path, ids: IntArray) -> None:
        """Read the edges between neurons with these ids.

        Raises:
            NetworkError: as for :func:`~nrp_formats.connectome.edges.read_edges`.
        """
        places, n_waiting = Places(ids), 0
        for part in read_edges(path):
            keys, counts = self._placed(part, places)
            self.electrical += part.electrical
            self.left_out += len(part.pre) - len(keys)
            self.rows += len(keys)
            if not part.are_single:
                self.repeats.add(keys, counts)
            self._waiting.append((keys, counts.astype(np.float32)))
            n_waiting += len(keys)
            if n_waiting >= max(FEWEST, (len(self.excitatory) + len(self.inhibitory)) // 8):
                self._sum_up()
                n_waiting = 0
        self._sum_up()

    def take_signs(self, signs: IntArray) -> int:
        """Take the signs of the edges from their sources if no edge has one; return how many have none."""
        if len(self.inhibitory):
            return 0
        both = self.excitatory
        self.excitatory, self.inhibitory = both.only(signs >= 0), both.only(signs < 0)
        return int(both.degrees[signs == 0].sum())

    def projections(self, label: str, unit_mv: float, delay_ms: float) -> Iterator[Projection]:
        """Yield the edges of each sign, sorted by source and target, and release them."""
        for receptor, sign in (("excitatory", 1.0), ("inhibitory", -1.0)):
            edges: Sums = self.__dict__.pop(receptor)
            if len(edges):
                weight = np.empty(len(edges))
                for first in range(0, len(edges), PART):
                    counts = edges.count[first : first + PART].astype(float)
                    weight[first : first + PART] = (sign * unit_mv * counts).astype(np.float32)
                sources: Any = Indices.repeated(np.arange(self.n_cells), edges.degrees)
                yield Projection(
                    receptor, label, label, receptor, sources, edges.post, weight,
                    np.broadcast_to(delay_ms, len(edges)),
                )  # fmt: skip

    def _placed(self, part: EdgeChunk, places: Places) -> tuple[IntArray, FloatArray]:
        """Return pair (source times number of neurons, plus target) and synapses of edges between neurons."""
        (pre, is_pre), (post, is_post) = places.of(part.pre), places.of(part.post)
        keys, inside = pre * self.n_cells + post, is_pre & is_post
        return keys[inside], part.weight[inside]

    def _sum_up(self) -> None:
        """Add the rows that wait to the edges of each sign; rows without synapses vanish."""
        keys, counts = (np.concatenate([np.empty(0, kind), *(one[k] for one in self._waiting)])
                        for k, kind in enumerate((np.int64, np.float32)))  # fmt: skip
        self._waiting.clear()
        self.excitatory.add(keys[counts > 0], counts[counts > 0])
        self.inhibitory.add(keys[counts < 0], -counts[counts < 0])
