"""Synapses gathered target by target and joined into flat arrays; equal values share memory."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np
from pyNN.parameters import LazyArray
from pyNN.random import NumpyRNG, RandomDistribution

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core.network.drawing import Drawn, are_drawn_again, whole
from nrp_core.network.indices import Indices, index_type

_DRAWN_AT_ONCE = 2**22
"""Random numbers: 32 MiB."""


class SynapseColumns:
    """Synapses from a connector, column by column of the connection matrix.

    Args:
        n_pre: number of presynaptic cells.
    """

    def __init__(self, n_pre: int) -> None:
        self._type = index_type(n_pre)
        self._pre: list[Any] = []
        self._post: list[Any] = []
        self._values: dict[str, list[Any]] = {}
        self._all: tuple[Indices, Indices, dict[str, Any]] | None = None

    def add(self, pre: Any, post: Any, values: Mapping[str, Any]) -> None:
        """Add synapses.

        Args:
            pre: indices of the presynaptic cells, shape ``(n,)``.
            post: index of the postsynaptic cell; one index, or shape ``(n,)``.
            values: values of every parameter: one number, or shape ``(n,)``.
        """
        self._pre.append(np.asarray(pre, dtype=self._type))
        self._post.append(post)
        for name, value in values.items():
            self._values.setdefault(name, []).append(value)

    def add_all(self, pre: Any, counts: Any, values: Mapping[str, Any]) -> None:
        """Add all synapses at once.

        Args:
            pre: indices of the presynaptic cells in the order of their targets, shape ``(n,)``.
            counts: the number of synapses of each postsynaptic cell.
            values: values of every parameter, shape ``(n,)`` or :class:`Drawn`.
        """
        cells = np.flatnonzero(counts)
        post = Indices.repeated(cells, np.asarray(counts)[cells])
        self._all = Indices.of(np.asarray(pre, self._type)), post, dict(values)

    def joined(self) -> tuple[Indices, Indices, dict[str, Any]]:
        """Return indices and values of all synapses, shape ``(n_synapses,)``; empties the columns."""
        if self._all is not None:
            found, self._all = self._all, None
            return found
        counts = [len(part) for part in self._pre]
        pre = Indices.of(np.concatenate([np.empty(0, self._type), *self._pre]))
        self._pre.clear()
        post = _targets(self._post, counts)
        values = {name: _joined(self._values[name], counts) for name in list(self._values)}
        return pre, post, values


def _targets(parts: list[Any], counts: list[int]) -> Indices:
    if counts and all(np.ndim(part) == 0 for part in parts) and (np.diff(parts) > 0).all():
        return Indices.repeated(parts, counts)
    each = [np.broadcast_to(np.asarray(part, np.int32), n) for part, n in zip(parts, counts, strict=True)]
    return Indices.of(np.concatenate([np.empty(0, np.int32), *each]))


def _joined(parts: list[Any], counts: list[int]) -> FloatArray:
    first = parts[0]
    if all(np.ndim(part) == 0 and part == first for part in parts):
        return constant(first, sum(counts))
    arrays = [np.broadcast_to(np.asarray(part, float), n) for part, n in zip(parts, counts, strict=True)]
    parts.clear()
    return np.concatenate(arrays)


def constant(value: float, size: int) -> FloatArray:
    """Return an array of one repeated value in constant memory."""
    return np.broadcast_to(np.float64(value), (size,))


def is_constant(values: FloatArray) -> bool:
    """Return whether an array was made by :func:`constant`."""
    return values.strides == (0,)


def taken(values: Any, chosen: Any) -> Any:
    """Return ``values[chosen]``; a constant array stays constant, and drawn values if all are chosen."""
    if isinstance(values, Drawn):
        return values if chosen == slice(None) else whole(values)[chosen]
    some: FloatArray = values[chosen]
    return constant(some[0], len(some)) if is_constant(values) and len(some) else some


def drawn_row_by_row(values: LazyArray, pre: IndexArray, post: IndexArray) -> FloatArray:
    """Return the elements of a random matrix at its connections; the whole matrix is drawn.

    Row by row, because PyNN draws in this order for existing synapses.
    """
    n_pre, n_post = values.shape
    drawn, at_once = np.empty(len(pre)), max(1, _DRAWN_AT_ONCE // n_post)
    for first in range(0, n_pre, at_once):
        rows = np.arange(first, min(first + at_once, n_pre))
        mine = np.flatnonzero((pre >= first) & (pre < first + at_once))
        matrix = np.reshape(values.base_value.next(len(rows) * n_post), (len(rows), n_post))
        drawn[mine] = matrix[pre[mine] - first, post[mine]]
    return drawn


def evaluated(values: LazyArray, pre: IndexArray, post: IndexArray) -> FloatArray:
    """Return the elements of a connection matrix at synapses that lie in order of their targets.

    Column by column, because that is the order in which PyNN draws random numbers.
    """
    if values.is_homogeneous:
        return constant(values.evaluate(simplify=True), len(pre))
    columns = SynapseColumns(int(pre.max(initial=0)) + 1)
    starts = np.flatnonzero(np.diff(post, prepend=-1))
    for start, stop in pairwise([*starts, len(post)]):
        columns.add(pre[start:stop], post[start], {"": values[pre[start:stop], int(post[start])]})
    found: FloatArray = columns.joined()[2].get("", np.empty(0))
    return found


_PLAIN = frozenset({"normal", "uniform"})
"""Distributions whose numbers do not depend on how many are drawn at a time."""


def drawn_at_once(space: Any, counts: Any) -> dict[str, Any] | None:
    """Return the values of all synapses by parameter, or None if they must be drawn column by column.

    Args:
        space: PyNN's parameters of the synapses, for the connection matrix.
        counts: the number of synapses of each postsynaptic cell.
    """
    lazy = dict(space.items())
    random = [value for value in lazy.values() if not value.is_homogeneous]
    if any(value.operations or not _is_numpy(value.base_value) for value in random):
        return None
    if len({id(value.base_value.rng.rng) for value in random}) < len(random):
        return None  # they take turns with one generator
    n = int(counts.sum())
    if not n or not all(_is_known(value.base_value, n) for value in random):
        return None
    return {
        name: constant(value.evaluate(simplify=True), n)
        if value.is_homogeneous
        else _drawn(value.base_value, counts, n)
        for name, value in lazy.items()
    }


def _is_numpy(value: Any) -> bool:
    return isinstance(value, RandomDistribution) and isinstance(value.rng, NumpyRNG)


def _is_known(distribution: RandomDistribution, n: int) -> bool:
    return distribution.name in _PLAIN or (distribution.name == "normal_clipped" and are_drawn_again(n))


def _drawn(distribution: RandomDistribution, counts: Any, n: int) -> Any:
    if distribution.name == "uniform" or not are_drawn_again(n):
        return distribution.next(n)
    of = distribution.parameters
    limits = of.get("low", -inf), of.get("high", inf)
    return Drawn.by(distribution.rng.rng, (of["mu"], of["sigma"], *limits), counts)
