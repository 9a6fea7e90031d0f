"""Python expressions as building blocks."""

from __future__ import annotations

import ast
from collections.abc import Set

from nrp_bibi.generation.expressions import FUNCTIONS, OPERATIONS
from nrp_bibi.model.expressions import (
    Argument,
    ArgumentReference,
    Call,
    Constant,
    ConstantString,
    FlowExpression,
    Operator,
    Scale,
    SimulationStep,
)
from nrp_bibi.reverse.refusal import NotExpressibleError
from nrp_core.dsl import TIME

_KINDS = {python: kind for kind, python in OPERATIONS.items()}
_BY_NAME = {name: kind for kind, name in FUNCTIONS.items()}


def as_expression(node: ast.expr, known: Set[str]) -> FlowExpression:
    """Return an expression as building blocks.

    Args:
        node: the syntax tree of the expression.
        known: the names of channels and locals.

    Raises:
        NotExpressibleError: building blocks cannot express it.
    """
    match node:
        case ast.Constant(value=str() as text):
            return ConstantString(value=text)
        case ast.Constant() | ast.UnaryOp():
            return Constant(value=number(node))
        case ast.Name(id=name) if name == TIME:
            return SimulationStep()
        case ast.Name() | ast.Attribute():
            return _reference(node, known)
        case ast.BinOp(left=left, op=ast.Mult(), right=right) if _is_number(left):
            return Scale(factor=number(left), inner=as_expression(right, known))
        case ast.BinOp(op=operator) if type(operator) in _KINDS:
            operands = tuple(as_expression(operand, known) for operand in _chain(node))
            return _KINDS[type(operator)](operand=operands)
        case ast.Call():
            return _call(node, known)
        case _:
            raise NotExpressibleError.of(node)


def dotted_name(node: ast.expr) -> str:
    """Return a name with dots.

    Raises:
        NotExpressibleError: the node is not a name.
    """
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=owner, attr=name):
            return f"{dotted_name(owner)}.{name}"
        case _:
            raise NotExpressibleError.of(node)


def number(node: ast.expr) -> float:
    """Return a number, with its sign.

    Raises:
        NotExpressibleError: the node is not a number.
    """
    match node:
        case ast.Constant(value=bool()):
            raise NotExpressibleError.of(node)
        case ast.Constant(value=int() | float() as value):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant() as positive):
            return -number(positive)
        case _:
            raise NotExpressibleError.of(node)


def _is_number(node: ast.expr) -> bool:
    try:
        number(node)
    except NotExpressibleError:
        return False
    return True


def _reference(node: ast.expr, known: Set[str]) -> ArgumentReference:
    name, _, path = dotted_name(node).partition(".")
    if name not in known:
        raise NotExpressibleError.of(node)
    return ArgumentReference(name=name, property=path or None)


def _chain(node: ast.BinOp) -> list[ast.expr]:
    """Return the operands of a chain of one operator."""
    left = node.left
    if not isinstance(left, ast.BinOp) or type(left.op) is not type(node.op) or _is_scale(left):
        return [left, node.right]
    return [*_chain(left), node.right]


def _is_scale(node: ast.BinOp) -> bool:
    return isinstance(node.op, ast.Mult) and _is_number(node.left)


def _call(node: ast.Call, known: Set[str]) -> FlowExpression:
    name = dotted_name(node.func)
    if name in _BY_NAME and len(node.args) > 1 and not node.keywords:
        kind: type[Operator] = _BY_NAME[name]
        return kind(operand=tuple(as_expression(operand, known) for operand in node.args))
    positional = [Argument(value=as_expression(value, known)) for value in node.args]
    named = [
        Argument(name=one.arg, value=as_expression(one.value, known)) for one in node.keywords if one.arg
    ]
    if len(named) < len(node.keywords):
        raise NotExpressibleError.of(node)
    return Call(type=name, argument=(*positional, *named))
