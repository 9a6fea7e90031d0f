"""Whether a linear cell without input may still reach its threshold.

Between spikes, the state of a cell with linear equations returns to a point of rest, and the excess over
its threshold is a linear function of the state. How much it can grow from now on is therefore bounded by the
state and by the extremes of its impulse responses.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.network.equations.expressions import TIME
from nrp_core.network.equations.linear import (
    Coefficients,
    coefficients_of,
    columns_of,
    exponentials,
    matrices,
)
from nrp_core.network.equations.model import EXACT, INPUT, Model, value_of

N_FINE: Final = 64
"""Propagators are known by 0, 1, ... steps up to this number, and by as many of its multiples."""
_SLOWEST: Final = 1e5
"""The longest time constant, in steps, of a cell that comes to rest."""
_NEGLIGIBLE: Final = 1e-9
"""The share of an impulse response that counts as rest; it is added to the extremes."""


class Bound(NamedTuple):
    """The highest excess over the threshold in later steps, for cells with equal parameters.

    With d the distances of the variables from rest, it is at most the excess at rest plus the sum of
    ``max(highest * d, lowest * d)``.

    Args:
        rest: the state at rest without current, and its change by 1 A; shape ``(2, n_variables)``.
        excess: the excess over the threshold at rest, in the same way, shape ``(2,)``.
        highest, lowest: the extremes of the excess that is due to a unit of each variable.
        size: an excess that is small compared with that of a typical state.
    """

    rest: FloatArray
    excess: FloatArray
    highest: FloatArray
    lowest: FloatArray
    size: float


def excess_of(model: Model) -> Coefficients | None:
    """Return the coefficients of an excess without which a cell does not fire; None if none is linear.

    A spike needs an excess of 0 or more. If several conditions must be met, it is that of the first one.
    """
    conditions = [model.threshold]
    while conditions:
        match conditions.pop(0):
            case ast.BoolOp(op=ast.And(), values=values):
                conditions += values
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                if isinstance(op, (ast.Lt, ast.LtE)):
                    left, right = right, left
                elif not isinstance(op, (ast.Gt, ast.GtE)):
                    continue
                names = {*model.variables, INPUT, TIME}
                found = coefficients_of(ast.BinOp(left, ast.Sub(), right), names, model.definitions)
                if found is not None and TIME not in found:
                    return found
    return None


def obstacle(model: Model) -> str:
    """Return why the state of a cell between events cannot be predicted, or an empty text."""
    if model.on_step:
        return "changes its state in every step"
    if model.method != EXACT:
        return "has equations that are not linear, or are integrated"
    if model.is_random:
        return "has a random threshold"
    if not model.lasts:
        return "has a refractory period that a condition ends"
    if excess_of(model) is None:
        return "has a threshold that is not linear in its state"
    return ""


def excess_at_rest(model: Model, parameters: Mapping[str, FloatArray]) -> FloatArray:
    """Return the excess over the threshold at rest with the constant current, for each cell.

    Infinite for a cell that does not come to rest.

    Args:
        model: equations without an :func:`obstacle`.
        parameters: in SI units, of shapes that are equal or 1.
    """
    n = len(model.variables)
    matrix = matrices(model, parameters, max(map(len, parameters.values()), default=1), held=False)
    comes = (np.linalg.eigvals(matrix[:, :n, :n]).real < 0.0).all(axis=1)
    matrix[~comes, :n, :n] = -np.eye(n)
    _, excess = _at_rest(model, parameters, matrix)
    total: FloatArray = excess[:, 0] + excess[:, 1] * parameters.get(INPUT, 0.0)
    return np.where(comes, total, np.inf)


def powers(model: Model, parameters: Mapping[str, FloatArray], step_s: float, *, held: bool) -> FloatArray:
    """Return the propagators of a cell by 0, 1, ... steps, then by 0, 1, ... times ``N_FINE`` steps.

    Args:
        model: equations without an :func:`obstacle`.
        parameters: in SI units, shape ``(1,)``.
        step_s: the step, s.
        held: whether the cell is refractory.

    Returns:
        Shape ``(2 * N_FINE, n_columns, n_columns)``.
    """
    steps = np.concatenate([np.arange(N_FINE), np.arange(N_FINE) * N_FINE])
    (matrix,) = matrices(model, parameters, 1, held=held)
    found = exponentials(matrix * (steps * step_s)[:, None, None])
    return np.broadcast_to(found, (len(steps), *matrix.shape))  # one where nothing moves


def bound(model: Model, parameters: Mapping[str, FloatArray], free: FloatArray) -> Bound:
    """Return the bound of a cell; infinite if it does not come to rest.

    Args:
        model: equations without an :func:`obstacle`.
        parameters: in SI units, shape ``(1,)``.
        free: its :func:`powers`.
    """
    n = len(model.variables)
    highest, lowest = np.zeros(n), np.zeros(n)
    if abs(np.linalg.eigvals(free[1, :n, :n])).max() > 1.0 - 1.0 / _SLOWEST:
        return Bound(np.zeros((2, n)), np.array([np.inf, 0.0]), highest, lowest, 0.0)
    rest, excess = _at_rest(model, parameters, matrices(model, parameters, 1, held=False))
    weights = _weights(model, parameters, 1)[0, :n]
    fine, coarse = free[:N_FINE, :n, :n], free[N_FINE:, :n, :n]
    responses = ((weights @ fine @ free[1, :n, :n]) @ coarse).reshape(-1, n)  # by 1, 2, ... steps
    while True:
        highest = np.maximum(highest, responses.max(axis=0))
        lowest = np.minimum(lowest, responses.min(axis=0))
        slack = _NEGLIGIBLE * np.maximum(highest, -lowest)
        if (abs(responses).max(axis=0) <= slack).all():
            break
        responses = responses @ coarse[-1] @ coarse[1]
    sizes = [variable.unit.scale for variable in model.variables.values()]
    return Bound(rest[0], excess[0], highest + slack, lowest - slack, float(abs(weights) @ sizes))


def _at_rest(
    model: Model, parameters: Mapping[str, FloatArray], matrix: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return state and excess at rest without current and by 1 A, for each cell, from its matrix."""
    n = len(model.variables)
    of_1_and_current = [n + 1, n]
    drives = matrix[:, :n, of_1_and_current]
    rest = np.asarray(-np.linalg.solve(matrix[:, :n, :n], drives), np.float64).transpose(0, 2, 1)
    weights = _weights(model, parameters, len(matrix))
    return rest, (rest @ weights[:, :n, None])[:, :, 0] + weights[:, of_1_and_current]


def _weights(model: Model, parameters: Mapping[str, FloatArray], n: int) -> FloatArray:
    """Return the coefficients of the excess by cell and column."""
    coefficients, columns = excess_of(model), columns_of(model)
    assert coefficients is not None
    found = np.zeros((n, len(columns)))
    for key, coefficient in coefficients.items():
        found[:, columns.index(key)] = value_of(coefficient, parameters, model.definitions)
    return found
