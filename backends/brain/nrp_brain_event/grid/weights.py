"""Changed weights of static synapses, and where the tables of the grid hold them.

They are written in place where the tables have room for them: a weight for each synapse, or one for all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from nrp_brain_event.connections import is_share
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.grid.tables import common, load_tables
from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.network.data import Network, Projection
from nrp_core.network.drawing import extremes
from nrp_core.network.grid import Grid as TimeGrid
from nrp_core.network.indices import stored_form

_MOST_NUMBERS: Final = 1 << 24
"""The integers below it are exact in single precision."""
_MARK: Final = 1e300
"""Weights that no synapse has."""


@dataclass(frozen=True)
class Given:
    """The weights that were changed since time 0.

    Args:
        weights: by the label of the projection.
        each: labels of the projections whose weights have differed; their synapses have one each.
    """

    weights: Mapping[str, FloatArray] = field(default_factory=dict)
    each: frozenset[str] = frozenset()

    @classmethod
    def of_saved(cls, saved: Any) -> Given:
        """Return the content of a snapshot: both arguments, or only the weights (version 0.2.0)."""
        if isinstance(saved, tuple):
            return cls(*saved)
        return cls(saved, frozenset(label for label, values in saved.items() if common(values) is None))

    def with_weights(self, label: str, weights: FloatArray) -> Given:
        """Return the weights with those of one more projection."""
        each = self.each if common(weights) is not None else self.each | {label}
        return Given({**self.weights, label: weights}, each)

    def form(self, projection: Projection) -> tuple[bool, bool]:
        """Return whether the tables have a weight for each synapse, or else one for this projection alone."""
        label, is_given = projection.label, projection.label in self.weights
        if is_share(projection) or label in self.each:
            return True, False
        has_each = not is_given and common(extremes(stored_form(projection, "weight"))) is None
        return has_each, is_given and not has_each


class Layout(NamedTuple):
    """Where the tables hold the weights of projections.

    Args:
        each: the place of each synapse among ``weights``, by label.
        whole: the ``tables`` with one weight for all synapses, by label.
    """

    each: Mapping[str, IntArray]
    whole: Mapping[str, IntArray]


def find_layout(
    network: Network, cells: Array, row_of: IntArray, times: TimeGrid, without: frozenset[str], given: Given
) -> Layout | None:
    """Return the places of weights in the tables of a network; None if there are too many to number.

    They are found by tables of the same form whose weights are numbers. The arguments are those of
    :func:`~nrp_brain_event.grid.tables.load_tables`.
    """
    bounds: dict[str, tuple[int, int]] = {}
    numbers: dict[str, FloatArray] = {}
    marks: dict[str, float] = {}
    n = 0
    for projection in network.projections:
        label, size = projection.label, projection.size
        if not size or label in without or projection.is_continuous or projection.is_plastic:
            continue
        has_each, is_alone = given.form(projection)
        if has_each:
            bounds[label] = n, n + size
            numbers[label] = np.arange(n, n + size, dtype=float)
            n += size
        elif is_alone:
            marks[label] = _MARK * (1.0 + len(marks) / len(network.projections))
    if n > _MOST_NUMBERS:
        return None
    marked = {label: np.full(len(given.weights[label]), mark) for label, mark in marks.items()}
    tables = load_tables(network, cells, row_of, times, without, {**numbers, **marked}, frozenset(numbers))
    order = np.argsort(tables["weights"], kind="stable")
    return Layout(
        {label: order[first:last] for label, (first, last) in bounds.items()},
        {label: np.flatnonzero(tables["tables"]["weight"] == mark) for label, mark in marks.items()},
    )


def written(grid: Grid, initial: Grid, layout: Layout, label: str, weights: FloatArray) -> Grid:
    """Return the grid with changed weights, written in place unless they are those at time 0."""
    if grid.weights is initial.weights:
        grid = grid._replace(weights=grid.weights.copy(), tables=grid.tables.copy())
    if label in layout.each:
        grid.weights[layout.each[label]] = weights
    else:
        grid.tables["weight"][layout.whole[label]] = weights[0]
    return grid
