"""Values that are set and lost at once, and sources of both sides that get the value of one."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from itertools import combinations

from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import UNITS
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.variables import Variable
from nrp_core.findings import Code, Finding, Level

_SIDES = re.compile(r"(?<![a-z])(?:left|right)")
"""A side in a name, unlike the one in ``brightness``."""


@checks_function(Code.NRP320)
def computed_values_are_not_replaced(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a source that is set to a computed value and, in the next statements, to a number."""
    first: dict[str, int] = {}
    for statement in function.declared.node.body:
        if not isinstance(statement, ast.Assign | ast.Expr):
            first.clear()  # it may read the value, or end the function
            continue
        for node in own_nodes([statement]):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
                first.pop(ast.unparse(node), None)
        for target, value in _assigned(statement):
            if not (_is_setting(function, target) and isinstance(target, ast.Attribute)):
                continue
            where = ast.unparse(target)
            if isinstance(value, ast.Constant) and where in first:
                message = f"this replaces '{where}' of line {first[where]}, which has no effect"
                yield function.declared.finding(Code.NRP320, statement, message, Level.WARNING)
            if value is not None and not isinstance(value, ast.Constant):
                first[where] = statement.lineno


@checks_function(Code.NRP320)
def last_times_are_set_last(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a variable that is set to ``t`` before the time since its last value is computed."""
    set_to_t: dict[str, int] = {}
    for statement in function.declared.node.body:
        for node in own_nodes([statement]):
            match node:
                case ast.BinOp(ast.Name("t"), ast.Sub(), ast.Attribute() as last):
                    where = ast.unparse(last)
                    if set_to_t.get(where, statement.lineno) < statement.lineno:
                        message = (
                            f"'{ast.unparse(node)}' is always 0: line {set_to_t[where]} has set it to 't'"
                        )
                        yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)
        for node in own_nodes([statement]):
            for target, value in _assigned(node):
                if isinstance(target, ast.Attribute) and _is_variable(function, target):
                    set_to_t.pop(ast.unparse(target), None)
                    if node is statement and isinstance(value, ast.Name) and value.id == "t":
                        set_to_t[ast.unparse(target)] = statement.lineno


@checks_function(Code.NRP320)
def loops_keep_more_than_the_last_value(function: CheckedFunction) -> Iterator[Finding]:
    """Look for loops over numbers that only set a name to one item after the other."""
    for loop in function.declared.own:
        match loop:
            case ast.For(ast.Name(index), ast.Call(ast.Name("range")), [ast.Assign([ast.Name(kept)], value)]):
                read = {one.id for one in ast.walk(value) if isinstance(one, ast.Name)}
                if (
                    index in read
                    and kept not in read
                    and not any(isinstance(one, ast.Call) for one in ast.walk(value))
                ):
                    message = f"each pass of the loop replaces '{kept}': only the last value is kept"
                    yield function.declared.finding(Code.NRP320, loop, message, Level.WARNING)


@checks_function(Code.NRP320)
def sides_have_their_own_values(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources of the left and right side that are set to the same part of something, in one go."""
    for (one, value), (other, same) in _pairs(function):
        names = [_SIDES.sub("", ast.unparse(each)) for each in (one, other)]
        if ast.dump(one) != ast.dump(other) and names[0] == names[1] and ast.dump(value) == ast.dump(same):
            message = (
                f"'{ast.unparse(other)}' and '{ast.unparse(one)}' are both '{excerpt(value, 40)}': "
                "is one of them of the other side?"
            )
            yield function.declared.finding(Code.NRP320, other, message, Level.WARNING)


_Setting = tuple[ast.expr, ast.expr]


def _pairs(function: CheckedFunction) -> Iterator[tuple[_Setting, _Setting]]:
    """Yield the pairs of sources that one block sets to parts of something."""
    for block in _blocks(function.declared.node):
        yield from combinations(
            [
                (target, value)
                for statement in block
                for target, value in _assigned(statement)
                if _is_setting(function, target) and value is not None and _is_of_a_side(value)
            ],
            2,
        )


def _blocks(function: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield the lists of statements in a function, each of which runs as a whole."""
    for node in ast.walk(function):
        for _, field in ast.iter_fields(node):
            if isinstance(field, list) and field and isinstance(field[0], ast.stmt):
                yield field


def _assigned(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr | None]]:
    """Yield each target of an assignment with its value, None for one that is not written out."""
    if not isinstance(node, ast.Assign):
        return
    for target in node.targets:
        match target, node.value:
            case ast.Tuple(targets), ast.Tuple(values) if len(targets) == len(values):
                yield from zip(targets, values, strict=True)
            case ast.Tuple(targets), _:
                yield from ((one, None) for one in targets)
            case _:
                yield target, node.value


def _is_setting(function: CheckedFunction, target: ast.expr) -> bool:
    match target:
        case ast.Attribute(ast.Name(name), attribute) if attribute in UNITS:
            return isinstance(function.adapters.get(name), Device | DeviceGroup)
    return False


def _is_variable(function: CheckedFunction, target: ast.Attribute) -> bool:
    return isinstance(target.value, ast.Name) and isinstance(function.adapters.get(target.value.id), Variable)


def _is_of_a_side(value: ast.expr) -> bool:
    """Return whether an expression selects a side: from one end on, by a comparison or by a name."""
    for node in ast.walk(value):
        match node:
            case ast.Subscript(_, ast.Slice(lower, upper)):
                if (lower is None or ast.unparse(lower) == "0") != (upper is None):
                    return True
            case ast.Subscript(whole, ast.Compare(left)) if ast.dump(whole) != ast.dump(left):
                return True  # what is compared with itself is filtered
            case ast.Attribute(_, name) if _SIDES.search(name):
                return True
    return False
