"""Tables of edges: source, target, number of synapses, sign. Cells have numbers or names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_formats.connectome import matrices
from nrp_formats.connectome.signs import LEFT_OUT, Signs
from nrp_formats.connectome.tables import (
    TEXT_SUFFIXES,
    Columns,
    TextColumn,
    chosen_column,
    column_ids,
    column_names,
    column_numbers,
    column_texts,
    read_rows,
)

PRE: Final = (
    "pre", "Presynaptic_ID", "pre_root_id", "pre_pt_root_id", "body_pre", "bodyId_pre", "source", "Source",
    "Neuron 1",
)  # fmt: skip
POST: Final = (
    "post", "Postsynaptic_ID", "post_root_id", "post_pt_root_id", "body_post", "bodyId_post", "target",
    "Target", "Neuron 2",
)  # fmt: skip
WEIGHT: Final = (
    "Excitatory x Connectivity", "weight", "syn_count", "synapses", "Connectivity", "Weight", "Nbr",
)  # fmt: skip
SINGLE: Final = ("cleft_score", "connection_score")
"""Properties of a synapse; a table with one of these and without numbers of synapses has a row for each."""
_PRODUCT, _UNSIGNED, _SIGN = "Excitatory x Connectivity", "Connectivity", "Excitatory"
"""Columns of Shiu's tables: the first is the product of the others."""
TRANSMITTER: Final = ("nt_type", "nt", "neurotransmitter", "transmitter", "predicted_nt", "top_nt")
"""Columns in the order of preference: plain, of Shiu's tables of FlyWire, FlyWire's own, MaleCNS's."""
PROBABLE: Final = {f"{nt}_avg": nt for nt in ("gaba", "ach", "glut", "oct", "ser", "da")}
"""FlyWire's mean probabilities of the transmitters of an edge; the most probable one counts."""
KIND: Final = ("type", "Type", "synapse_type")
ELECTRICAL: Final = frozenset({"electrical", "gap junction", "gap_junction", "gapjunction", "gap", "ej"})
RECEIVED: Final = frozenset({"r", "rp", "receive", "receive_joint"})
"""Kinds in WormAtlas's tables of rows that repeat a chemical synapse, as its target has it."""


@dataclass(frozen=True)
class EdgeChunk:
    """Some edges.

    Args:
        pre, post: ids of both cells, shape ``(n,)``.
        count: number of synapses, or of gap junctions, shape ``(n,)``.
        sign: 1, -1, or 0 where it is unknown, shape ``(n,)``.
        is_electrical: whether they are gap junctions, shape ``(n,)``.
        names: the names of cells by id, if the table has names.
        is_plain: whether signs are those of the counts; positive ones excite if any is negative.
        empty: number of rows left out because an id or weight is empty.
        transmitters: unknown transmitters, with their numbers of edges.
    """

    pre: IntArray
    post: IntArray
    count: FloatArray
    sign: IntArray
    is_electrical: BoolArray
    names: Mapping[int, str] = field(default_factory=dict)
    is_plain: bool = False
    empty: int = 0
    transmitters: Counter[str] = field(default_factory=Counter)


def read_edges(path: Path, signs: Signs | None = None) -> Iterator[EdgeChunk]:
    """Yield the edges of a table, some at a time.

    Args:
        path: the table: a list of edges, a matrix of names, or a file of cect.
        signs: the signs of transmitters; by default the known ones.

    Raises:
        NetworkError: a column is missing or a value invalid; the message names both.
    """
    signs = signs or Signs()
    if path.suffix.lower() == ".json":
        for layer, found in matrices.read_cect(path):
            sign, is_electrical = signs.of_transmitter(layer), layer == matrices.JUNCTIONS
            if is_electrical or sign != LEFT_OUT:
                yield _of_matrix(found, sign, is_electrical=is_electrical)
        return
    names = column_names(path)
    has_ends = any(name in names for name in PRE) and any(name in names for name in POST)
    if not has_ends and path.suffix.lower() in TEXT_SUFFIXES and (matrix := matrices.read_matrix(path)):
        yield _of_matrix(matrix, None, is_electrical=False)
        return
    layout = _Layout.of(path, names)
    for rows in read_rows(path, layout.columns):
        yield layout.chunk(rows, signs)


def _of_matrix(found: matrices.Matrix, sign: int | None, *, is_electrical: bool) -> EdgeChunk:
    n, count = len(found.count), np.abs(found.count)
    given = np.where(found.count < 0, -1, 0) if sign is None else np.full(n, sign)
    kinds = np.full(n, is_electrical)
    return EdgeChunk(found.pre, found.post, count, given, kinds, found.names, is_plain=sign is None)


@dataclass(frozen=True)
class _Layout:
    """The columns of a list of edges.

    Args:
        path: the table.
        pre, post: columns of the ids.
        weight: column of the number of synapses; None if each row is a synapse.
        sign: column of signs, if any.
        transmitter: column of the transmitter, if any.
        kind: column that marks gap junctions, if any.
        probable: columns of the probabilities of transmitters, if there is no column of the transmitter.
    """

    path: Path
    pre: str
    post: str
    weight: str | None
    sign: str | None
    transmitter: str | None
    kind: str | None
    probable: Sequence[str]

    @classmethod
    def of(cls, path: Path, names: Sequence[str]) -> _Layout:
        pre = chosen_column(path, "the source of an edge", PRE, names)
        post = chosen_column(path, "the target of an edge", POST, names)
        are_single = not any(name in names for name in WEIGHT) and any(name in names for name in SINGLE)
        weight = None if are_single else chosen_column(path, "the number of synapses", WEIGHT, names)
        sign = _SIGN if weight == _UNSIGNED and _SIGN in names else None
        transmitter, kind = (next((n for n in known if n in names), None) for known in (TRANSMITTER, KIND))
        probable = () if transmitter else [name for name in PROBABLE if name in names]
        return cls(path, pre, post, weight, sign, transmitter, kind, probable)

    @property
    def columns(self) -> list[str]:
        others = (self.weight, self.sign, self.transmitter, self.kind, *self.probable)
        return [self.pre, self.post, *filter(None, others)]

    def chunk(self, rows: Columns, signs: Signs) -> EdgeChunk:
        """Return the edges of some rows."""
        (pre, has_pre, ours), (post, has_post, theirs) = (
            column_ids(self.path, end, rows[end]) for end in (self.pre, self.post)
        )
        count = (
            column_numbers(self.path, self.weight, rows[self.weight]) if self.weight else np.ones(len(pre))
        )
        if np.isinf(count).any():
            raise NetworkError(f"the column '{self.weight}' holds an infinite number", path=self.path)
        kinds = self._kinds(rows, len(pre))
        sign, unknown = self._signs(rows, signs, count, kinds)
        filled = has_pre & has_post & np.isfinite(count)
        is_electrical = np.isin(kinds, list(ELECTRICAL))
        kept = filled & ~np.isin(kinds, list(RECEIVED)) & (is_electrical | (sign != LEFT_OUT))
        return EdgeChunk(
            pre[kept], post[kept], np.abs(count[kept]), sign[kept], is_electrical[kept], {**ours, **theirs},
            self._is_plain, int((~filled).sum()), unknown,
        )  # fmt: skip

    @property
    def _is_plain(self) -> bool:
        """Whether only the numbers of synapses can have a sign."""
        return not (self.sign or self.transmitter or self.probable)

    def _kinds(self, rows: Columns, n: int) -> np.ndarray:
        if self.kind is None:
            return np.zeros(n, "U1")
        return np.array([text.lower() for text in column_texts(rows[self.kind])] or [""])[:n]

    def _signs(
        self, rows: Columns, signs: Signs, count: FloatArray, kinds: np.ndarray
    ) -> tuple[IntArray, Counter[str]]:
        """Return the signs of the edges, and the texts of unknown transmitters with their numbers."""
        if self._is_plain:
            rest = 1 if self.weight == _PRODUCT else 0
            return np.where(count < 0, -1, rest), Counter()
        if (count < 0).any():
            raise NetworkError(
                f"the column '{self.weight}' holds {np.nanmin(count):g}, and another column says the signs "
                "already",
                path=self.path,
            )
        if self.sign:
            given = np.nan_to_num(np.sign(column_numbers(self.path, self.sign, rows[self.sign])))
            return given.astype(np.int64), Counter()
        column = self._transmitters(rows)
        known = np.array([signs.of_transmitter(text) for text in column.texts], np.int64)
        found = known[column.codes]
        chemical = ~np.isin(kinds, list(ELECTRICAL))
        numbers = np.bincount(column.codes[(found == 0) & chemical], minlength=len(column.texts))
        return found, Counter({text: int(n) for text, n in zip(column.texts, numbers, strict=True) if n})

    def _transmitters(self, rows: Columns) -> TextColumn:
        if self.transmitter:
            column = rows[self.transmitter]
            return column if isinstance(column, TextColumn) else TextColumn.of(column_texts(column))
        shares = np.stack([column_numbers(self.path, name, rows[name]) for name in self.probable], axis=1)
        shares = np.nan_to_num(shares, nan=0.0)
        best = np.where(shares.max(axis=1) > 0.0, shares.argmax(axis=1), len(self.probable))
        return TextColumn([*(PROBABLE[name] for name in self.probable), ""], best)
