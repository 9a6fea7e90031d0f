"""The values of expressions of parameters, for all cells at once."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

_OPERATIONS: Final[Mapping[type, Callable[..., Any]]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.true_divide,
    ast.FloorDiv: np.floor_divide, ast.Mod: np.mod, ast.Pow: np.power, ast.USub: np.negative,
    ast.UAdd: np.positive, ast.Not: np.logical_not, ast.Gt: np.greater, ast.GtE: np.greater_equal,
    ast.Lt: np.less, ast.LtE: np.less_equal, ast.Eq: np.equal, ast.NotEq: np.not_equal,
}  # fmt: skip
_FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
    "abs": np.abs, "min": np.minimum, "max": np.maximum, "clip": np.clip, "int": np.trunc,
    "exprel": lambda x: np.where(x == 0.0, 1.0, np.expm1(x) / np.where(x == 0.0, 1.0, x)),
}  # fmt: skip


def value_of(node: ast.expr, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    """Return the value of an expression, in SI units.

    Args:
        node: the expression.
        known: the values of names, numbers or arrays of one shape.
        definitions: expressions that other names stand for.

    Raises:
        KeyError: the expression needs a name without a value.
    """

    def of(part: ast.expr) -> Any:
        return value_of(part, known, definitions)

    with np.errstate(all="ignore"):
        match node:
            case ast.Constant(value=value):
                assert isinstance(value, (int, float))
                return value if isinstance(value, bool) else float(value)
            case ast.Name(id=name):
                return _named(name, known, definitions)
            case ast.UnaryOp(op=op, operand=operand):
                return _OPERATIONS[type(op)](of(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return _OPERATIONS[type(op)](of(left), of(right))
            case ast.BoolOp(op=op, values=values):
                combine = np.logical_and if isinstance(op, ast.And) else np.logical_or
                return combine.reduce(np.broadcast_arrays(*map(of, values)))
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [of(part) for part in (left, *others)]
                pairs = zip(sides, ops, others and sides[1:], strict=False)
                return np.logical_and.reduce(
                    np.broadcast_arrays(*(_OPERATIONS[type(op)](a, b) for a, op, b in pairs))
                )
            case ast.Call(func=ast.Name(id=name), args=arguments):
                return _FUNCTIONS.get(name, getattr(np, name, None))(*map(of, arguments))  # type: ignore[misc]
    raise AssertionError(ast.dump(node))


def _named(name: str, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    if name in known:
        return known[name]
    if name in definitions:
        return value_of(definitions[name], known, definitions)
    raise KeyError(name)


def known_value(node: ast.expr, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    """Return the value of an expression, an array; None if it depends on names without one."""
    try:
        return np.atleast_1d(value_of(node, known, definitions))
    except KeyError:
        return None
