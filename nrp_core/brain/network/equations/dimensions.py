"""The physical dimension of an expression."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from fractions import Fraction
from typing import Final

from nrp_core.brain.network.equations.expressions import TextOrigin
from nrp_core.brain.network.equations.units import NONE, Dimension, described, times

TRUTH: Final[Dimension] = (Fraction(1),)
"""That of a condition."""
ANY: Final[Dimension] = (Fraction(0),)
"""That of a bare 0, which is 0 in any unit."""
_SAME: Final = frozenset({"abs", "floor", "ceil", "clip", "min", "max"})
"""Functions whose value has the unit of their arguments."""


def dimension_of(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    """Return the dimension of an expression.

    Args:
        node: the expression.
        names: the dimensions of the names in it.
        place: where it was written.

    Raises:
        NetworkError: units do not fit together.
    """
    match node:
        case ast.Name(id=name):
            return names[name]
        case ast.Constant(value=value):
            return TRUTH if isinstance(value, bool) else ANY if value == 0 else NONE
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            _require_truth(operand, names, place)
            return TRUTH
        case ast.UnaryOp(operand=operand):
            return _number(operand, names, place)
        case ast.BoolOp(values=parts):
            for part in parts:
                _require_truth(part, names, place)
            return TRUTH
        case ast.Compare(left=left, comparators=others):
            _alike([left, *others], names, place, "compares")
            return TRUTH
        case ast.BinOp():
            return _of_operation(node, names, place)
        case ast.Call(func=ast.Name(id=function), args=arguments):
            return _of_function(function, arguments, names, place)
    raise AssertionError(ast.dump(node))


def require_dimension(
    node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin, expected: Dimension, what: str
) -> None:
    """Refuse an expression that does not have a dimension.

    Args:
        node: the expression.
        names: the dimensions of the names in it.
        place: where it was written.
        expected: the dimension; ``TRUTH`` for a condition.
        what: what has that dimension, for the message.

    Raises:
        NetworkError: it has another one.
    """
    found = dimension_of(node, names, place)
    if found not in (expected, ANY) or (found == ANY and expected == TRUTH):
        place.refuse(f"'{ast.unparse(node)}' {_is(found)}, but {what} {_is(expected)}")


def _is(of: Dimension) -> str:
    if of == TRUTH:
        return "is a condition"
    return "is a number without a unit" if of in (NONE, ANY) else f"is in {described(of)}"


def _number(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    found = dimension_of(node, names, place)
    if found == TRUTH:
        place.refuse(f"'{ast.unparse(node)}' is a condition; as a number, 1 or 0, it is int(...)")
    return found


def _require_truth(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> None:
    require_dimension(node, names, place, TRUTH, "a part of a condition")


def _alike(nodes: list[ast.expr], names: Mapping[str, Dimension], place: TextOrigin, verb: str) -> Dimension:
    """Return the dimension that expressions share."""
    found = [(node, _number(node, names, place)) for node in nodes]
    known = [(node, of) for node, of in found if of != ANY]
    for node, of in known[1:]:
        if of != known[0][1]:
            first = known[0][0]
            place.refuse(
                f"{verb} '{ast.unparse(first)}', which {_is(known[0][1])}, and '{ast.unparse(node)}', which "
                f"{_is(of)}"
            )
    return known[0][1] if known else ANY


def _of_operation(node: ast.BinOp, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    if isinstance(node.op, (ast.Add, ast.Sub, ast.Mod)):
        verb = {ast.Add: "adds", ast.Sub: "subtracts", ast.Mod: "divides"}[type(node.op)]
        return _alike([node.left, node.right], names, place, verb)
    if isinstance(node.op, ast.FloorDiv):  # a whole number of what has a unit would depend on the unit
        _alike([node.left, node.right], names, place, "counts by //")
        return NONE
    base = _number(node.left, names, place)
    if isinstance(node.op, ast.Pow):
        return _power(base, node, names, place)
    second = _number(node.right, names, place)
    if ANY in (base, second):
        return ANY if base == ANY else NONE if isinstance(node.op, ast.Div) else ANY
    return times(base, second, 1 if isinstance(node.op, ast.Mult) else -1)


def _power(base: Dimension, node: ast.BinOp, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    require_dimension(node.right, names, place, NONE, "an exponent")
    if base in (NONE, ANY):
        return base
    try:
        exponent = ast.literal_eval(node.right)
    except ValueError:
        place.refuse(f"'{ast.unparse(node)}': the exponent of a number with a unit is itself a plain number")
    power = Fraction(exponent).limit_denominator(12)
    return tuple(power * one for one in base)


def _of_function(
    name: str, arguments: list[ast.expr], names: Mapping[str, Dimension], place: TextOrigin
) -> Dimension:
    if name == "int":
        dimension_of(arguments[0], names, place)
        return NONE
    if name in _SAME:
        return _alike(arguments, names, place, f"{name} compares")
    found = _number(arguments[0], names, place)
    if name == "sqrt" and found != ANY:
        return tuple(one / 2 for one in found)
    if name != "sign" and found not in (NONE, ANY):
        place.refuse(
            f"{name} takes a number without a unit, and '{ast.unparse(arguments[0])}' {_is(found)}; divide "
            "it by a scale"
        )
    return NONE
