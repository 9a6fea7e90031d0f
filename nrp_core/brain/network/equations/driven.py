"""Variables with conductances: linear in themselves, with coefficients that are linear in others.

``x' = a(t) x + b(t)``, where a and b are sums of variables that are linear and do not depend on x, so that
they are known in the whole step. Then the fourth-order Magnus expansion needs only the integrals of a and b
over the step and their first moments (Blanes et al. 2009, Physics Reports 470:151).
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.expressions import TIME
from nrp_core.brain.network.equations.linear import ONE, Coefficients, coefficients_of, linear_part
from nrp_core.brain.network.equations.model import INPUT, Model, Variable
from nrp_core.brain.network.equations.propagators import columns_of, exponentials, matrices, pattern

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
