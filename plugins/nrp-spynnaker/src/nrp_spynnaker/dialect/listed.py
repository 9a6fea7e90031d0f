"""Weights and delays as lists with a value for each synapse of a connector, in the order of its synapses."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any, Final

import numpy as np
from pyNN.core import IndexBasedExpression
from pyNN.parameters import ParameterSpace

_NAMES: Final = ("weight", "delay")


class _Listed(IndexBasedExpression):
    """The value at a place for each pair of cells.

    Args:
        values: the values.
        row: how many places lie between those of two successive sources.
        column: how many lie between those of two successive targets.
    """

    def __init__(self, values: Any, row: int, column: int) -> None:
        self._values, self._row, self._column = values, row, column

    def __call__(self, i: Any, j: Any) -> Any:
        return self._values[i * self._row + j * self._column]


def one_by_one(synapse_type: Any, connector: Any, ends: Sequence[Any]) -> Any:
    """Return a synapse type whose lists of values are for single synapses, where the connector has an order.

    Args:
        synapse_type: the type that a script gives; None for none.
        connector: from each cell to one, or from each to all, source after source; others are left alone.
        ends: the cells on both sides.
    """
    name = type(connector).__name__
    space = getattr(synapse_type, "parameter_space", None)
    if space is None or name not in ("OneToOneConnector", "AllToAllConnector"):
        return synapse_type
    pre, post = (cells.size for cells in ends)
    count, row, column = (pre, 1, 0) if name == "OneToOneConnector" else (pre * post, post, 1)
    bases = {key: np.asarray(space[key].base_value) for key in _NAMES if key in space.keys()}  # noqa: SIM118
    listed = {
        key: _Listed(base.astype(float), row, column)
        for key, base in bases.items()
        if base.shape == (count,) and base.dtype != object
    }
    if not listed:
        return synapse_type
    made = copy(synapse_type)
    made.parameter_space = ParameterSpace({**dict(space.items()), **listed}, space.schema)
    return made
