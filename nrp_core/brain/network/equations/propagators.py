"""Exact propagators of linear equations (Rotter & Diesmann 1999, Biological Cybernetics 81:381)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.linear import ONE, rates
from nrp_core.brain.network.equations.model import INPUT, Model
from nrp_core.brain.network.equations.values import value_of


def columns_of(model: Model) -> tuple[str, ...]:
    """Return the names by which propagators multiply: the state variables, the injected current, and 1."""
    return (*model.variables, INPUT, ONE)


def propagators(
    model: Model, parameters: Mapping[str, FloatArray], n: int, step_s: float, *, held: bool
) -> FloatArray:
    """Return the matrices that advance the state of cells by a step.

    The exponential of the matrix of the whole system, in which current and 1 are constant variables, is
    computed numerically (scaling and squaring), so equal time constants need no formula of their own.

    Args:
        model: linear equations.
        parameters: in SI units, shape ``(n,)``.
        n: number of cells.
        step_s: the step, s.
        held: whether the cells are refractory.

    Returns:
        Shape ``(n, n_variables, n_columns)``, or ``(1, ...)`` if all cells are equal.
    """
    return exponentials(matrices(model, parameters, n, held=held) * step_s)[:, : len(model.variables)]


def exponentials(matrix: FloatArray) -> FloatArray:
    """Return the exponentials of square matrices, shape ``(n, m, m)``, or ``(1, m, m)`` if all are equal."""
    from scipy.linalg import expm

    if (matrix == matrix[:1]).all():
        matrix = matrix[:1]
    found: FloatArray = expm(matrix)
    return found


def matrices(model: Model, parameters: Mapping[str, FloatArray], n: int, *, held: bool) -> FloatArray:
    """Return the matrices of linear equations, per s, shape ``(n, n_columns, n_columns)``."""
    coefficients = rates(model)
    assert coefficients is not None
    columns = columns_of(model)
    matrix = np.zeros((n, len(columns), len(columns)))
    for row, (name, variable) in enumerate(model.variables.items()):
        if held and variable.held:
            continue
        for key, coefficient in coefficients[name].items():
            matrix[:, row, columns.index(key)] = value_of(coefficient, parameters, model.definitions)
    return matrix


def pattern(model: Model, *, held: bool) -> npt.NDArray[np.bool_]:
    """Return which elements of propagators can differ from 0, for any parameters."""
    coefficients = rates(model)
    assert coefficients is not None
    columns = columns_of(model)
    reached = np.eye(len(columns), dtype=bool)
    for row, (name, variable) in enumerate(model.variables.items()):
        if not (held and variable.held):
            reached[row, [columns.index(key) for key in coefficients[name]]] = True
    for _ in columns:
        reached = reached @ reached
    return reached[: len(model.variables)]
