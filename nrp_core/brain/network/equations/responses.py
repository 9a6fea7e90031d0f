"""How cells given as equations respond: what takes them to their threshold, and how fast they forget."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.equations.doubts import Values, known_value
from nrp_core.brain.network.equations.expressions import TIME, names_in
from nrp_core.brain.network.equations.linear import coefficients_of
from nrp_core.brain.network.equations.model import INPUT, Model

_STEP: Final = 1e-4
"""The step of differences, in the unit of a variable."""
_NOISE: Final = 1e-9
"""A difference that is smaller, as a share of the values, is rounding."""
_SHIFT: Final = 5.0
"""In the unit of a variable: where a term is not linear, its slope is another one so far away."""
_SMALL: Final = 1e-6
"""A share of the largest rate that stands for none."""
_ON_THE_WAY: Final = (1.0, 0.75, 0.5, 0.25)
"""From where a variable begins to its threshold."""
_UPSTROKE: Final = 1e6
"""A rate, in the unit of a variable for each second, that input does not change; 1 V/ms."""
_RISING: Final = (ast.Gt, ast.GtE)
_FALLING: Final = (ast.Lt, ast.LtE)
State = Mapping[str, Any]


class Crossing(NamedTuple):
    """The first comparison of a threshold: a cell fires when a variable passes a limit.

    Args:
        variable: the state variable.
        value: the limit of each cell, or one of all, in SI units.
        sign: 1 if the cell fires above the limit, -1 below.
    """

    variable: str
    value: FloatArray
    sign: int


def beginning(equations: CellEquations, parameters: Values, states: Values, cells: int) -> dict[str, Any]:
    """Return the parameters and state of the first cells at time 0, in SI units.

    Args:
        equations: the texts.
        parameters: every parameter in its unit, shape ``(n,)``.
        states: initial values of state variables, in their units.
        cells: how many cells.
    """
    variables = equations.model.variables
    known: dict[str, Any] = equations.in_si({name: array[:cells] for name, array in parameters.items()})
    known |= {
        name: array[:cells] * variables[name].unit.scale
        for name, array in states.items()
        if name in variables
    }
    return {TIME: 0.0, INPUT: 0.0, **known}


def crossing(model: Model, state: State) -> Crossing | None:
    """Return where the threshold lies; None if it is not a limit of one state variable."""
    for node in ast.walk(model.threshold):
        match node:
            case ast.Compare(left=left, ops=[op], comparators=[right]) if isinstance(op, _RISING + _FALLING):
                name = _set_back(model, [*names_in(left), *names_in(right)])
                if not name:
                    continue
                above = ast.BinOp(left, ast.Sub(), right)
                parts = coefficients_of(above, {name}, model.definitions)
                if parts is None or name not in parts:
                    continue
                slope = known_value(parts[name], state, model.definitions)
                rest = known_value(above, {**state, name: 0.0}, model.definitions)
                if slope is not None and rest is not None and slope.flat[0]:
                    is_rising = isinstance(op, _RISING) == bool(slope.flat[0] > 0.0)
                    return Crossing(name, -rest / slope, 1 if is_rising else -1)
    return None


def before_upstroke(model: Model, state: State, limit: Crossing) -> FloatArray:
    """Return the value nearest to a threshold at which input decides whether the cell fires.

    A threshold is often the peak of a spike, where the cell rises by itself, so fast that no input matters.
    """
    variable = model.variables[limit.variable]
    begins = np.asarray(state.get(limit.variable, limit.value))
    for share in _ON_THE_WAY:
        value: FloatArray = begins + share * (limit.value - begins)
        rate = known_value(variable.rate, {**state, limit.variable: value}, model.definitions)
        if rate is None or np.abs(rate).max() < _UPSTROKE * variable.unit.scale:
            return value
    return limit.value


def _set_back(model: Model, names: list[str]) -> str:
    """Return the one state variable among names; of several the one that the reset sets to a new value."""
    compared = dict.fromkeys(name for name in names if name in model.variables)
    if len(compared) > 1:  # a threshold that adapts is raised, not set
        compared = dict.fromkeys(
            name for name, value in model.reset if name in compared and name not in names_in(value)
        )
    return next(iter(compared)) if len(compared) == 1 else ""


def drift(model: Model, state: State, variable: str, of: str) -> float:
    """Return how the derivative of a variable changes with another or with the injected current.

    It is that of the first cell, in SI units; 0 where the derivative does not depend on it, or has no value.
    """
    rate = model.variables[variable].rate
    scale = model.parameters[INPUT].scale if of == INPUT else model.variables[of].unit.scale
    step = _STEP * scale
    here = np.atleast_1d(state.get(of, 0.0)).flat[0]
    ends = [known_value(rate, {**state, of: here + shift}, model.definitions) for shift in (-step, step)]
    if ends[0] is None or ends[1] is None:
        return 0.0
    low, high = (float(end.flat[0]) for end in ends)
    change = high - low
    return change / (2.0 * step) if abs(change) > _NOISE * (abs(low) + abs(high)) else 0.0


def is_added(model: Model, state: State, variable: str, parameter: str) -> bool:
    """Return whether a derivative has a term -(variable + parameter) * rate, at any value of the variable.

    Args:
        model: the equations.
        state: parameters and state in SI units.
        variable: the variable.
        parameter: a parameter in its unit.
    """
    rate, shift = model.variables[variable].rate, _SHIFT * model.variables[variable].unit.scale
    at_start, value = state.get(variable, 0.0), state[parameter]
    moved = [at_start + k * shift for k in (-1.0, 0.0, 1.0)]
    rates = [
        [known_value(rate, {**state, variable: v, parameter: value + p}, model.definitions) for v in moved]
        for p in (-shift, 0.0, shift)
    ]
    if any(one is None for row in rates for one in row):
        return False
    by = np.array([[float(one.flat[0]) for one in row] for row in rates])
    slopes = np.diff(by, axis=0)
    noise = _SMALL * np.abs(by).max()
    return bool(slopes.max() < -noise and np.ptp(slopes) <= noise and by[1, 2] < by[1, 0])


def direction(model: Model, state: State, target: str, cause: str) -> int:
    """Return in which direction more of a cause first moves a variable: 1, -1, or 0 for not at all.

    Args:
        model: the equations.
        state: parameters and state in SI units.
        target: the variable.
        cause: a variable, or the injected current.
    """
    names = list(model.variables)
    slopes = np.array([[drift(model, state, row, of) for of in names] for row in names])
    np.fill_diagonal(slopes, 0.0)  # what a variable does to itself comes after what moved it
    if cause in model.variables:
        moved = np.array([float(name == cause) for name in names])
    else:
        moved = np.array([drift(model, state, row, cause) for row in names])
    for _ in names:
        if moved[names.index(target)]:
            break
        moved = slopes @ moved
    return int(np.sign(moved[names.index(target)]))
