"""The edges of a table between known neurons, in memory for the pairs of neurons, not for the rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray, Projection
from nrp_core.network.indices import Indices
from nrp_core.network.synapses import ELECTRICAL
from nrp_formats.connectome.edges import EdgeChunk

MIX: Final = np.uint64(0x9E3779B97F4A7C15)
"""Multiplication by the golden ratio spreads numbers over all those of 64 bits (Knuth)."""
_SLOTS: Final = 8
"""Slots of the table for each id; one id in 16 shares its slot and is searched for."""


class Places:
    """A hash table of unique ids."""

    def __init__(self, ids: IntArray) -> None:
        self._order = np.argsort(ids, kind="stable")
        self._ids, self._ranked = ids, ids[self._order]
        bits = max(int(_SLOTS * len(ids)).bit_length(), 1)
        self._shift = np.uint64(64 - bits)
        self._table = np.zeros(1 << bits, np.int32)
        self._table[self._slots(ids)] = np.arange(len(ids))

    def of(self, ids: IntArray) -> tuple[IntArray, BoolArray]:
        """Return the index of each id, and whether it is known; the index of an unknown id is undefined."""
        if not len(self._ids):
            return np.zeros(len(ids), np.int64), np.zeros(len(ids), bool)
        places = self._table[self._slots(ids)].astype(np.int64)
        found = self._ids[places] == ids
        if not found.all():
            others = np.flatnonzero(~found)
            rank = np.searchsorted(self._ranked, ids[others])
            rank[rank == len(self._ids)] = 0
            places[others] = self._order[rank]
            found[others] = self._ranked[rank] == ids[others]
        return places, found

    def _slots(self, ids: IntArray) -> IntArray:
        return (ids.astype(np.uint64) * MIX >> self._shift).astype(np.int64)


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

    def parts(self) -> Iterator[tuple[IntArray, FloatArray]]:
        """Yield the edges as :meth:`add` takes them, some at a time."""
        for low, high, first, last in self._parts():
            yield self._keys(low, high, first, last), self.count[first:last].astype(float)

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


FEWEST: Final = 1 << 21
"""Rows read before they are summed; of large tables an eighth of the edges so far, which bounds both the time
and the memory."""


@dataclass
class Wiring:
    """The edges between neurons.

    Args:
        n_cells: number of neurons.
        rows: number of rows between known neurons.
        left_out, empty: number of rows that are not used, as in
            :class:`~nrp_formats.connectome.network.Connectome`.
        self_junctions: number of gap junctions of a cell with itself; see :meth:`junctions`.
    """

    n_cells: int
    rows: int = 0
    left_out: int = 0
    empty: int = 0
    self_junctions: int = 0

    def __post_init__(self) -> None:
        self.excitatory, self.inhibitory, self.unknown, self.electrical = (
            Sums(self.n_cells) for _ in range(4)
        )
        self.transmitters: Counter[str] = Counter()
        self._waiting: list[tuple[IntArray, Any, Any]] = []
        self._is_plain = True

    def read(self, chunks: Iterable[EdgeChunk], ids: IntArray) -> None:
        """Add the edges between neurons with these ids."""
        places, n_waiting = Places(ids), 0
        for part in chunks:
            keys, inside = self._placed(part, places)
            counts, is_electrical = part.count[inside], part.is_electrical[inside]
            self.left_out += len(part.pre) - len(keys)
            self.rows += len(keys)
            self.empty += part.empty
            self.transmitters += part.transmitters
            self._is_plain &= part.is_plain or bool(is_electrical.all())
            self.electrical.add(keys[is_electrical], counts[is_electrical])
            is_chemical = ~is_electrical
            signs = part.sign[inside].astype(np.int8)
            self._waiting.append(
                (keys[is_chemical], counts[is_chemical].astype(np.float32), signs[is_chemical])
            )
            n_waiting += int(is_chemical.sum())
            if n_waiting >= max(FEWEST, self._n_chemical // 8):
                self._sum_up()
                n_waiting = 0
        self._sum_up()

    def take_signs(self, signs: IntArray) -> None:
        """Give edges of unknown sign the sign of their source, unless the numbers of synapses have signs."""
        is_signed = self._is_plain and len(self.inhibitory) > 0
        self.assign(np.ones(self.n_cells, int) if is_signed else signs)

    def assign(self, signs: IntArray) -> None:
        """Give edges of unknown sign a sign by their source; those of sources with 0 stay unknown."""
        for sums, mine in ((self.excitatory, signs > 0), (self.inhibitory, signs < 0)):
            for keys, counts in self.unknown.only(mine).parts():
                sums.add(keys, counts)
        self.unknown = self.unknown.only(signs == 0)

    @property
    def _n_chemical(self) -> int:
        return sum(map(len, (self.excitatory, self.inhibitory, self.unknown)))

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

    def junctions(self, label: str, unit_us: float) -> Iterator[Projection]:
        """Yield the gap junctions, if any.

        A table has a junction once, or from both cells, and then not always with the same number (of sections
        in which it is seen): the larger is used. One from a cell to itself has no effect and is counted in
        ``self_junctions``.
        """
        pre, post = np.repeat(np.arange(self.n_cells), self.electrical.degrees), self.electrical.post
        keys = np.minimum(pre, post) * self.n_cells + np.maximum(pre, post)
        self.self_junctions = int(((pre == post) & (self.electrical.count > 0.0)).sum())
        pairs, place = np.unique(keys[pre != post], return_inverse=True)
        counts = np.zeros(len(pairs))
        np.maximum.at(counts, place, self.electrical.count[pre != post])
        pairs, counts = pairs[counts > 0.0], counts[counts > 0.0]
        if len(pairs) and unit_us:
            yield Projection(
                ELECTRICAL, label, label, "excitatory", pairs // self.n_cells, pairs % self.n_cells,
                unit_us * counts, np.zeros(len(pairs)), synapse_type=ELECTRICAL,
            )  # fmt: skip

    def _placed(self, part: EdgeChunk, places: Places) -> tuple[IntArray, BoolArray]:
        """Return source times number of neurons plus target of edges between neurons, and which they are."""
        (pre, is_pre), (post, is_post) = places.of(part.pre), places.of(part.post)
        inside = is_pre & is_post
        return (pre * self.n_cells + post)[inside], inside

    def _sum_up(self) -> None:
        """Add the rows that wait to the edges of each sign; rows without synapses vanish."""
        keys, counts, signs = (
            np.concatenate([np.empty(0, kind), *(one[k] for one in self._waiting)])
            for k, kind in enumerate((np.int64, np.float32, np.int8))
        )
        self._waiting.clear()
        for sums, sign in ((self.excitatory, 1), (self.inhibitory, -1), (self.unknown, 0)):
            mine = (signs == sign) & (counts > 0)
            sums.add(keys[mine], counts[mine])
