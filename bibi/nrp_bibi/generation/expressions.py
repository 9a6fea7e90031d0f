"""Expressions of the model as Python."""

from __future__ import annotations

import ast
import json
from functools import reduce
from math import copysign
from typing import Any

from nrp_bibi.model.expressions import (
    Add,
    Argument,
    ArgumentReference,
    Call,
    Constant,
    ConstantString,
    Divide,
    FlowExpression,
    Max,
    Min,
    Multiply,
    Operator,
    Scale,
    SimulationStep,
    Subtract,
)
from nrp_core.dsl import TIME

_FRAMEWORKS = ("hbp_nrp_client.tf_framework", "hbp_nrp_cle.tf_framework", "python_cle.tf_framework")
OPERATIONS: dict[type[Operator], type[ast.operator]] = {
    Add: ast.Add, Subtract: ast.Sub, Multiply: ast.Mult, Divide: ast.Div,
}  # fmt: skip
FUNCTIONS: dict[type[Operator], str] = {Min: "min", Max: "max"}


def as_python(expression: FlowExpression) -> ast.expr:
    """Return the syntax tree of an expression."""
    match expression:
        case Constant(value=value):
            return _number(value)
        case ConstantString(value=text):
            return ast.Constant(text)
        case SimulationStep():
            return ast.Name(TIME)
        case ArgumentReference(name=name, property=None):
            return ast.Name(name)
        case ArgumentReference(name=name, property=path):
            return dotted(f"{name}.{path}")
        case Scale(factor=factor, inner=inner):
            return ast.BinOp(_number(factor), ast.Mult(), as_python(inner))
        case Operator(operand=operands):
            return _operation(type(expression), [as_python(operand) for operand in operands])
        case Call(type=name, argument=arguments):
            return _call(name, arguments)
        case _:
            raise TypeError(f"no Python for {expression!r}")


def dotted(name: str) -> ast.expr:
    """Return the syntax tree of a name with dots."""
    first, *rest = name.split(".")
    start: ast.expr = ast.Name(first)
    return reduce(ast.Attribute, rest, start)


def in_framework(name: str) -> str:
    """Return the name of a library function in transfer functions: ``nrp.tf_lib.detect_red``."""
    for framework in _FRAMEWORKS:
        if name.startswith(f"{framework}."):
            return f"nrp{name.removeprefix(framework)}"
    return name


def literal(value: Any) -> str:
    """Return a text, a number, or lists and dictionaries of them, with double quotes."""
    return json.dumps(value, ensure_ascii=False)


def _number(value: float) -> ast.expr:
    number = ast.Constant(abs(value))
    return ast.UnaryOp(ast.USub(), number) if copysign(1, value) < 0 else number


def _operation(kind: type[Operator], operands: list[ast.expr]) -> ast.expr:
    if kind in FUNCTIONS:
        return ast.Call(ast.Name(FUNCTIONS[kind]), operands, [])
    return reduce(lambda left, right: ast.BinOp(left, OPERATIONS[kind](), right), operands)


def _call(name: str, arguments: tuple[Argument, ...]) -> ast.Call:
    positional = [as_python(argument.value) for argument in arguments if argument.name is None]
    named = [ast.keyword(one.name, as_python(one.value)) for one in arguments if one.name is not None]
    return ast.Call(dotted(in_framework(name)), positional, named)
