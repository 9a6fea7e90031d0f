"""Whether the parts of a network are what they should be, with the values that their types have, by name."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Final

from nrp_core.brain.network.cells.types import CELLS
from nrp_core.brain.network.synapses.laws import LAWS
from nrp_core.errors import NetworkError, did_you_mean

if TYPE_CHECKING:
    from nrp_core.brain.network.data import Network, Population, Projection

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


def require_cell_names(population: Population) -> None:
    """Check the names of the parameters and initial values of a population of standard cells.

    Raises:
        NetworkError: its cell type has no such value.
    """
    cell = None if population.equations is not None else CELLS.get(population.cell_type)
    if cell is None:  # a backend may have cells of its own
        return
    owner = f"population '{population.label}' ({population.cell_type})"
    _require_known(owner, "parameter", population.parameters, cell.parameters)
    states = cell.state if population.is_source else {*cell.state, *_INPUTS}
    _require_known(owner, "state variable", population.initial_values, states)


def require_synapse_names(projection: Projection) -> None:
    """Check the names of the parameters of the synapses of a projection.

    Raises:
        NetworkError: its synapse law has no such parameter.
    """
    law = None if projection.equations is not None else LAWS.get(projection.synapse_type)
    if law is not None and projection.synapse_parameters:
        owner = f"projection '{projection.label}' ({projection.synapse_type})"
        _require_known(owner, "parameter", projection.synapse_parameters, law.parameters)


def require_complete(network: Network) -> None:
    """Check that a network has all values that simulators read; descriptions of networks have only some.

    Raises:
        NetworkError: a parameter of cells or synapses is missing.
    """
    for one in network.populations.values():
        cell = None if one.equations is not None else CELLS.get(one.cell_type)
        if cell is not None and one.size:
            _require_all(f"population '{one.label}' ({one.cell_type})", one.parameters, cell.parameters)
    for each in network.projections:
        law = None if each.equations is not None else LAWS.get(each.synapse_type)
        if law is not None and not law.parts and each.size:  # a part that is not chosen needs none
            owner = f"projection '{each.label}' ({each.synapse_type})"
            _require_all(owner, each.synapse_parameters, law.parameters)


def _require_known(owner: str, what: str, given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            raise NetworkError(f"{owner} has no {what} '{name}'{did_you_mean(name, known)}")


def _require_all(owner: str, given: Collection[str], known: Collection[str]) -> None:
    missing = [name for name in known if name not in given]
    if missing:
        names = ", ".join(f"'{name}'" for name in missing)
        raise NetworkError(f"{owner} needs the parameter{'s' if len(missing) > 1 else ''} {names}")
