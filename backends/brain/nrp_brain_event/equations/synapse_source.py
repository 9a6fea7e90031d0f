"""Writes the kernels of a synapse law that is given as equations.

A kernel gets the records of a synapse, and of its rule if it changes the weight, as arrays of numbers, in
which parameters and state variables have the places of :mod:`nrp_brain_event.equations.places`.
"""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import indent
from typing import Final

from nrp_brain_event.equations.compiled import Arguments
from nrp_brain_event.equations.expressions import IMPORTS, PARAMETER, STATE, needed, source_of
from nrp_brain_event.equations.places import Places
from nrp_core.brain.network.equations.declarations import Assignments
from nrp_core.brain.network.equations.expressions import WEIGHT
from nrp_core.brain.network.equations.synapse import SHARE, ZERO, SynapseModel

OF_SHARE: Final[Arguments] = (("synapse", "*float64"), ("now", "float64"))
OF_RULE: Final[Arguments] = (
    ("rule", "*float64"),
    ("synapse", "*float64"),
    ("now", "float64"),
    ("side", "int64"),
)
"""The arguments of the kernels; times are in ms."""
SOURCE: Final = 0
TARGET: Final = 1
"""The sides of a synapse."""
_HEAD: Final = f'"""A synapse law that a user gave as equations; written by nrp_brain_event."""\n{IMPORTS}'
_S_PER_MS: Final = "1e-3"


def share_source(model: SynapseModel, places: Places) -> str:
    """Return the module with the function ``strength``, which stores the share of a spike in the synapse."""
    body = "\n".join(
        [
            *_loaded(model, places),
            *_changed(model, model.on_pre),
            *_stored(model, places),
            f"synapse[{places.share}] = {SHARE}",
            "return 0",
        ]
    )
    return f"{_HEAD}\n\n@jit\ndef strength(synapse, now):\n{indent(body, '    ')}\n"


def rule_source(model: SynapseModel, places: Places) -> str:
    """Return the module with the function ``learn``, for a spike of a side of the synapse."""
    sides = {"on_source": model.on_pre, "on_target": model.on_post}
    functions = [_learning(name, changes, model, places) for name, changes in sides.items()]
    choice = (
        "@jit\ndef learn(rule, synapse, now, side):\n"
        f"    if side == {TARGET}:\n        return on_target(rule, synapse, now)\n"
        "    return on_source(rule, synapse, now)\n"
    )
    return "\n\n".join([_HEAD, *functions, choice])


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
    return f"@jit\ndef {name}(rule, synapse, now):\n{indent(body, '    ')}\n"


def _loaded(model: SynapseModel, places: Places) -> Iterator[str]:
    """Yield the lines that read a synapse and bring it to the present."""
    holder = "rule" if model.is_plastic else "synapse"
    for name in model.parameters:
        yield f"{PARAMETER}{name} = {holder}[{places.parameters[name]}]"
    for name in model.variables:
        yield f"{STATE}{name} = synapse[{places.state[name]}]"
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


def _changed(model: SynapseModel, changes: Assignments) -> Iterator[str]:
    for name, value in changes:
        yield from needed([value], model)
        yield f"{name if name in (WEIGHT, SHARE) else STATE + name} = {source_of(value, model)}"


def _stored(model: SynapseModel, places: Places) -> Iterator[str]:
    yield from (f"synapse[{places.state[name]}] = {STATE}{name}" for name in model.variables)
    yield f"synapse[{places.last}] = now"
