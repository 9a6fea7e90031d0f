"""Whether expressions are linear in the state of a cell, and with which coefficients."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Set
from dataclasses import replace
from typing import Final

from nrp_core.brain.network.equations.expressions import TIME, names_in
from nrp_core.brain.network.equations.model import INPUT, Model, Variable

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


def first_curved(model: Model) -> Variable | None:
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
        definitions: expressions that other names stand for.
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
            return None if a is None or b is None else _combined(a, op, b)
    return {ONE: node} if _is_constant(node, names, definitions) else None


def _combined(a: Coefficients, op: ast.operator, b: Coefficients) -> Coefficients | None:
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
