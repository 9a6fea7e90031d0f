"""Named neurons of a brain script: its variables, and the experiment's selections from its circuit."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyNN.common import Assembly, BasePopulation

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.picking import CIRCUIT, Selection, hidden, picked
from nrp_core.brain.pynn.populations import ids_of, require_existing
from nrp_core.brain.pynn.simulator import State
from nrp_core.errors import NetworkError

_NO_CELLS = (type(None), str, int, float, list, tuple, set)
"""Kinds of values that a script may take for a circuit."""


def views_of(
    variables: Mapping[str, Any], populations: Mapping[str, Selection], state: State
) -> dict[str, IntArray]:
    """Return the global ids of all named neurons.

    Args:
        variables: the script's variables.
        populations: selections of cells of the variable ``circuit``, by name.
        state: the objects built by the script.

    Raises:
        NetworkError: there is no circuit to select from, or it no longer exists.
        NeuronSelectionError: the circuit has no such cells.
    """
    circuit = variables.get(CIRCUIT)
    named = {name: cells for name, cells in variables.items() if _is_cells(cells) and name[0] != "_"}
    if isinstance(circuit, Mapping):
        named |= {str(label): cells for label, cells in circuit.items() if _is_cells(cells)}
    views = {name: _existing_ids(name, cells, state) for name, cells in named.items()}
    _tell_of_no_cells(variables, state)
    if populations and not _is_cells(circuit):
        raise NetworkError(
            f"the script has no circuit from which to take '{next(iter(populations))}': name a population, "
            f"view or assembly '{CIRCUIT}', or use the names that there are ({', '.join(named) or 'none'})"
        )
    chosen = {name: picked(name, selection, views[CIRCUIT]) for name, selection in populations.items()}
    labels = {one.label: ids_of(one) for one in state.populations}
    for text in hidden({**labels, **views}, chosen):
        state.remark(text)
    return views | chosen


def _tell_of_no_cells(variables: Mapping[str, Any], state: State) -> None:
    """Tell of a circuit, or parts of one, that is not cells; a function of that name is one of the script."""
    circuit = variables.get(CIRCUIT, ())
    if isinstance(circuit, Mapping):
        for label, cells in circuit.items():
            if not _is_cells(cells):
                state.remark(f"'{label}' of '{CIRCUIT}' is {cells!r:.60}, not cells, so it names none")
    elif CIRCUIT in variables and isinstance(circuit, _NO_CELLS):
        state.remark(
            f"'{CIRCUIT}' is {circuit!r:.60}; it must be a population, view, assembly or a dictionary of them"
        )


def _is_cells(value: object) -> bool:
    return isinstance(value, (BasePopulation, Assembly))


def _existing_ids(name: str, cells: Any, state: State) -> IntArray:
    require_existing(name, cells, state)
    return ids_of(cells)
