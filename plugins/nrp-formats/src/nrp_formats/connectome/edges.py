"""Tables of edges: source, target, number of synapses, sign. Cells have numbers or names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_formats.connectome.tables import chosen_column, column_names, ids_of, read_rows, sign_of

PRE: Final = (
    "pre", "Presynaptic_ID", "pre_root_id", "pre_pt_root_id", "body_pre", "source", "Source", "Neuron 1",
)  # fmt: skip
POST: Final = (
    "post", "Postsynaptic_ID", "post_root_id", "post_pt_root_id", "body_post", "target", "Target", "Neuron 2",
)  # fmt: skip
WEIGHT: Final = (
    "Excitatory x Connectivity", "weight", "syn_count", "synapses", "Connectivity", "Weight", "Nbr",
)  # fmt: skip
SINGLE: Final = ("cleft_score", "connection_score")
"""Properties of a synapse; a table with one of these and without numbers of synapses has a row for each."""
_UNSIGNED, _SIGN = "Connectivity", "Excitatory"
"""Columns of Shiu's tables whose product is the first of the weights."""
TRANSMITTER: Final = ("nt_type", "nt", "neurotransmitter", "transmitter", "predicted_nt", "top_nt")
"""Columns in the order of preference: plain, of Shiu's tables of FlyWire, FlyWire's own, MaleCNS's."""
KIND: Final = ("type", "Type", "synapse_type")
ELECTRICAL: Final = frozenset({"electrical", "gap junction", "gap_junction", "gapjunction", "gap", "ej"})
RECEIVED: Final = frozenset({"r", "rp", "receive", "receive_joint"})
"""Kinds in WormAtlas's tables of rows that repeat a chemical synapse, as its target has it."""


@dataclass(frozen=True)
class EdgeChunk:
    """Some edges.

    Args:
        pre, post: ids of both cells, shape ``(n,)``.
        weight: signed number of synapses, or number of gap junctions, shape ``(n,)``.
        is_electrical: whether they are gap junctions, shape ``(n,)``.
        names: the names of cells by id, if the table has names.
    """

    pre: IntArray
    post: IntArray
    weight: FloatArray
    is_electrical: BoolArray
    names: Mapping[int, str] = field(default_factory=dict)


def read_edges(path: Path) -> Iterator[EdgeChunk]:
    """Yield the edges of a table, some at a time.

    Raises:
        NetworkError: a column is missing or a value invalid; the message names both.
    """
    names = column_names(path)
    pre = chosen_column(path, "the source of an edge", PRE, names)
    post = chosen_column(path, "the target of an edge", POST, names)
    are_single = not any(name in names for name in WEIGHT) and any(name in names for name in SINGLE)
    weight = None if are_single else chosen_column(path, "the number of synapses", WEIGHT, names)
    transmitter = next((name for name in TRANSMITTER if name in names), None)
    kind = next((name for name in KIND if name in names), None)
    sign = _SIGN if weight == _UNSIGNED and _SIGN in names else None
    used = [pre, post, *filter(None, (weight, transmitter, kind, sign))]
    for rows in read_rows(path, used):
        values = _weights(path, weight, rows[weight]) if weight else np.ones(len(rows[pre]))
        if weight and (sign or transmitter):
            values = _unsigned(path, weight, values)
        if sign:
            values = values * np.sign(_weights(path, sign, rows[sign]))
        kinds = [str(text).strip().lower() for text in rows[kind].to_pylist()] if kind else []
        is_electrical = np.array([one in ELECTRICAL for one in kinds] or np.zeros(len(values)), bool)
        if transmitter:
            signs = _signs(path, transmitter, rows[transmitter], ~is_electrical)
            values = np.where(is_electrical, values, values * signs)
        (sources, ours), (targets, theirs) = (ids_of(path, end, rows[end]) for end in (pre, post))
        kept = np.array([one not in RECEIVED for one in kinds] or np.ones(len(values)), bool)
        yield EdgeChunk(sources[kept], targets[kept], values[kept], is_electrical[kept], {**ours, **theirs})


def _weights(path: Path, column: str, values: Any) -> FloatArray:
    import pyarrow.types as kinds

    if not (kinds.is_integer(values.type) or kinds.is_floating(values.type)):
        raise NetworkError(f"the column '{column}' holds {values.type} values, not numbers", path=path)
    numbers: FloatArray = values.to_numpy(zero_copy_only=False).astype(float)
    if not np.isfinite(numbers).all():
        first = int(np.argmin(np.isfinite(numbers)))
        raise NetworkError(
            f"the column '{column}' holds {numbers[first]}, not a number of synapses", path=path
        )
    return numbers


def _unsigned(path: Path, column: str, values: FloatArray) -> FloatArray:
    if (values < 0.0).any():
        raise NetworkError(
            f"the column '{column}' holds {values.min():g}, and another column says the signs already",
            path=path,
        )
    return values


def _signs(path: Path, column: str, values: Any, is_used: BoolArray) -> FloatArray:
    """Return the signs of the transmitters; those that are not used may be missing or of any name."""
    coded = values.dictionary_encode() if not hasattr(values, "dictionary") else values
    texts = [*coded.dictionary.to_pylist(), None]
    places = coded.indices.fill_null(len(texts) - 1).to_numpy(zero_copy_only=False)
    known = [sign_of(text) for text in texts]
    for place in np.unique(places[is_used]).tolist():
        if texts[place] is None:
            count = int((places[is_used] == place).sum())
            raise NetworkError(f"the column '{column}' lacks {count} transmitters", path=path)
        if known[place] == 0:
            raise NetworkError(
                f"the column '{column}' holds '{texts[place]}', a transmitter of unknown sign", path=path
            )
    signs: FloatArray = np.array(known, float)[places]
    return signs
