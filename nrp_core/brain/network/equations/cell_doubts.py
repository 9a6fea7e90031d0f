"""Cells given as equations that are valid, and probably not meant."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.equations.doubts import (
    Values,
    doubts_about_values,
    known_value,
    reached,
    reversed_limits,
    unused,
)
from nrp_core.brain.network.equations.linear import rates
from nrp_core.brain.network.equations.model import INPUT, Model
from nrp_core.brain.network.equations.units import VOLT

_MOST_CELLS: Final = 100
"""The cells whose equations are solved; they are mostly alike."""
_LONGEST_S: Final = 10.0
_HIGHEST_V: Final = 1.0


def doubts_about_cells(equations: CellEquations, parameters: Values, states: Values) -> Iterator[str]:
    """Yield a sentence for each thing in the equations of cells that is probably not meant.

    Args:
        equations: the texts.
        parameters: every parameter in its unit, shape ``(n,)``.
        states: initial values of state variables, in their units.
    """
    model = equations.model
    nodes = [
        *(variable.rate for variable in model.variables.values()), model.threshold, model.refractory,
        *(value for _, value in model.reset), *(effect.factor for effect in model.receptors.values()),
    ]  # fmt: skip
    yield from unused(model.parameters, model.definitions, nodes)
    yield from _idle_receptors(model)
    if not all(array.size for array in parameters.values()):
        return
    first = {name: array[:_MOST_CELLS] for name, array in parameters.items()}
    known: dict[str, Any] = equations.in_si(first)
    yield from doubts_about_values(model.parameters, parameters)
    yield from reversed_limits([*nodes, *model.definitions.values()], known, model.definitions)
    yield from _growth(model, known)
    yield from _threshold(equations, model, known)
    begins = known | {
        name: states[name][:_MOST_CELLS] * variable.unit.scale
        for name, variable in model.variables.items()
        if name in states
    }
    yield from _beginning(equations, model, begins)


def _idle_receptors(model: Model) -> Iterator[str]:
    needs: dict[str, list[ast.expr]] = {name: [one.rate] for name, one in model.variables.items()}
    for name, value in model.reset:
        needs[name].append(value)
    used = reached([model.threshold, model.refractory], needs, model.definitions)
    for receptor, effect in model.receptors.items():
        if effect.variable not in used:
            yield (
                f"spikes at the receptor '{receptor}' never change when a cell fires: its threshold does not "
                f"depend on '{effect.variable}'"
            )


def _growth(model: Model, known: dict[str, Any]) -> Iterator[str]:
    """Yield that a linear system grows without bound."""
    coefficients = rates(model)
    if coefficients is None:
        return
    names = list(model.variables)
    columns = {
        (i, j): value_of_key
        for i, row in enumerate(names)
        for j, column in enumerate(names)
        if (node := coefficients[row].get(column)) is not None
        and (value_of_key := known_value(node, known, model.definitions)) is not None
    }
    n = max((len(value) for value in columns.values()), default=1)
    matrix = np.zeros((n, len(names), len(names)))
    for (i, j), value in columns.items():
        matrix[:, i, j] = value
    if not np.isfinite(matrix).all():
        return
    fastest = np.linalg.eigvals(matrix).real.max(axis=1)
    scale = np.abs(matrix).max(initial=0.0)
    if fastest.max() > 1e-9 * scale:
        cell = int(np.argmax(fastest))
        variable = names[int(np.argmax(np.diagonal(matrix[cell])))]
        yield (
            f"without spikes and input, a cell grows by a factor of e in {1e3 / fastest[cell]:.3g} ms: is a "
            f"sign wrong in d{variable}/dt, or in a time constant?"
        )


def _threshold(equations: CellEquations, model: Model, known: dict[str, Any]) -> Iterator[str]:
    match model.threshold:
        case ast.Compare(left=ast.Name(id=name), comparators=[limit]) if name in model.variables:
            value = known_value(limit, known, model.definitions)
            is_voltage = model.variables[name].unit.dimension == VOLT
            if value is not None and is_voltage and np.abs(value).max() >= _HIGHEST_V:
                text = equations.threshold.strip()
                yield f"the threshold, '{text}', is {value.max() * 1e3:g} mV; is it in another unit?"
    changes = [name for name, value in model.reset if not (isinstance(value, ast.Name) and value.id == name)]
    if not changes and model.lasts and isinstance(model.threshold, ast.Compare):  # not "... and v < before"
        yield (
            "the reset changes nothing, so a cell above its threshold fires again after every refractory "
            "period"
        )


def _beginning(equations: CellEquations, model: Model, begins: dict[str, Any]) -> Iterator[str]:
    begins |= {"t": 0.0, INPUT: begins.get(INPUT, 0.0)}
    fires = known_value(model.threshold, begins, model.definitions)
    refractory = known_value(model.refractory, begins, model.definitions)
    if fires is not None and fires.any():
        yield f"cells meet the threshold, '{equations.threshold.strip()}', from the start and fire at once"
    if refractory is None:
        return
    if model.lasts and refractory.max() > _LONGEST_S:
        yield f"the refractory period is {refractory.max():g} s; is it in another unit?"
    elif not model.lasts and refractory.any():
        yield f"cells are refractory from the start, by '{equations.refractory.strip()}'"
