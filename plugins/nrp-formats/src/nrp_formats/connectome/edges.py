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

PRE: Final = ("pre", "Presynaptic_ID", "pre_root_id", "pre_pt_root_id", "body_pre", "source", "Source")
POST: Final = ("post", "Postsynaptic_ID", "post_root_id", "post_pt_root_id", "body_post", "target", "Target")
WEIGHT: Final = ("Excitatory x Connectivity", "weight", "syn_count", "synapses", "Connectivity", "Weight")
SINGLE: Final = ("cleft_score", "connection_score")
"""Properties of a synapse; a table with one of these and without numbers of synapses has a row for each."""
_UNSIGNED, _SIGN = "Connectivity", "Excitatory"
"""Columns of Shiu's tables whose product is the first of the weights."""
TRANSMITTER: Final = ("nt_type", "nt", "neurotransmitter", "transmitter", "predicted_nt", "top_nt")
"""Columns in the order of preference: plain, of Shiu's tables of FlyWire, FlyWire's own, MaleCNS's."""
KIND: Final = ("type", "Type", "synapse_type")
ELECTRICAL: Final = frozenset({"electrical", "gap junction", "gap_junction", "gap"})
"""Kinds of edges that are not synapses of a network."""


@dataclass(frozen=True)
class EdgeChunk:
    """Some edges.

    Args:
        pre, post: ids of both cells, shape ``(n,)``.
        weight: signed number of synapses, shape ``(n,)``.
        names: the names of cells by id, if the table has names.
        electrical: number of gap junctions, which are left out.
        are_single: whether each is one synapse, so that a pair of cells has many.
    """

    pre: IntArray
    post: IntArray
    weight: FloatArray
    names: Mapping[int, str] = field(default_factory=dict)
    electrical: int = 0
    are_single: bool = False


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
        if transmitter:
            values = values * _signs(path, transmitter, rows[transmitter])
        chemical = _chemical(rows[kind]) if kind else np.ones(len(values), bool)
        (sources, ours), (targets, theirs) = (ids_of(path, end, rows[end]) for end in (pre, post))
        electrical = int((~chemical).sum())
        yield EdgeChunk(
            sources[chemical], targets[chemical], values[chemical], {**ours, **theirs}, electrical, are_single
        )


def _chemical(values: Any) -> BoolArray:
    kinds = [str(text).strip().lower() for text in values.to_pylist()]
    return np.array([kind not in ELECTRICAL for kind in kinds], bool)


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


def _signs(path: Path, column: str, values: Any) -> FloatArray:
    coded = values.dictionary_encode() if not hasattr(values, "dictionary") else values
    known = [sign_of(text) for text in coded.dictionary.to_pylist()]
    for text, sign in zip(coded.dictionary.to_pylist(), known, strict=True):
        if sign == 0:
            raise NetworkError(
                f"the column '{column}' holds '{text}', a transmitter of unknown sign", path=path
            )
    if coded.null_count:
        raise NetworkError(f"the column '{column}' lacks {coded.null_count} transmitters", path=path)
    signs: FloatArray = np.array(known, float)[coded.indices.to_numpy(zero_copy_only=False)]
    return signs
