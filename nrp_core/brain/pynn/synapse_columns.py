"""Synapses gathered target by target and joined into flat arrays; equal values share memory."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from pyNN.parameters import LazyArray

from nrp_core.brain.network import FloatArray, IndexArray


class SynapseColumns:
    """What a connector adds, column by column of the connection matrix."""

    def __init__(self) -> None:
        self._pre: list[IndexArray] = []
        self._post: list[IndexArray | int] = []
        self._values: dict[str, list[Any]] = {}

    def add(self, pre: Any, post: Any, values: Mapping[str, Any]) -> None:
        """Add synapses.

        Args:
            pre: indices of the presynaptic cells, shape ``(n,)``.
            post: index of the one postsynaptic cell, or of each, shape ``(n,)``.
            values: of every parameter, one number or ``n``.
        """
        self._pre.append(np.asarray(pre, dtype=np.int32))
        self._post.append(post)
        for name, value in values.items():
            self._values.setdefault(name, []).append(value)

    def joined(self) -> tuple[IndexArray, IndexArray, dict[str, FloatArray]]:
        """Return indices and values of all synapses, shape ``(n_synapses,)``; empties the columns."""
        counts = [len(part) for part in self._pre]
        pre = np.concatenate([np.empty(0, np.int32), *self._pre])
        self._pre.clear()
        posts = [
            np.broadcast_to(np.asarray(part, np.int32), n) for part, n in zip(self._post, counts, strict=True)
        ]
        post = np.concatenate([np.empty(0, np.int32), *posts])
        values = {name: _joined(self._values[name], counts) for name in list(self._values)}
        return pre, post, values


def _joined(parts: list[Any], counts: list[int]) -> FloatArray:
    first = parts[0]
    if all(np.ndim(part) == 0 and part == first for part in parts):
        return constant(first, sum(counts))
    arrays = [np.broadcast_to(np.asarray(part, float), n) for part, n in zip(parts, counts, strict=True)]
    parts.clear()
    return np.concatenate(arrays)


def constant(value: float, size: int) -> FloatArray:
    """Return an array of one value that takes no memory for its size."""
    return np.broadcast_to(np.float64(value), (size,))


def is_constant(values: FloatArray) -> bool:
    """Return whether an array was made by :func:`constant`."""
    return values.strides == (0,)


def taken(values: FloatArray, chosen: Any) -> FloatArray:
    """Return ``values[chosen]``, of a constant array a constant one."""
    some: FloatArray = values[chosen]
    return constant(some[0], len(some)) if is_constant(values) and len(some) else some


def evaluated(values: LazyArray, pre: IndexArray, post: IndexArray) -> FloatArray:
    """Return the elements of a connection matrix at synapses that lie in order of their targets.

    Column by column, because that is the order in which PyNN draws random numbers.
    """
    if values.is_homogeneous:
        return constant(values.evaluate(simplify=True), len(pre))
    columns = SynapseColumns()
    starts = np.flatnonzero(np.diff(post, prepend=-1))
    for start, stop in pairwise([*starts, len(post)]):
        columns.add(pre[start:stop], post[start], {"": values[pre[start:stop], int(post[start])]})
    return columns.joined()[2].get("", np.empty(0))
