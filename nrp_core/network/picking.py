"""Selections of neurons from a circuit, as written in experiment files."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.errors import NeuronSelectionError
from nrp_core.network.data import Network

Selection: TypeAlias = str | int | Sequence[int] | Mapping[str, Any] | None
"""Neurons of a circuit: ``"0:5"``, ``"0:6:2"``, ``5``, ``[0, 2]``, ``{"from": 0, "to": 6, "step": 2}``,
``{"list": [0, 2]}``, or None for all of them; they have the meaning of NumPy indexing."""

CIRCUIT = "circuit"
_BOUNDS = {"from": "start", "to": "stop", "step": "step"}


def with_views(network: Network, populations: Mapping[str, Selection]) -> Network:
    """Return a network with additional views of neurons.

    Args:
        network: the network; its circuit is the view or population ``circuit``, else all neurons.
        populations: selections of cells of the circuit, by name.

    Raises:
        NeuronSelectionError: the circuit has no such cells.
    """
    if not populations:
        return network
    named = CIRCUIT in network.views or CIRCUIT in network.populations
    circuit = network.neurons(CIRCUIT) if named else np.arange(network.size)
    views = {name: select_neurons(name, selection, circuit) for name, selection in populations.items()}
    known = {label: network.neurons(label) for label in (*network.populations, *network.views)}
    remarks = (*network.remarks, *find_shadowed(known, views))
    return replace(network, views={**network.views, **views}, remarks=remarks)


def find_shadowed(known: Mapping[str, IntArray], views: Mapping[str, IntArray]) -> Iterator[str]:
    """Yield a sentence for each selection with the name of other cells, which no function can read then."""
    for name, ids in views.items():
        if name in known and set(known[name].tolist()) != set(ids.tolist()):
            yield (
                f"the population '{name}' of the experiment has {len(ids)} cells and hides that of the "
                f"brain, which has {len(known[name])}: give it another name"
            )


def select_neurons(name: str, selection: Selection, circuit: IntArray) -> IntArray:
    """Return the selected neurons of a circuit (global ids).

    Args:
        name: the name of the selection, for the message.
        selection: the selection.
        circuit: global ids of the circuit.

    Raises:
        NeuronSelectionError: not a valid selection, reaches outside the circuit, or selects no cell.
    """
    size = len(circuit)
    try:
        index = _index(selection)
    except (ValueError, TypeError, KeyError):
        raise NeuronSelectionError(
            f"population '{name}': cells are picked by '0:5', '0:6:2', 5, [0, 2], "
            f"{{from: 0, to: 6, step: 2}} or {{list: [0, 2]}}, not by {selection!r}",
            subject=name,
        ) from None
    if not _is_inside(index, size):
        raise NeuronSelectionError(
            f"population '{name}': {selection!r} reaches outside the circuit, whose cells are 0..{size - 1}",
            subject=name,
        )
    picked = np.atleast_1d(circuit[index])
    if not picked.size:
        message = f"population '{name}': {selection!r} picks no cell of the circuit"
        raise NeuronSelectionError(message, subject=name)
    return picked


def _is_inside(index: slice | IntArray, size: int) -> bool:
    if isinstance(index, slice):
        return all(-size <= bound <= size for bound in (index.start, index.stop) if bound is not None)
    return bool(((index >= -size) & (index < size)).all())


def _index(selection: Selection) -> slice | IntArray:
    """Return a selection as a NumPy index.

    Raises:
        ValueError, TypeError, KeyError: not a valid selection.
    """
    if selection is None:
        return slice(None)
    if isinstance(selection, str):
        bounds = [int(part) if part.strip() else None for part in selection.split(":")]
        return _slice(*bounds) if len(bounds) > 1 else np.array(int(selection))
    if isinstance(selection, Mapping):
        if set(selection) == {"list"}:
            return _index(selection["list"])
        return _slice(**{_BOUNDS[key]: value for key, value in selection.items()})
    index = np.asarray(selection)
    if index.ndim > 1 or (index.size and index.dtype.kind not in "iu"):
        raise ValueError(selection)
    return index.astype(np.int64)


def _slice(start: int | None = None, stop: int | None = None, step: int | None = None) -> slice:
    bounds = [None if bound is None else operator.index(bound) for bound in (start, stop, step)]
    if bounds[2] == 0:
        raise ValueError("the step is 0")
    return slice(*bounds)
