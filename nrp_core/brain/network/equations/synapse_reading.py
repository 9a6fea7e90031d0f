"""Reads the texts of a synapse law that is given as equations, in the notation of Brian2."""

from __future__ import annotations

from collections.abc import Mapping

from nrp_core.brain.network.equations.courses import courses_of
from nrp_core.brain.network.equations.declarations import (
    Assignments,
    Names,
    assignments_of,
    definitions_of,
    names_of,
    parameters_of,
    variables_of,
)
from nrp_core.brain.network.equations.expressions import WEIGHT, TextOrigin, names_in, resolved
from nrp_core.brain.network.equations.lines import OF_SYNAPSES, Line, lines_of
from nrp_core.brain.network.equations.model import Variable
from nrp_core.brain.network.equations.synapse_model import SHARE, SYNAPSE_TYPE, SynapseModel, SynapseTexts
from nrp_core.brain.network.equations.units import NONE, Dimension, Unit, described, quantity, unit_of
from nrp_core.errors import did_you_mean

_TAKEN = {
    SHARE: "the share of the weight with which a spike arrives",
    "delay": "that of the synapse",
    "w": "that of a weight in Brian2; here the weight is 'weight'",
}


def read_synapse(texts: SynapseTexts) -> SynapseModel:
    """Return the meaning of the texts of a synapse law.

    Raises:
        NetworkError: a mistake, with its line.
    """
    lines = lines_of(texts.equations, SYNAPSE_TYPE, OF_SYNAPSES)
    parameters = parameters_of(texts.units, lines, SYNAPSE_TYPE)
    _require_free(lines, texts.units)
    names = names_of(lines, parameters, texts.units, SYNAPSE_TYPE)
    own = {*parameters, *(line.name for line in lines), WEIGHT, SHARE}
    variables = variables_of(lines, names, own)
    definitions = {name: resolved(node, own) for name, node in definitions_of(lines, names).items()}
    weight_unit = _unit(texts.weight_unit)
    targets = {name: variable.unit.dimension for name, variable in variables.items()}
    targets |= {WEIGHT: weight_unit.dimension, SHARE: NONE}
    changes = {}
    for where, text in (("on_pre", texts.on_pre), ("on_post", texts.on_post)):
        known = Names({**names.dimensions, WEIGHT: weight_unit.dimension, SHARE: NONE}, names.constant)
        found = assignments_of(text, where, SYNAPSE_TYPE, targets, known)
        changes[where] = tuple((name, resolved(value, own)) for name, value in found)
    _require_purpose(changes["on_pre"], changes["on_post"])
    return SynapseModel(
        variables, courses_of(variables, definitions), definitions, parameters, changes["on_pre"],
        changes["on_post"], _initial(texts.initial, variables), weight_unit,
    )  # fmt: skip


def _require_free(lines: list[Line], units: Mapping[str, str]) -> None:
    """Refuse names that mean something else at a synapse."""
    places = {
        name: TextOrigin("parameters", f"{name}: {text}", kind=SYNAPSE_TYPE) for name, text in units.items()
    }
    places |= {line.name: line.place for line in lines}
    for name in _TAKEN.keys() & places.keys():
        places[name].refuse(f"'{name}' is reserved, it is {_TAKEN[name]}; choose another name")


def _unit(text: str) -> Unit:
    try:
        return unit_of(text)
    except ValueError as error:
        TextOrigin("weight_unit", text, kind=SYNAPSE_TYPE).refuse(str(error))


def _require_purpose(on_pre: Assignments, on_post: Assignments) -> None:
    """Refuse laws that neither transmit a share nor change the weight, and those that do both."""
    shares = [k for k, (name, _) in enumerate(on_pre) if name == SHARE]
    plastic = any(name == WEIGHT for name, _ in (*on_pre, *on_post))
    place = TextOrigin("on_pre", "; ".join(name for name, _ in on_pre), kind=SYNAPSE_TYPE)
    after = TextOrigin("on_post", "; ".join(name for name, _ in on_post), kind=SYNAPSE_TYPE)
    if any(name == SHARE or SHARE in names_in(value) for name, value in on_post):
        after.refuse("'share' is that of an arriving spike, so it stands in on_pre")
    if not shares and not plastic:
        place.refuse(
            "it has no effect; a spike arrives with 'share = ...' of the weight, or it changes the weight, "
            "'weight += ...'"
        )
    if shares and plastic:
        place.refuse("a law sets the share of the weight that arrives or changes the weight, not both")
    if shares and on_post:
        after.refuse(
            "spikes of the target have an effect in laws that change the weight, not in those of a share"
        )
    if shares and any(WEIGHT in names_in(value) for _, value in on_pre):
        place.refuse("a share is that of any weight, so it does not depend on 'weight'")
    first = shares[0] if shares else len(on_pre)
    if any(SHARE in names_in(value) for _, value in on_pre[: first + 1]):
        place.refuse("'share' is used before it has a value; begin with 'share = ...'")


def _initial(texts: Mapping[str, str], variables: Mapping[str, Variable]) -> dict[str, float]:
    """Return the initial values of all state variables in SI units."""
    found = dict.fromkeys(variables, 0.0)
    for name, text in texts.items():
        place = TextOrigin("initial", f"{name}: {text}", kind=SYNAPSE_TYPE)
        if name not in variables:
            place.refuse(f"there is no state variable '{name}'{did_you_mean(name, variables)}")
        try:
            number, unit = quantity(text)
        except ValueError as error:
            place.refuse(str(error))
        _require_unit(unit, variables[name].unit.dimension, name, number, place)
        found[name] = number * unit.scale
    return found


def _require_unit(unit: Unit, dimension: Dimension, name: str, number: float, place: TextOrigin) -> None:
    if unit.dimension != dimension and number != 0.0:
        place.refuse(f"'{name}' is in {described(dimension)}, not in {described(unit.dimension)}")
