"""Cells given as equations that are valid, and probably not meant."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.equations.doubts import (
    Values,
    doubts_about_values,
    known_value,
    reached,
    reversed_limits,
    tiny_voltages,
    unused,
)
from nrp_core.brain.network.equations.expressions import TIME, names_in
from nrp_core.brain.network.equations.linear import rates
from nrp_core.brain.network.equations.model import INPUT, Model
from nrp_core.brain.network.equations.responses import (
    Crossing,
    before_upstroke,
    beginning,
    crossing,
    direction,
    drift,
    is_added,
)
from nrp_core.brain.network.equations.units import VOLT

_MOST_CELLS: Final = 100
"""The cells whose equations are solved; they are mostly alike."""
_LONGEST_S: Final = 1.0
"""Of refractory periods."""
_HIGHEST_V: Final = 1.0
_LOWEST_V: Final = 5e-4
"""Of a threshold that is not 0."""
_FARTHEST_V: Final = 0.2
"""From the threshold to where a voltage begins or is reset; spikes reach from -100 to 60 mV."""
_DEEPEST_V: Final = 0.05
"""From where a voltage begins to where it is reset, away from its threshold."""
_TIME_CONSTANT_S: Final = (5e-5, 10.0)
"""As wide as those of our own cells."""
_ROUNDING: Final = 1e-6
_BESIDE: Final = 5.0
"""In the unit of a variable: a rate that is 0 at one value is not at another so far below."""


def doubts_about_cells(
    equations: CellEquations, parameters: Values, states: Values, step_ms: float | None = None
) -> Iterator[str]:
    """Yield a sentence for each thing in the equations of cells that is probably not meant.

    Args:
        equations: the texts.
        parameters: every parameter in its unit, shape ``(n,)``.
        states: initial values of state variables, in their units.
        step_ms: the time step of the network, if it has one.
    """
    model = equations.model
    nodes = [
        *(variable.rate for variable in model.variables.values()), model.threshold, model.refractory,
        *(value for _, value in model.reset), *(effect.factor for effect in model.receptors.values()),
    ]  # fmt: skip
    yield from unused(model.parameters, model.definitions, nodes)
    yield from _idle(model)
    if not all(array.size for array in parameters.values()):
        return
    state = beginning(equations, parameters, states, _MOST_CELLS)
    units = {name: variable.unit for name, variable in model.variables.items()}
    yield from doubts_about_values(model.parameters, parameters)
    # what only the reset uses is an increment
    potentials = reached(
        [model.threshold, *(one.rate for one in model.variables.values())], {}, model.definitions
    )
    known = {name: array for name, array in {**parameters, **states}.items() if name in potentials}
    yield from tiny_voltages({**model.parameters, **units}, known)
    yield from reversed_limits([*nodes, *model.definitions.values()], state, model.definitions)
    yield from _growth(model, state)
    limit = crossing(model, state)
    if limit is not None:
        yield from _threshold(equations, limit, state)
        yield from _time_constants(model, limit.variable, state)
        yield from _added_rests(model, limit.variable, state)
        if INPUT in model.parameters and direction(model, state, limit.variable, INPUT) * limit.sign < 0:
            yield f"a positive {INPUT} takes {limit.variable} away from its threshold: is a sign wrong?"
    yield from _reset(model)
    yield from _constant(model, state)
    yield from _beginning(equations, model, state, step_ms)


def doubts_about_weights(
    equations: CellEquations, parameters: Values, states: Values, receptor: str, weight: FloatArray
) -> Iterator[str]:
    """Yield that synapses act against the name of their receptor.

    An inhibitory synapse may raise a voltage at rest, but not at the threshold; for an excitatory one it is
    the other way round.

    Args:
        equations: the texts of the cells.
        parameters: every parameter in its unit, shape ``(n,)``.
        states: initial values of state variables, in their units.
        receptor: the receptor.
        weight: the weights.
    """
    model = equations.model
    if not weight.size or not all(array.size for array in parameters.values()):
        return
    state = beginning(equations, parameters, states, 1)
    limit = crossing(model, state)
    if limit is None:
        return
    is_inhibitory = receptor == "inhibitory"
    if is_inhibitory:
        state = {**state, limit.variable: before_upstroke(model, state, limit)}
    elif weight.min() < 0.0:  # inhibition by its sign
        return
    effect = model.receptors[receptor]
    factor = known_value(effect.factor, state, model.definitions)
    if factor is None:
        return
    # all weights of an inhibitory receptor may be negative, as those of PyNN's currents are
    size = weight.min() if abs(weight.min()) > abs(weight.max()) else weight.max()
    sign = np.sign(size * factor.flat[0]) * limit.sign
    towards = sign * direction(model, state, limit.variable, effect.variable)
    if towards > 0 and is_inhibitory:
        yield f"inhibitory spikes take {limit.variable} above its threshold: {_SUSPECTS}"
    elif towards < 0 and not is_inhibitory:
        yield f"excitatory spikes take {limit.variable} away from its threshold: {_SUSPECTS}"


_SUSPECTS: Final = "is a sign or a reversal potential wrong?"


def _idle(model: Model) -> Iterator[str]:
    needs: dict[str, list[ast.expr]] = {name: [one.rate] for name, one in model.variables.items()}
    for name, value in model.reset:
        needs[name].append(value)
    used = reached([model.threshold, model.refractory], needs, model.definitions)
    receptors = {effect.variable: name for name, effect in model.receptors.items()}
    for name in model.variables.keys() - used:
        if name in receptors:
            yield (
                f"spikes at the receptor '{receptors[name]}' never change when a cell fires: its threshold "
                f"does not depend on '{name}'"
            )
        else:
            yield f"'{name}' never changes when a cell fires: no equation that leads to a spike uses it"


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


def _threshold(equations: CellEquations, limit: Crossing, state: dict[str, Any]) -> Iterator[str]:
    """Yield that a voltage cannot be meant to reach its threshold."""
    model, name = equations.model, limit.variable
    if model.variables[name].unit.dimension != VOLT:
        return
    size = float(np.abs(limit.value).max())
    named = f"the threshold, '{equations.threshold.strip()}', is {limit.value.flat[0] * 1e3:g} mV"
    if size >= _HIGHEST_V or 0.0 < size < _LOWEST_V:
        yield f"{named}; is it in another unit?"
        return
    after = _after_reset(model, limit, state)
    if after is not None and name in state:
        fall = np.max(limit.sign * (state[name] - after))
        if fall > _DEEPEST_V:
            yield f"the reset takes {name} {fall * 1e3:g} mV beyond where it begins; is a sign or unit wrong?"
        if (limit.sign * (after - limit.value) >= 0.0).all():
            where = "to" if (after == limit.value).all() else "beyond"
            yield f"the reset takes {name} {where} its threshold, '{equations.threshold.strip()}'"
    for value, where in ((state.get(name), "begins at"), (after, "is reset to")):
        if value is not None and np.abs(value - limit.value).max() > _FARTHEST_V:
            millivolts = np.atleast_1d(value).flat[0] * 1e3
            yield f"{named}, and {name} {where} {millivolts:g} mV; is one in another unit?"


def _after_reset(model: Model, limit: Crossing, state: dict[str, Any]) -> FloatArray | None:
    """Return the threshold's variable after a spike, in SI units; None if it is not set."""
    resets = dict(model.reset)
    if limit.variable not in resets:
        return None
    at_spike = {**state, limit.variable: limit.value}
    after: FloatArray | None = known_value(resets[limit.variable], at_spike, model.definitions)
    return after


def _time_constants(model: Model, membrane: str, state: dict[str, Any]) -> Iterator[str]:
    """Yield the time constants of a membrane and of synapses that are those of no neuron."""
    low, high = _TIME_CONSTANT_S
    for name in dict.fromkeys([membrane, *(effect.variable for effect in model.receptors.values())]):
        below = {**state, name: state.get(name, 0.0) - _BESIDE * model.variables[name].unit.scale}
        fastest = max(abs(drift(model, where, name, name)) for where in (state, below))
        if fastest and not low <= 1.0 / fastest <= high:
            yield f"{name} changes with a time constant of {1e3 / fastest:.4g} ms; is it in another unit?"


def _added_rests(model: Model, membrane: str, state: dict[str, Any]) -> Iterator[str]:
    """Yield the negative potentials that a membrane adds to its own, as in -(v + E_L)/tau."""
    if model.variables[membrane].unit.dimension != VOLT:
        return
    for name, unit in model.parameters.items():
        if unit.dimension != VOLT or name not in state:
            continue
        if np.max(state[name]) >= 0.0 or not is_added(model, state, membrane, name):
            continue
        volts = np.atleast_1d(state[name]).flat[0]
        yield (
            f"{membrane} is drawn to {-volts * 1e3:g} mV, the opposite of {name}, {volts * 1e3:g} mV: is a "
            f"sign wrong in d{membrane}/dt?"
        )


def _constant(model: Model, state: dict[str, Any]) -> Iterator[str]:
    """Yield the variables that stay at 0, and thresholds that are met by chance alone."""
    changed = {name for name, _ in model.reset} | {effect.variable for effect in model.receptors.values()}
    others = {*model.variables, INPUT, TIME}
    for name, variable in model.variables.items():
        rate = known_value(variable.rate, state, model.definitions)
        needs = reached([variable.rate], {}, model.definitions) & others - {name}
        # a timer or constant of the equations begins at another value
        if rate is not None and not (rate.any() or np.any(state.get(name, 0.0)) or needs or name in changed):
            yield f"'{name}' stays at 0: no spike or input changes it"
    for node in ast.walk(model.threshold):
        if not isinstance(node, ast.Compare) or not any(isinstance(op, ast.Eq) for op in node.ops):
            continue
        if any(name in model.variables and not _stands(model, name, state) for name in names_in(node)):
            yield f"the threshold has '{ast.unparse(node)}', which a value that changes in steps rarely meets"


def _stands(model: Model, name: str, state: dict[str, Any]) -> bool:
    """Return whether a variable changes with spikes alone, as a flag or a counter does."""
    rate = model.variables[name].rate
    needs = reached([rate], {}, model.definitions) & {*model.variables, INPUT, TIME}
    value = known_value(rate, state, model.definitions)
    return not needs and value is not None and not value.any()


def _reset(model: Model) -> Iterator[str]:
    changes = [name for name, value in model.reset if not (isinstance(value, ast.Name) and value.id == name)]
    if not model.lasts or not isinstance(model.threshold, ast.Compare):  # such as "... and v < before"
        return
    tested = reached([model.threshold], {}, model.definitions) & model.variables.keys()
    again = "a cell above its threshold fires again after every refractory period"
    if not changes:
        yield f"the reset changes nothing, so {again}"
    elif tested.isdisjoint(changes) and tested and all(model.variables[name].held for name in tested):
        names = ", ".join(sorted(tested))
        yield f"the reset does not change {names}, which the refractory period holds, so {again}"


def _beginning(
    equations: CellEquations, model: Model, state: dict[str, Any], step_ms: float | None
) -> Iterator[str]:
    fires = known_value(model.threshold, state, model.definitions)
    refractory = known_value(model.refractory, state, model.definitions)
    if fires is not None and fires.any():
        yield f"cells meet the threshold, '{equations.threshold.strip()}', from the start and fire at once"
    if refractory is None:
        return
    if model.lasts and refractory.max() > _LONGEST_S:
        yield f"the refractory period is {refractory.max():g} s; is it in another unit?"
    elif model.lasts and step_ms is not None and 0.0 < refractory.max() * 1e3 < step_ms * (1.0 - _ROUNDING):
        period = f"the refractory period is {refractory.max() * 1e3:g} ms"
        yield f"{period}, shorter than the time step of {step_ms:g} ms; is it in another unit?"
    elif not model.lasts and refractory.any():
        yield f"cells are refractory from the start, by '{equations.refractory.strip()}'"
