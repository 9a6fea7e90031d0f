"""Fills the records of synapses whose law is given as equations.

Where the records of synapses have room for the parameters and variables of laws given as equations.

The records are those of all laws, so that the engine is compiled once. A law given as equations uses the
fields of the others, which are free in its synapses. All fields before it have the same size, so a field is a
place in an array.

Writes the kernels of a synapse law that is given as equations.

A kernel gets the records of a synapse, and of its rule if it changes the weight, as arrays of numbers, in
which parameters and state variables have the places of :mod:`nrp_brain_event.equation_synapses`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import indent
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.equation_source import IMPORTS, PARAMETER, STATE, Arguments, compiled, needed, source_of
from nrp_brain_event.handles import call
from nrp_brain_event.records import Array, Plastic, Rule, ShortTerm, Slow
from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit
from nrp_core.clock import MS_PER_S
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Projection
from nrp_core.network.equations.declarations import Assignments
from nrp_core.network.equations.expressions import WEIGHT
from nrp_core.network.equations.model import value_of
from nrp_core.network.equations.synapse import SHARE, SYNAPSE_TYPE, ZERO, SynapseEquations, SynapseModel
from nrp_core.units import Unit

_SHORT_TERM: Final = ShortTerm.dtype().names or ()
_PLASTIC: Final = Plastic.dtype().names or ()
_SLOW: Final = Slow.dtype().names or ()
_STATE_OF_PLASTIC: Final = [
    *(("synapse", _PLASTIC.index(name)) for name in ("pre_trace", "post_trace")),
    *(("slow", place) for place in range(len(_SLOW))),
]
"""The record and the field of each state variable of a plastic synapse."""
_RULE: Final = Rule.dtype().names or ()
_LAST: Final = "pre_t"
"""The time of the last spike of either side at a plastic synapse."""


class Places(NamedTuple):
    """The fields of a law.

    Args:
        parameters: of the record of the synapse, or of the rule of a plastic one.
        state: the record, ``synapse`` or ``slow``, and its field.
        last: the time of the last update, ms.
        share: of the record of the synapse.
        weight: the magnitude of a plastic weight.
        scale: the factor by which the equations multiply it.
        modulator: the number of the dopamine that it follows.
    """

    parameters: dict[str, int]
    state: dict[str, tuple[str, int]]
    last: int
    share: int = -1
    weight: int = -1
    scale: int = -1
    modulator: int = -1


def places_of(model: SynapseModel, owner: str) -> Places:
    """Return the fields of a law.

    Args:
        model: the law.
        owner: the projection, for the message.

    Raises:
        CapabilityError: the records have too few.
    """
    if not model.is_plastic:
        free = _free(_SHORT_TERM, ("law", "tau_psc", "t", "stream", "own", "share"))
        _require(
            len(model.parameters) + len(model.variables), len(free), "parameters and state variables", owner
        )
        state = {name: ("synapse", place) for name, place in zip(model.variables, free, strict=False)}
        parameters = dict(zip(model.parameters, free[len(state) :], strict=False))
        return Places(parameters, state, _SHORT_TERM.index("t"), share=_SHORT_TERM.index("share"))
    scale, modulator, *of_rule = _free(_RULE, ("law", "sign", "frozen", "own", "dopamine"))
    if not model.eligibility:
        of_rule.insert(0, modulator)
    _require(len(model.variables), len(_STATE_OF_PLASTIC), "state variables", owner)
    _require(len(model.parameters), len(of_rule), "parameters", owner)
    return Places(
        dict(zip(model.parameters, of_rule, strict=False)),
        dict(zip(model.variables, _STATE_OF_PLASTIC, strict=False)),
        _PLASTIC.index(_LAST), weight=_PLASTIC.index("weight"), scale=scale,
        modulator=modulator,
    )  # fmt: skip


def _free(names: Sequence[str], used: Iterable[str]) -> list[int]:
    return [place for place, name in enumerate(names) if name not in used]


def _require(needed: int, room: int, what: str, owner: str) -> None:
    if needed > room:
        raise CapabilityError(
            f"{owner}: its equations have {needed} {what}; on 'event' an {SYNAPSE_TYPE} of this kind has at "
            f"most {room}"
        )


OF_MODULATED: Final[Arguments] = (
    ("rule", "*float64"),
    ("synapse", "*float64"),
    ("slow", "*float64"),
    ("_post_t", "float64"),
    ("now", "float64"),
    ("side", "int64"),
    ("places", "*int64"),
)
OF_SHARE: Final[Arguments] = (("synapse", "*float64"), ("now", "float64"))
OF_RULE: Final[Arguments] = (
    ("rule", "*float64"),
    ("synapse", "*float64"),
    ("slow", "*float64"),
    ("now", "float64"),
    ("side", "int64"),
)
"""The arguments of the kernels; times are in ms."""
TARGET: Final = 1
NEITHER: Final = 2
"""The side of a synapse whose spike it processes; else the source's."""
_HEAD: Final = f'"""A synapse law that a user gave as equations; written by nrp_brain_event."""\n{IMPORTS}'
_DOPAMINE: Final = """\
from nrp_brain_event.dopamine import Dopamine, followed
from nrp_brain_event.handles import opened
"""
_S_PER_MS: Final = "1e-3"


def share_source(model: SynapseModel, places: Places) -> str:
    """Return the module of a law of a share.

    The function ``strength`` stores the share of a spike in the synapse, ``settle`` brings it to the present.
    """
    settle = "\n".join([*_loaded(model, places), *_stored(model, places), "return 0"])
    body = "\n".join(
        [
            *_loaded(model, places),
            *_changed(model, model.on_pre),
            *_stored(model, places),
            f"synapse[{places.share}] = {SHARE}",
            "return 0",
        ]
    )
    return (
        f"{_HEAD}\n\n@jit\ndef strength(synapse, now):\n{indent(body, '    ')}\n"
        f"\n\n@jit\ndef settle(synapse, now):\n{indent(settle, '    ')}\n"
    )


def rule_source(model: SynapseModel, places: Places) -> str:
    """Return the module with the function ``learn``, for a spike of a side of the synapse."""
    sides = {"on_source": model.on_pre, "on_target": model.on_post, "settle": ()}
    functions = [_learning(name, changes, model, places) for name, changes in sides.items()]
    arguments, before, head = OF_RULE, "", _HEAD
    if model.eligibility:
        arguments, head = OF_MODULATED, _HEAD + _DOPAMINE
        functions.append(_following(model, places))
        before = "    follow(rule, synapse, slow, now, places)\n"
    choice = (
        f"@jit\ndef learn({', '.join(name for name, _ in arguments)}):\n{before}"
        f"    if side == {TARGET}:\n        return on_target(rule, synapse, slow, now)\n"
        f"    if side == {NEITHER}:\n        return settle(rule, synapse, slow, now)\n"
        "    return on_source(rule, synapse, slow, now)\n"
    )
    return "\n\n".join([head, *functions, choice])


def _following(model: SynapseModel, places: Places) -> str:
    """Return the function in which the weight follows dopamine since the last update."""
    scale, weight = f"rule[{places.scale}]", f"synapse[{places.weight}]"
    return (
        "@jit\ndef follow(rule, synapse, slow, now, places):\n"
        f"    since = synapse[{places.last}]\n"
        "    if now > since:\n"
        f"        {weight}, _ = followed(\n"
        f"            opened(Dopamine, places), int(rule[{places.modulator}]), {weight},\n"
        f"            {_at(places, model.eligibility)} / {scale}, since, now\n"
        "        )\n"
    )


def _learning(name: str, changes: Assignments, model: SynapseModel, places: Places) -> str:
    scale, weight = f"rule[{places.scale}]", f"synapse[{places.weight}]"
    body = "\n".join(
        [
            *_loaded(model, places),
            f"{WEIGHT} = {weight} * {scale}",
            *_changed(model, changes),
            *_stored(model, places),
            *([f"{weight} = {WEIGHT} / {scale}"] if any(one == WEIGHT for one, _ in changes) else []),
            "return 0",
        ]
    )
    return f"@jit\ndef {name}(rule, synapse, slow, now):\n{indent(body, '    ')}\n"


def _loaded(model: SynapseModel, places: Places) -> Iterator[str]:
    """Yield the lines that read a synapse and advance it to the present."""
    holder = "rule" if model.is_plastic else "synapse"
    for name in model.parameters:
        yield f"{PARAMETER}{name} = {holder}[{places.parameters[name]}]"
    for name in model.variables:
        yield f"{STATE}{name} = {_at(places, name)}"
    yield f"t = now * {_S_PER_MS}"
    if not model.variables:
        return
    yield f"dt = max(now - synapse[{places.last}], 0.0) * {_S_PER_MS}"
    yield from needed([c for course in model.courses.values() for c in course.coefficients], model)
    for name, course in model.courses.items():
        yield f"r_{name} = {source_of(course.rate, model)}"
        yield f"k_{name} = exp(r_{name} * dt)"
    for name, course in model.courses.items():
        terms = [f"{STATE}{name} * k_{name}"]
        if course.constant is not ZERO:  # the product with a zero would be computed
            terms.append(f"({source_of(course.constant, model)}) * dt * exprel(r_{name} * dt)")
        terms += [
            f"driven(dt, k_{name}, k_{driver}, r_{name} - r_{driver}, "
            f"({source_of(factor, model)}) * {STATE}{driver}, 0.0)"
            for driver, factor in course.drivers.items()
        ]
        yield f"y_{name} = {' + '.join(terms)}"
    yield from (f"{STATE}{name} = y_{name}" for name in model.variables)


def _at(places: Places, variable: str) -> str:
    record, field = places.state[variable]
    return f"{record}[{field}]"


def _changed(model: SynapseModel, changes: Assignments) -> Iterator[str]:
    for name, value in changes:
        yield from needed([value], model)
        yield f"{name if name in (WEIGHT, SHARE) else STATE + name} = {source_of(value, model)}"


def _stored(model: SynapseModel, places: Places) -> Iterator[str]:
    yield from (f"{_at(places, name)} = {STATE}{name}" for name in model.variables)
    yield f"synapse[{places.last}] = now"


def fill_share(table: Array, projection: Projection) -> None:
    """Store parameters, initial state and kernel of synapses that transmit a share.

    Raises:
        CapabilityError: the law has more of them than the engine has room for.
    """
    law, places = _law_of(projection)
    for name, values in law.in_si(projection.synapse_parameters).items():
        table[_SHORT_TERM[places.parameters[name]]] = values
    table[_SHORT_TERM[places.last]] = 0.0
    for name, value in law.model.initial.items():
        table[_SHORT_TERM[places.state[name][1]]] = value
    table["own"] = compiled(share_source(law.model, places), "strength", OF_SHARE)


def begin_plastic(table: Array, slow: Array, rows: Array, projection: Projection) -> None:
    """Store the initial state of plastic synapses in rows of tables."""
    law, places = _law_of(projection)
    table[_PLASTIC[places.last]][rows] = 0.0
    for name, value in law.model.initial.items():
        record, field = places.state[name]
        of = (table, _PLASTIC) if record == "synapse" else (slow, _SLOW)
        of[0][of[1][field]][rows] = value


def needs_slow(projection: Projection) -> bool:
    """Return whether the equations of plastic synapses have more variables than a record holds."""
    _, places = _law_of(projection)
    return any(record == "slow" for record, _ in places.state.values())


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
    arguments = OF_MODULATED if law.model.eligibility else OF_RULE
    kernel = compiled(rule_source(law.model, places), "learn", arguments)
    return columns | {_RULE[places.scale]: law.weight_scale(unit), "own": float(kernel)}


def change_rules(
    rules: Array, numbers: Array, projection: Projection, values: Mapping[str, FloatArray]
) -> None:
    """Change parameters of plastic synapses, in place.

    Args:
        rules: the rules of the engine.
        numbers: the rule of each synapse.
        projection: the projection.
        values: new parameters, one for each synapse.

    Raises:
        CapabilityError: synapses that had equal parameters get different ones.
    """
    law, places = _law_of(projection)
    firsts, of = np.unique(numbers, return_index=True, return_inverse=True)[1:]
    for name, each in values.items():
        if (each != each[firsts][of]).any():
            raise CapabilityError(
                f"projection '{projection.label}': synapses that had equal parameters keep equal ones while "
                f"the network runs; {name} gets several"
            )
    for name, each in law.in_si(values).items():
        rules[_RULE[places.parameters[name]]][numbers[firsts]] = each[firsts]


def change_shares(
    table: Array, projection: Projection, values: Mapping[str, FloatArray], now: FloatArray
) -> None:
    """Change parameters of synapses that transmit a share, in place, each at a time in its record (ms)."""
    law, places = _law_of(projection)
    _settle(table, compiled(share_source(law.model, places), "settle", OF_SHARE), now)
    for name, each in law.in_si(values).items():
        table[_SHORT_TERM[places.parameters[name]]] = each


def keep_addresses(rules: Array, initial: Array) -> None:
    """Keep the addresses of this process, and whether weights are frozen: a restore changes neither."""
    for name in ("own", "dopamine", "frozen"):
        rules[name] = initial[name]


def follow_modulator(rule: Array, projection: Projection, number: int, tau_c: float) -> None:
    """Let the weights of synapses with a rule follow the dopamine with a number.

    Raises:
        CapabilityError: the eligibility decays with another time constant than ``tau_c`` (ms).
    """
    law, places = _law_of(projection)
    model = law.model
    rates = value_of(
        model.courses[model.eligibility].rate, law.in_si(projection.synapse_parameters), model.definitions
    )
    if not np.allclose(np.multiply(rates, -tau_c / MS_PER_S), 1.0, rtol=1e-9, atol=0.0):
        taus = ", ".join(f"{-MS_PER_S / rate:g}" for rate in np.unique(rates)[:3])
        raise CapabilityError(
            f"projection '{projection.label}': '{model.eligibility}' decays in {taus} ms, and tau_c of the "
            f"Neuromodulation onto '{projection.post}' is {tau_c:g} ms; both are one time constant"
        )
    rule[_RULE[places.modulator]] = number


def state_of(plastic: Array, slow: Array, projection: Projection, name: str) -> FloatArray:
    """Return a state variable of plastic synapses in its unit."""
    law, places = _law_of(projection)
    record, field = places.state[name]
    values = plastic[_PLASTIC[field]] if record == "synapse" else slow[_SLOW[field]]
    found: FloatArray = values / law.model.variables[name].unit.scale
    return found


def share_state(table: Array, projection: Projection, name: str, now: FloatArray) -> FloatArray:
    """Return a state variable of synapses that transmit a share, in its unit.

    Args:
        table: copies of their records, which change.
        projection: the projection.
        name: the variable.
        now: the time of each in its record, ms.
    """
    law, places = _law_of(projection)
    _settle(table, compiled(share_source(law.model, places), "settle", OF_SHARE), now)
    found: FloatArray = table[_SHORT_TERM[places.state[name][1]]] / law.model.variables[name].unit.scale
    return found


@jit
def _settle(table: Array, kernel: int, now: FloatArray) -> None:
    for k in range(len(table)):
        call(kernel, (table[k], now[k]))


def _law_of(projection: Projection) -> tuple[SynapseEquations, Places]:
    law = projection.equations
    assert law is not None
    return law, places_of(law.model, f"projection '{projection.label}'")


def keep_kernels(table: Array, initial: Array) -> None:
    """Give restored synapses the kernels of this process, in which addresses may be others."""
    table["own"] = initial["own"]
