"""Named neurons of a brain script: its variables, and what an experiment picks from its circuit."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pyNN.common import Assembly, BasePopulation

from nrp_core.brain.network import IntArray
from nrp_core.brain.pynn.populations import ids_of, parts_of
from nrp_core.brain.pynn.simulator import State
from nrp_core.errors import NetworkError, NeuronSelectionError

if TYPE_CHECKING:
    from nrp_core.brain.script import Selection

CIRCUIT = "circuit"
_BOUNDS = {"from": "start", "to": "stop", "step": "step"}


def views_of(
    variables: Mapping[str, Any], populations: Mapping[str, Selection], state: State
) -> dict[str, IntArray]:
    """Return the global ids of all named neurons.

    Args:
        variables: of the script.
        populations: by name, which cells of the variable ``circuit`` these are.
        state: what the script built.

    Raises:
        NetworkError: there is no circuit to pick from, or it no longer exists.
        NeuronSelectionError: the circuit has no such cells.
    """
    circuit = variables.get(CIRCUIT)
    named = {name: cells for name, cells in variables.items() if _is_cells(cells) and name[0] != "_"}
    if isinstance(circuit, Mapping):
        named |= {str(label): cells for label, cells in circuit.items() if _is_cells(cells)}
    views = {name: _existing_ids(name, cells, state) for name, cells in named.items()}
    if populations and not _is_cells(circuit):
        raise NetworkError(
            f"the script has no circuit from which to take '{next(iter(populations))}': name a population, "
            f"view or assembly '{CIRCUIT}', or use the names that there are ({', '.join(named) or 'none'})"
        )
    return views | {name: _picked(name, selection, views[CIRCUIT]) for name, selection in populations.items()}


def _is_cells(value: object) -> bool:
    return isinstance(value, (BasePopulation, Assembly))


def _existing_ids(name: str, cells: Any, state: State) -> IntArray:
    if not all(part._owner() in state.populations for part in parts_of(cells)):
        raise NetworkError(f"'{name}' was built before the last setup(), which forgets everything")
    return ids_of(cells)


def _picked(name: str, selection: Selection, circuit: IntArray) -> IntArray:
    size = len(circuit)
    try:
        index = _index(selection)
    except (ValueError, TypeError, KeyError):
        raise NeuronSelectionError(
            f"population '{name}': cells are picked by '0:5', '0:6:2', 5, [0, 2], "
            f"{{from: 0, to: 6, step: 2}} or {{list: [0, 2]}}, not by {selection!r}"
        ) from None
    if not _is_inside(index, size):
        raise NeuronSelectionError(
            f"population '{name}': {selection!r} reaches outside the circuit, whose cells are 0..{size - 1}"
        )
    picked = np.atleast_1d(circuit[index])
    if not picked.size:
        raise NeuronSelectionError(f"population '{name}': {selection!r} picks no cell of the circuit")
    return picked


def _is_inside(index: slice | IntArray, size: int) -> bool:
    if isinstance(index, slice):
        return all(-size <= bound <= size for bound in (index.start, index.stop) if bound is not None)
    return bool(((index >= -size) & (index < size)).all())


def _index(selection: Selection) -> slice | IntArray:
    """Return a selection as NumPy takes it.

    Raises:
        ValueError, TypeError, KeyError: it is none.
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
