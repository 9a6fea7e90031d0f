"""Bounds of colours with which no pixel is found, and places in images that are read the wrong way round."""

from __future__ import annotations

import ast
import operator
from collections.abc import Iterator
from typing import Any, Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.events import Call
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.tf_lib.vision import find_centroid_hsv, wrong_bounds
from nrp_core.findings import Code, Finding, Level

_ARITHMETIC: Final = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
}  # fmt: skip
_COPIES: Final = ("array", "asarray", "list", "tuple")
"""Functions that return the numbers they are given."""
_LARGEST_BYTE: Final = 255


@checks_function(Code.NRP358)
def colors_can_be_found(function: CheckedFunction) -> Iterator[Finding]:
    """Look for HSV bounds that no pixel meets, or that are in another scale than OpenCV's."""
    for event in function.events:
        match event:
            case Call(node, Known(callee)) if callee is find_centroid_hsv:
                bounds = [_numbers(function, one) for one in node.args[1:]]
                if len(bounds) == 1 and isinstance(node.args[1], ast.Starred):
                    bounds = bounds[0] or []
                if len(bounds) != 2 or not all(_is_triple(one) for one in bounds):
                    continue
                wrong = wrong_bounds(*bounds)
                if wrong:
                    message = f"no colour is found: {wrong}"
                    yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


@checks_function(Code.NRP358)
def bounds_of_bytes_can_be_met(function: CheckedFunction) -> Iterator[Finding]:
    """Look for bounds of ``cv2.inRange`` that exclude all bytes, or that no byte reaches."""
    for node in function.declared.own:
        match node:
            case ast.Call(func, [_, low, high], []) if last_name(func) == "inRange":
                lower, upper = _numbers(function, low), _numbers(function, high)
                if not (_is_triple(lower) and _is_triple(upper) and len(lower) == len(upper)):
                    continue
                wrong = next((f"{one:g} is above {other:g}" for one, other in zip(lower, upper, strict=True)
                              if one > other), "")  # fmt: skip
                if wrong:
                    message = f"no colour is found: the lower bound {wrong}, the upper one"
                elif max(upper) > _LARGEST_BYTE:
                    message = f"{max(upper):g} bounds nothing: bytes end at 255, and a hue of OpenCV at 179"
                else:
                    continue
                yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


def _numbers(function: CheckedFunction, node: ast.expr) -> Any:
    """Return the value of constants, of names for them and of arithmetic with them; None for others."""
    try:
        return _value(function, node.value if isinstance(node, ast.Starred) else node)
    except (TypeError, ArithmeticError):
        return None


def _value(function: CheckedFunction, node: ast.expr) -> Any:
    match node:
        case ast.Constant(value) if isinstance(value, (int, float)):
            return value
        case ast.Name(name):
            shape = function.declared.names.get(name)
            given = _assigned(function, name)
            if given is None:
                return shape.value if isinstance(shape, Known) else None
            return _value(function, given)
        case ast.Tuple(items) | ast.List(items):
            return [_value(function, one) for one in items]
        case ast.Call(func, [items, *_]) if last_name(func) in _COPIES:
            return _value(function, items)
        case ast.UnaryOp(ast.USub(), operand):
            return -_value(function, operand)
        case ast.BinOp(left, op, right) if type(op) in _ARITHMETIC:
            numbers = _value(function, left), _value(function, right)
            if all(type(one) in (int, float) for one in numbers):
                return _ARITHMETIC[type(op)](*numbers)
    return None


def _assigned(function: CheckedFunction, name: str) -> ast.expr | None:
    """Return what a function assigns to a name of its own, if it does so once and in one place."""
    given: list[ast.expr | None] = []
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Name(target)], value) if target == name:
                given.append(value)
            case ast.Name(target, ast.Store()) if target == name:
                given.append(None)
    known = [value for value in given if value is not None]
    return known[0] if len(known) == 1 and len(given) == 2 else None


def _is_triple(value: Any) -> bool:
    return isinstance(value, tuple | list) and all(type(one) in (int, float) for one in value)
