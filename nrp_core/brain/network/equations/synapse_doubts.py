"""Laws of synapses given as equations that are valid, and probably not meant."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.doubts import (
    Values,
    doubts_about_values,
    known_value,
    reached,
    reversed_limits,
    unused,
)
from nrp_core.brain.network.equations.expressions import WEIGHT
from nrp_core.brain.network.equations.synapse import SynapseEquations
from nrp_core.brain.network.equations.synapse_model import SHARE, SynapseModel

_LIMITS: Final = ("clip", "max")
_SPIKES: Final = 5
_LARGEST_SHARE: Final = 10.0
_TIME_CONSTANT_MS: Final = (0.01, 10_000.0)


def doubts_about_synapses(
    equations: SynapseEquations, parameters: Values, weight: FloatArray
) -> Iterator[str]:
    """Yield a sentence for each thing in the law of synapses that is probably not meant.

    Args:
        equations: the texts.
        parameters: every parameter in its unit, shape ``(n,)``.
        weight: the sizes of weights in the unit of the equations, SI.
    """
    model = equations.model
    statements = [*model.on_pre, *model.on_post]
    nodes = [*(one.rate for one in model.variables.values()), *(value for _, value in statements)]
    yield from unused(model.parameters, model.definitions, nodes)
    yield from _without_effect(model)
    if not all(array.size for array in parameters.values()):
        return
    known: dict[str, Any] = equations.in_si({name: array[:1] for name, array in parameters.items()})
    yield from doubts_about_values(model.parameters, parameters)
    yield from reversed_limits([*nodes, *model.definitions.values()], known, model.definitions)
    yield from _courses(model, known)
    yield from _weights(model, known, weight) if model.is_plastic else _shares(model, known)


def _without_effect(model: SynapseModel) -> Iterator[str]:
    statements = [*model.on_pre, *model.on_post]
    needs = {name: [one.rate] for name, one in model.variables.items()}
    for name, value in statements:
        needs.setdefault(name, []).append(value)
    used = reached([ast.Name(WEIGHT if model.is_plastic else SHARE)], needs, model.definitions)
    changed = {name for name, _ in statements}
    for name in model.variables:
        what = "weight" if model.is_plastic else "share of the weight"
        if name not in used:
            yield f"'{name}' has no effect: the {what} does not depend on it"
        elif name not in changed and not model.initial.get(name) and not _driven(model, name):
            yield f"'{name}' stays at 0: no spike changes it"


def _driven(model: SynapseModel, name: str) -> bool:
    course = model.courses[name]
    return bool(course.drivers) or known_value(course.constant, {}, model.definitions) != 0.0


def _courses(model: SynapseModel, known: dict[str, Any]) -> Iterator[str]:
    for name, course in model.courses.items():
        rate = known_value(course.rate, known, model.definitions)
        if rate is None or not rate.any():
            continue
        constant_ms = 1e3 / np.abs(rate).max()
        if rate.max() > 0.0:
            yield f"'{name}' grows by a factor of e in {constant_ms:.3g} ms between spikes"
        elif not _TIME_CONSTANT_MS[0] <= constant_ms <= _TIME_CONSTANT_MS[1]:
            yield f"'{name}' changes with a time constant of {constant_ms:.4g} ms; is it in another unit?"


def _shares(model: SynapseModel, known: dict[str, Any]) -> Iterator[str]:
    """Yield what is wrong with the shares of spikes that follow each other at once."""
    values = {**known, **{name: model.initial.get(name, 0.0) for name in model.variables}}
    shares: list[float] = []
    for _ in range(_SPIKES):
        for name, value in model.on_pre:
            values[name] = known_value(value, values, model.definitions)
            if values[name] is None:
                return
        shares.append(float(values[SHARE].flat[0]))
    if min(shares) < 0.0:
        yield f"a spike arrives with the share {min(shares):g}, which reverses its sign"
    elif max(shares) > _LARGEST_SHARE:
        yield f"{_SPIKES} spikes at once arrive with shares up to {max(shares):g}"
    elif not any(shares) and not all(map(model.initial.get, model.variables)):
        begins = ", ".join(f"'{one}'" for one in model.variables if not model.initial.get(one))
        yield f"the first spikes arrive with the share 0, because {begins} begins at 0; see `initial`"


def _weights(model: SynapseModel, known: dict[str, Any], weight: FloatArray) -> Iterator[str]:
    for name, value in (*model.on_pre, *model.on_post):
        if name != WEIGHT:
            continue
        match value:
            case ast.Call(func=ast.Name(id="clip"), args=[_, low, high]):
                lowest, highest = (known_value(node, known, model.definitions) for node in (low, high))
                if lowest is not None and lowest.min() < 0.0:
                    yield "its clip lets the weight fall below 0, which reverses the sign of a spike"
                if highest is not None and weight.size and weight.max() > highest.max() > 0.0:
                    yield (
                        f"weights begin above the upper limit of clip, {weight.max() / highest.max():.3g} "
                        "times as large"
                    )
            case ast.Call(func=ast.Name(id=function)) if function in _LIMITS:
                pass
            case _ if any(isinstance(node, (ast.Sub, ast.USub)) for node in ast.walk(value)):
                yield (
                    "nothing keeps the weight from falling below 0, which reverses the sign of a spike; "
                    "write clip(..., lowest, highest)"
                )
