"""Expressions that look computed but have a fixed value, or one of two, for all inputs."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import Any, Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.checks.angles import single_values
from nrp_core.checks.declared import found_in
from nrp_core.checks.events import Call
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.messages.std_msgs import Float64

_LARGER: Final = frozenset({"np.maximum", "numpy.maximum", "np.fmax", "numpy.fmax"})
_SMALLER: Final = frozenset({"np.minimum", "numpy.minimum", "np.fmin", "numpy.fmin"})
_NOT_NEGATIVE: Final = ("abs", "fabs", "len", "hypot", "sqrt", "norm")
_CLIPS: Final = frozenset({"np.clip", "numpy.clip"})


@checks_function(Code.NRP320)
def numbers_are_not_rounded_away(function: CheckedFunction) -> Iterator[Finding]:
    """Look for constants that rounding turns into 0."""
    for event in function.events:
        match event:
            case Call(node, Known(callee), (Known(int() | float() as value),)) if (
                callee is int or callee is round
            ):
                if 0 < abs(value) < 1 and not callee(value):
                    text = excerpt(node)
                    message = f"'{text}' is always 0: it rounds {value:g}"
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def commands_are_not_rounded(function: CheckedFunction) -> Iterator[Finding]:
    """Look for speeds and angles in m/s, rad/s and rad that are rounded to whole numbers."""
    topics = [function.world.topics.get(one.name) for one in function.function.published]
    is_of_joints = {info.unit for info in topics if info is not None} == {"rad"}
    moves = is_of_joints or any(info is not None and info.type is Twist for info in topics)
    made = single_values(function)
    for event in function.events:
        match event:
            case Call(node, Known(callee)) if moves and callee in (Vector3, *[Float64] * is_of_joints):
                for given in (*node.args, *(one.value for one in node.keywords)):
                    value = made.get(given.id, given) if isinstance(given, ast.Name) else given
                    instead = _rounded(value, made)
                    if instead:
                        unit = "rad" if callee is Float64 else "m/s or rad/s"
                        message = f"'{excerpt(value)}' is a whole number of {unit}; {instead}"
                        yield function.declared.finding(Code.NRP320, value, message, Level.WARNING)


def _rounded(value: ast.expr, made: Mapping[str, ast.expr]) -> str:
    """Return what to write in place of a number that is rounded; empty if it is not."""
    match value:
        case ast.Call(ast.Name("round" | "int" as work), [inner], []) if _is_computed(inner, work, made):
            return "round(..., 3) keeps three digits"
        case ast.BinOp(divided, ast.FloorDiv()) if any(map(_is_level, ast.walk(divided))):
            return "a quotient is written '/'"
    return ""


def _is_level(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in ("rate", "voltage")


def _is_computed(value: ast.expr, work: str, made: Mapping[str, ast.expr]) -> bool:
    """Return whether a number may have a fraction: ``int`` may turn a condition into 0 or 1 as well."""
    value = made.get(value.id, value) if isinstance(value, ast.Name) else value
    is_named = work == "round" and isinstance(value, ast.Name | ast.Attribute)
    return _is_level(value) or is_named or isinstance(value, ast.BinOp)


@checks_experiment(Code.NRP320)
def expressions_depend_on_something(static: StaticExperiment) -> Iterator[Finding]:
    """Look for clamps with exchanged limits, products with 0, and values compared with themselves."""
    for source in static.sources:
        for node in ast.walk(source.tree):
            message = _constant(node) or _decided(node) or _ignored(node) or _half(node)
            if message:
                yield found_in(source, Code.NRP320, node, message, Level.WARNING)


def _constant(node: ast.AST) -> str:
    """Return which value an expression always has; empty if it has several, or if this is unknown."""
    text = excerpt(node) if isinstance(node, ast.expr) else ""
    match node:
        case ast.Compare(left, [ast.Lt() | ast.Gt() | ast.LtE() | ast.GtE() as sign], [right]):
            if _is_pure(left) and ast.dump(left) == ast.dump(right):  # `x == x` is a test for NaN
                always = isinstance(sign, ast.LtE | ast.GtE)
                return f"'{text}' compares a value with itself: it is always {always}"
        case ast.BinOp(left, ast.Mult(), right) if 0 in (_number(left), _number(right)):
            if _number(left) is None or _number(right) is None:
                return f"'{text}' is always 0"
        case ast.Call(ast.Name("min" | "max" as outer), [one, other], []):
            limit, inner = (one, other) if _number(one) is not None else (other, one)
            bound, reached = _number(limit), _reached(inner, "max" if outer == "min" else "min")
            if bound is not None and reached is not None and _excludes(outer, bound, reached):
                return f"'{text}' is always {bound:g}: its lower limit is above its upper one"
        case ast.For(iter=ast.Call(ast.Name("range"), args, [])) if _is_empty(args):
            return f"this loop never runs: '{ast.unparse(node.iter)}' is empty"
    return ""


def _decided(node: ast.AST) -> str:
    """Return that all sizes agree in a comparison with 0, or that a slice ends before it begins."""
    match node:
        case ast.Compare(ast.Call(func), [ast.Lt() | ast.GtE() as sign], [ast.Constant(0 | 0.0)]):
            if last_name(func) in _NOT_NEGATIVE:
                is_true = isinstance(sign, ast.GtE)
                return f"'{excerpt(node)}' is always {is_true}: {ast.unparse(func)} is never negative"
        case ast.Subscript(_, ast.Slice(ast.Constant(int() as begin), ast.Constant(int() as end), None)):
            if begin >= end:
                return f"'{excerpt(node)}' is always empty: it begins at {begin} and ends before {end}"
    return ""


def _ignored(node: ast.AST) -> str:
    """Return which argument of a call does not do what it is there for; empty if all do."""
    text = excerpt(node) if isinstance(node, ast.expr) else ""
    match node:
        case ast.Call(func, [value, low, high], []) if ast.unparse(func) in _CLIPS:
            least, most = _number(low), _number(high)
            if _number(value) is not None and None in (least, most):
                return (
                    f"'{text}' limits the number {_number(value):g}: the value comes first, then its limits"
                )
            if least is not None and most is not None and least > most:
                return f"'{text}' is always {most:g}: its lower limit, {least:g}, is above its upper one"
        case ast.Call(ast.Attribute(_, "clip"), [low, high], []):
            least, most = _number(low), _number(high)
            if least is not None and most is not None and least > most:
                return f"'{text}' is always {most:g}: its lower limit, {least:g}, is above its upper one"
        case ast.Call(func, [ast.Attribute(one, "ranges"), ast.Attribute(other, "range_max")], []):
            if ast.unparse(func) in _LARGER and ast.dump(one) == ast.dump(other):
                return f"'{text}' is never below the largest range: is the minimum meant?"
        case ast.Call(func, [ast.Attribute(one, "ranges"), ast.Attribute(other, "range_min")], []):
            if ast.unparse(func) in _SMALLER and ast.dump(one) == ast.dump(other):
                return f"'{text}' is never above the smallest range: is 'range_max' meant?"
    return ""


def _half(node: ast.AST) -> str:
    """Return that a computation uses one of two values; empty if it does not."""
    both = (_chosen(node.left) or _chosen(node.right)) if isinstance(node, ast.BinOp) else ""
    return both and f"'{both}' in a computation is one of the two, not both; did you mean '+'?"


def _chosen(node: ast.expr) -> str:
    """Return an ``and`` of two values, unless the first one is a test or guards the second."""
    match node:
        case ast.BoolOp(ast.And(), [ast.Attribute() | ast.Subscript() as one, other]):
            guards = any(ast.dump(one) == ast.dump(part) for part in ast.walk(other))
            if isinstance(other, ast.Attribute | ast.Subscript) and not guards:
                return ast.unparse(node)
    return ""


def _reached(node: ast.expr, name: str) -> float | None:
    """Return the limit of ``max(limit, x)`` or ``min(limit, x)``; None for other expressions."""
    match node:
        case ast.Call(ast.Name(called), [_, _] as given, []) if called == name:
            limits = [limit for one in given if (limit := _number(one)) is not None]
            return limits[0] if len(limits) == 1 else None
    return None


def _excludes(outer: str, bound: float, reached: float) -> bool:
    return reached > bound if outer == "min" else reached < bound


def _is_empty(args: list[ast.expr]) -> bool:
    given: list[Any] = [_number(one) for one in args]
    numbers = [number for number in given if isinstance(number, int)]
    if not numbers or len(numbers) != len(args) or 0 in numbers[2:]:
        return False
    begin, end, step = (0, *numbers, 1) if len(numbers) == 1 else (*numbers, 1)[:3]
    return not range(begin, end, step)


def _is_pure(node: ast.expr) -> bool:
    return not any(isinstance(one, ast.Call) for one in ast.walk(node))


def _number(node: ast.expr) -> float | None:
    """Return the number that an expression writes out; None for others."""
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return None
    return value if type(value) in (int, float) else None
