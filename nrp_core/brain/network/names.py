"""Whether the parts of a network are what they should be, with the values that their types have, by name."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Final

from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.network.synapses import LAWS
from nrp_core.errors import NetworkError, did_you_mean

_INPUTS: Final = ("gsyn_exc", "gsyn_inh", "isyn_exc", "isyn_inh")
"""The state of cells with synapses of any kind: what is left of earlier input."""


def require_parts(fields: str, kind: type, given: Iterable[object]) -> None:
    """Check that all values of a field of a network are of one class.

    Raises:
        NetworkError: one is not.
    """
    for one in given:
        if not isinstance(one, kind):
            raise NetworkError(f"the {fields} of a network are each a {kind.__name__}, not {one!r:.60}")


def require_cell_names(
    label: str, cell_type: str, parameters: Collection[str], states: Collection[str]
) -> None:
    """Check the names of the parameters and initial values of a population of standard cells.

    Args:
        label: the population's.
        cell_type: its cells; a backend may have some that are not standard.
        parameters: the names of its parameters.
        states: the names of its initial values.

    Raises:
        NetworkError: the cell type has no such value.
    """
    cell = CELLS.get(cell_type)
    if cell is not None:
        owner = f"population '{label}' ({cell_type})"
        _require_known(owner, "parameter", parameters, cell.parameters)
        _require_known(owner, "state variable", states, {*cell.state, *(_INPUTS if cell.weight_unit else ())})


def require_synapse_names(label: str, synapse_type: str, parameters: Collection[str]) -> None:
    """Check the names of the parameters of the synapses of a projection.

    Raises:
        NetworkError: the synapse law has no such parameter.
    """
    law = LAWS.get(synapse_type)
    if law is not None:
        _require_known(f"projection '{label}' ({synapse_type})", "parameter", parameters, law.parameters)


def require_all_parameters(owner: str, given: Collection[str], known: Iterable[str]) -> None:
    """Check that no parameter is missing.

    Raises:
        NetworkError: one is.
    """
    missing = [name for name in known if name not in given]
    if missing:
        names = ", ".join(f"'{name}'" for name in missing)
        raise NetworkError(f"{owner} needs the parameter{'s' if len(missing) > 1 else ''} {names}")


def _require_known(owner: str, what: str, given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            raise NetworkError(f"{owner} has no {what} '{name}'{did_you_mean(name, known)}")
