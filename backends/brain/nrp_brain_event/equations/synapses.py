"""Fills the records of synapses whose law is given as equations."""

from __future__ import annotations

from nrp_brain_event.equations.compiled import compiled
from nrp_brain_event.equations.places import Places, places_of
from nrp_brain_event.equations.synapse_source import OF_RULE, OF_SHARE, rule_source, share_source
from nrp_brain_event.records import Array, Plastic, Rule, ShortTerm
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Projection
from nrp_core.brain.network.equations.synapse import SynapseEquations
from nrp_core.brain.network.equations.units import Unit

_SHORT_TERM = ShortTerm.dtype().names or ()
_PLASTIC = Plastic.dtype().names or ()
_RULE = Rule.dtype().names or ()


def fill_share(table: Array, projection: Projection) -> None:
    """Store parameters, initial state and kernel of synapses that transmit a share.

    Raises:
        CapabilityError: the law has more of them than the engine has room for.
    """
    law, places = _law_of(projection)
    for name, values in law.in_si(projection.synapse_parameters).items():
        table[_SHORT_TERM[places.parameters[name]]] = values
    _fill_state(table, _SHORT_TERM, law, places)
    table["own"] = compiled(share_source(law.model, places), "strength", OF_SHARE)


def fill_plastic(table: Array, rows: Array, projection: Projection) -> None:
    """Store the initial state of plastic synapses in rows of a table."""
    law, places = _law_of(projection)
    own = table[rows]
    _fill_state(own, _PLASTIC, law, places)
    table[rows] = own


def rules_of(projection: Projection, unit: Unit) -> dict[str, float | FloatArray]:
    """Return the columns of ``Rule`` for each synapse: parameters and kernel.

    Args:
        projection: plastic synapses.
        unit: the unit of their weights in scripts.

    Raises:
        CapabilityError: the law has more parameters or variables than the engine has room for.
    """
    law, places = _law_of(projection)
    columns: dict[str, float | FloatArray] = {
        _RULE[places.parameters[name]]: values
        for name, values in law.in_si(projection.synapse_parameters).items()
    }
    kernel = compiled(rule_source(law.model, places), "learn", OF_RULE)
    return columns | {_RULE[places.scale]: law.weight_scale(unit), "own": float(kernel)}


def _law_of(projection: Projection) -> tuple[SynapseEquations, Places]:
    law = projection.equations
    assert law is not None
    return law, places_of(law.model, f"projection '{projection.label}'")


def _fill_state(table: Array, names: tuple[str, ...], law: SynapseEquations, places: Places) -> None:
    table[names[places.last]] = 0.0
    for name, value in law.model.initial.items():
        table[names[places.state[name]]] = value


def keep_kernels(table: Array, initial: Array) -> None:
    """Give restored synapses the kernels of this process, in which addresses may be others."""
    table["own"] = initial["own"]
