"""Whether expressions are linear in the state of a cell, and with which coefficients."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Set
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.network.equations.expressions import TIME, names_in
from nrp_core.network.equations.model import INPUT, Model, Variable, value_of

ONE: Final = ""
"""The key of the constant part of a linear expression."""
Coefficients = Mapping[str, ast.expr]
"""The coefficient of each name, and of ``ONE``."""


def rates(model: Model) -> Mapping[str, Coefficients] | None:
    """Return the coefficients of each derivative, or None if one is not linear in the state."""
    found = {}
    for name, variable in model.variables.items():
        coefficients = coefficients_of(variable.rate, {*model.variables, INPUT, TIME}, model.definitions)
        if coefficients is None or TIME in coefficients:
            return None
        found[name] = coefficients
    return found


def linear_part(model: Model) -> Model:
    """Return the equations with only the variables whose derivatives are linear in these variables.

    A cell that is refractory does not hold any of them.
    """
    found = {name: variable for name, variable in model.variables.items() if not variable.held}
    n_before = None
    while n_before != len(found):
        n_before, known = len(found), {*found, INPUT, ONE}
        inner = {
            name: coefficients_of(variable.rate, {*model.variables, INPUT, TIME}, model.definitions)
            for name, variable in found.items()
        }
        found = {name: found[name] for name, own in inner.items() if own is not None and own.keys() <= known}
    return replace(model, variables=found)


def first_nonlinear(model: Model) -> Variable | None:
    """Return the first variable whose derivative is not linear in the state."""
    for variable in model.variables.values():
        found = coefficients_of(variable.rate, {*model.variables, INPUT, TIME}, model.definitions)
        if found is None or TIME in found:
            return variable
    return None


def coefficients_of(
    node: ast.expr, names: Set[str], definitions: Mapping[str, ast.expr]
) -> Coefficients | None:
    """Return the coefficients of an expression that is linear in names; None if it is not.

    Args:
        node: the expression.
        names: the names.
        definitions: expressions by the names that represent them.
    """
    match node:
        case ast.Name(id=name):
            if name in definitions:
                return coefficients_of(definitions[name], names, definitions)
            return {name: ast.Constant(1.0)} if name in names else {ONE: node}
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return coefficients_of(operand, names, definitions)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = coefficients_of(operand, names, definitions)
            return None if inner is None else {key: ast.UnaryOp(ast.USub(), c) for key, c in inner.items()}
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as op, right=right):
            a, b = (coefficients_of(part, names, definitions) for part in (left, right))
            return None if a is None or b is None else _combine(a, op, b)
    return {ONE: node} if _is_constant(node, names, definitions) else None


def _combine(a: Coefficients, op: ast.operator, b: Coefficients) -> Coefficients | None:
    if isinstance(op, (ast.Add, ast.Sub)):
        total = dict(a)
        for key, coefficient in b.items():
            first = total.get(key)
            negative = coefficient if isinstance(op, ast.Add) else ast.UnaryOp(ast.USub(), coefficient)
            total[key] = negative if first is None else ast.BinOp(first, op, coefficient)
        return total
    if b.keys() <= {ONE}:
        return {key: ast.BinOp(c, op, b[ONE]) for key, c in a.items()}
    if isinstance(op, ast.Mult) and a.keys() <= {ONE}:
        return {key: ast.BinOp(a[ONE], op, c) for key, c in b.items()}
    return None


def _is_constant(node: ast.expr, names: Set[str], definitions: Mapping[str, ast.expr]) -> bool:
    return all(
        _is_constant(definitions[name], names, definitions) if name in definitions else name not in names
        for name in names_in(node)
    )


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


_ZERO: Final = ast.Constant(0.0)
_SLOWEST: Final = 1e-9
"""The least share of a step in which coefficients change, to divide by."""


class Driven(NamedTuple):
    """A variable ``x' = a x + b``.

    Args:
        factor: coefficients of a, by the names of variables, the current and 1.
        term: those of b.
    """

    factor: Coefficients
    term: Coefficients


class Integrals(NamedTuple):
    """The integral of a coefficient over a step, as a sum over the state at its beginning, for each cell.

    Args:
        whole: the integral.
        moment: the first moment about the middle of the step, in steps.
        size: a factor for which the sum of absolute values is a bound of the integral of the absolute value,
            and times the change in a step, of 12 moments.
    """

    whole: Mapping[str, FloatArray]
    moment: Mapping[str, FloatArray]
    size: Mapping[str, FloatArray]


def driven(model: Model) -> Mapping[str, Driven] | None:
    """Return the variables that are not in the linear part; None if one of them is not of this kind."""
    inner = linear_part(model)
    known = {*inner.variables, INPUT, ONE}
    found = {}
    for name, variable in model.variables.items():
        if name in inner.variables:
            continue
        own = coefficients_of(variable.rate, {name}, model.definitions)
        if own is None:
            return None
        names = {*model.variables, INPUT, TIME}
        parts = [coefficients_of(own.get(key, _ZERO), names, model.definitions) for key in (name, ONE)]
        factor, term = parts
        if factor is None or term is None or not factor.keys() | term.keys() <= known:
            return None
        found[name] = Driven(factor, term)
    return found


def columns(model: Model, coefficients: Coefficients) -> tuple[list[str], list[str]]:
    """Return the names over which the sums of the integral of a coefficient and of its moment go."""
    inner = linear_part(model)
    names = columns_of(inner)
    reached = np.zeros(len(names), dtype=bool)
    for row, name in zip(pattern(inner, held=False), inner.variables, strict=True):
        if name in coefficients:
            reached |= row
    moment = [name for name, is_reached in zip(names, reached, strict=True) if is_reached]
    return [name for name in names if name in moment or name in coefficients], moment


def integrals(
    model: Model, coefficients: Coefficients, parameters: Mapping[str, FloatArray], n: int, step_s: float
) -> Integrals:
    """Return the integrals of a coefficient.

    Args:
        model: the equations.
        coefficients: of the coefficient, by the names of variables, the current and 1.
        parameters: in SI units, shape ``(n,)``.
        n: number of cells.
        step_s: the step, s.
    """
    inner = linear_part(model)
    helpers = _helpers(model, inner, coefficients, step_s)
    extended = replace(inner, variables={**inner.variables, **helpers})
    moved = exponentials(matrices(extended, parameters, n, held=False) * step_s)
    change = np.maximum(fastest(model, parameters, n, step_s), _SLOWEST)
    first, names = len(inner.variables), columns_of(extended)
    of_whole, of_moment = columns(model, coefficients)

    def row(number: int, keys: list[str]) -> dict[str, FloatArray]:
        return {key: moved[:, number, names.index(key)] for key in keys}

    whole, moment = row(first, of_whole), row(first + 1, of_moment)
    size = {
        key: np.maximum(abs(value), 12.0 / change * abs(moment[key]) if key in moment else 0.0)
        for key, value in whole.items()
    }
    return Integrals(whole, moment, size)


def fastest(model: Model, parameters: Mapping[str, FloatArray], n: int, step_s: float) -> FloatArray:
    """Return the share by which the fastest variable of the linear part changes in a step, for each cell."""
    inner = linear_part(model)
    matrix = matrices(inner, parameters, n, held=False)[:, : len(inner.variables), : len(inner.variables)]
    rates: FloatArray = abs(np.linalg.eigvals(matrix)).max(axis=1, initial=0.0) * step_s
    return rates


def _helpers(model: Model, inner: Model, coefficients: Coefficients, step_s: float) -> dict[str, Variable]:
    """Return variables that are 0 at the beginning of a step, and the integral and the moment at its end.

    The third is the part of the integral that is due to variables; a constant has no moment.
    """
    like = next(iter(model.variables.values()))
    total, changing = (
        _sum({key: value for key, value in coefficients.items() if key in kept})
        for kept in ({*inner.variables, INPUT, ONE}, {*inner.variables})
    )
    half = ast.BinOp(changing, ast.Mult(), ast.Constant(0.5))
    before = ast.BinOp(ast.Name("3"), ast.Mult(), ast.Constant(1.0 / step_s))
    helpers = {"1": total, "2": ast.BinOp(half, ast.Sub(), before), "3": changing}
    return {name: replace(like, name=name, rate=rate) for name, rate in helpers.items()}


def _sum(coefficients: Coefficients) -> ast.expr:
    total: ast.expr = _ZERO
    for name, value in coefficients.items():
        part = value if name == ONE else ast.BinOp(value, ast.Mult(), ast.Name(name))
        total = ast.BinOp(total, ast.Add(), part)
    return total
