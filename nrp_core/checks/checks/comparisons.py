"""Comparisons of fields of messages that raise an error or are never true."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import get_origin

from nrp_core.checks.events import Add, Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Known, Number, hints
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP247)
def arrays_are_not_truth_values(function: CheckedFunction) -> Iterator[Finding]:
    """Look for conditions that compare a whole array, which has many answers."""
    arrays = _fields(function, "numpy.ndarray")
    for test in _tests(function):
        match test:
            case ast.Compare(left, [_], [right]):
                field = next((one for one in (left, right) if id(one) in arrays), None)
                if field is not None and not isinstance(test.ops[0], ast.In | ast.NotIn | ast.Is | ast.IsNot):
                    text = excerpt(test)
                    message = (
                        f"'{ast.unparse(field)}' is an array: '{text}' has an answer for each item; "
                        f"write ({text}).all(), or .any()"
                    )
                    yield function.declared.finding(Code.NRP247, test, message)


@checks_function(Code.NRP248)
def lists_are_compared_with_lists(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that are lists and are compared with tuples, which never equal them."""
    lists = _fields(function, "list")
    for node in function.declared.own:
        match node:
            case ast.Compare(left, [ast.Eq() | ast.NotEq()], [right]):
                for one, other in ((left, right), (right, left)):
                    if id(one) in lists and _is_tuple(function, other):
                        message = (
                            f"'{ast.unparse(one)}' is a list: it never equals a tuple, '{ast.unparse(other)}'"
                        )
                        yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def measured_numbers_are_compared_with_a_margin(function: CheckedFunction) -> Iterator[Finding]:
    """Look for rates and voltages that are asked to be exactly equal."""
    for event in function.events:
        match event:
            case Add(ast.Compare(_, [ast.Eq()], [_]) as node, Number(first), Number(second)):
                if first and first == second:
                    one, other = ast.unparse(node.left), ast.unparse(node.comparators[0])
                    message = (
                        f"'{excerpt(node)}' compares two measured numbers, which are hardly ever "
                        f"exactly equal unless both are 0; write abs({one} - {other}) < ..."
                    )
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


def _fields(function: CheckedFunction, kind: str) -> set[int]:
    """Return the places where a body reads fields of messages of a kind."""
    found = set()
    for event in function.events:
        match event:
            case Read(node, Instance(cls), name, True):
                hint = hints(cls).get(name)
                if (hint is not None and get_origin(hint) is list) if kind == "list" else kind in str(hint):
                    found.add(id(node))
    return found


def _tests(function: CheckedFunction) -> Iterator[ast.expr]:
    """Yield the expressions of a body whose truth is asked for."""
    for node in function.declared.own:
        match node:
            case ast.If(test) | ast.While(test) | ast.IfExp(test) | ast.Assert(test):
                yield test
            case ast.BoolOp(values=values):
                yield from values
            case ast.UnaryOp(ast.Not(), operand):
                yield operand


def _is_tuple(function: CheckedFunction, node: ast.expr) -> bool:
    if isinstance(node, ast.Name):
        shape = function.declared.names.get(node.id)
        return isinstance(shape, Known) and isinstance(shape.value, tuple)
    return isinstance(node, ast.Tuple)
