"""The names and values that parameters and variables of a script have in networks."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pyNN.parameters import ArrayParameter, Sequence

from nrp_core.errors import NetworkError


def own_name(name: str) -> str:
    """Return the name in networks, without the dot of those of receptors (``AMPA.gsyn``)."""
    return name.replace(".", "_")


def columns_of(owner: str, kind: Any, parameters: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield evaluated parameters of cells by name; one with several values a cell is divided into columns.

    Args:
        owner: the population, for the message.
        kind: the cell type.
        parameters: the values of each parameter.

    Raises:
        NetworkError: a cell has another number of values than its type.
    """
    for name, values in parameters.items():
        n = _length(kind, name)
        if not n:
            yield name, values
            continue
        rows = [np.atleast_1d(one.value) for one in np.atleast_1d(np.asarray(values, dtype=object))]
        wrong = next((len(row) for row in rows if len(row) != n), n)
        if wrong != n:
            raise NetworkError(f"{owner}: {name} has {wrong} values; it must have {n}")
        for k, column in enumerate(np.array(rows, dtype=float).T):
            yield f"{name}_{k}", column


def values_of(name: str, kind: Any, arrays: Mapping[str, Any]) -> Any:
    """Return a parameter of each cell as the script knows it, from the arrays by names in networks."""
    n = _length(kind, name)
    if not n:
        return arrays[own_name(name)]
    rows = zip(*(arrays[f"{name}_{k}"] for k in range(n)), strict=True)
    found = np.empty(len(arrays[f"{name}_0"]), dtype=object)
    found[:] = [ArrayParameter(row) for row in rows]
    return found


def _length(kind: Any, name: str) -> int:
    """Return how many values of a parameter each cell has; 0 for a number, or a sequence of any length."""
    default = kind.default_parameters.get(name)
    several = isinstance(default, ArrayParameter) and not isinstance(default, Sequence)
    return len(default.value) if several else 0
