"""Angles in degrees and radians."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from math import cos, degrees, pi, radians, sin, tan, tau
from typing import Any, Final

import numpy as np

from nrp_core._support.dotted import last_name
from nrp_core.checks.choices import number_of
from nrp_core.checks.declared import found_in
from nrp_core.checks.events import Call, Write
from nrp_core.checks.imported import full_names
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.shapes import Instance, Known, Shape
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.rigid import ROUNDED_TURN_RAD

_OF_ANGLES: Final[tuple[Any, ...]] = (sin, cos, tan, np.sin, np.cos, np.tan)
_TO_DEGREES: Final = ("degrees", "rad2deg")
_FROM_DEGREES: Final = ("radians", "deg2rad")
CONVERSIONS: Final = (*_TO_DEGREES, *_FROM_DEGREES)
TURNING: Final = ("sin", "cos", "tan")
_NAMES_OF_ANGLES: Final = {f"{module}.{name}" for module in ("math", "numpy") for name in TURNING}
ARCS: Final = ("atan2", "arctan2")
_INVERSE: Final = (*ARCS, "atan", "asin", "acos", "arctan", "arcsin", "arccos")
_ANGLES: Final = ("angle_min", "angle_max", "angle_increment")
"""Fields of messages of lasers."""
_ROUNDED: Final = 0.05
"""How far 57.3 may be rounded, and:"""
_NEARLY: Final = 2e-3


@checks_experiment(Code.NRP249)
def angles_have_units(static: StaticExperiment) -> Iterator[Finding]:
    """Look for angles of poses given in degrees instead of radians."""
    experiment = static.experiment
    owners: dict[tuple[Key, ...], str] = {}
    for name, robot in experiment.world.robots.items():
        owners["world", "robots", name] = f"'{name}'"
        for number, sensor in enumerate(robot.add_sensors):
            owners["world", "robots", name, "add_sensors", number] = f"the sensor on '{name}/{sensor.link}'"
    for place, owner in owners.items():
        for i, what in enumerate(("roll", "pitch", "yaw"), start=3):
            keys = (*place, "pose", i)
            written, reached = experiment.source.nearest(keys)
            value = written.value
            if reached == keys and isinstance(value, (int, float)) and abs(value) > ROUNDED_TURN_RAD:
                message = (
                    f"the {what} of {owner} is {value:g} rad, more than a turn; {value:g} degrees are "
                    f"{radians(value):.4g} rad"
                )
                yield written.place.finding(Code.NRP249, message, Level.WARNING)


@checks_experiment(Code.NRP249)
def angles_of_helpers_are_in_radians(static: StaticExperiment) -> Iterator[Finding]:
    """Look outside transfer functions for sines and the like of numbers that are more than a full turn."""
    inside = {id(node) for declared in static.declared for node in ast.walk(declared.node)}
    for source in static.sources:
        names = full_names(source.tree)
        for node in ast.walk(source.tree):
            match node:
                case ast.Call(func, [ast.Constant(int() | float() as angle)], []) if abs(angle) > tau:
                    first, dot, rest = ast.unparse(func).partition(".")
                    full = names.get(first, first) + dot + rest
                    if id(node) not in inside and full in _NAMES_OF_ANGLES:
                        yield found_in(
                            source, Code.NRP249, node, _more_than_a_turn(node, angle), Level.WARNING
                        )


@checks_function(Code.NRP249)
def angles_of_functions_are_in_radians(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sines and the like of constants that are more than a full turn."""
    for event in function.events:
        match event:
            case Call(node, Known(callee), (Known(int() | float() as angle),)) if abs(angle) > tau:
                if any(callee is one for one in _OF_ANGLES):
                    message = _more_than_a_turn(node, angle)
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)


@checks_function(Code.NRP249)
def angles_are_converted_once(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sines and the like of angles that were just converted to degrees."""
    for event in function.events:
        match event:
            case Call(ast.Call(args=[angle]) as node, Known(callee)) if any(
                callee is one for one in _OF_ANGLES
            ):
                if _is_in_degrees(angle):
                    message = f"'{excerpt(node)}' takes degrees as radians"
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)


@checks_function(Code.NRP249)
def messages_carry_radians(function: CheckedFunction) -> Iterator[Finding]:
    """Look for angles that are converted to degrees where a message takes them."""
    told, moving = _types_sent(function)
    if told and not moving:
        return
    made, spared = single_values(function), told - moving
    set_to = [one for one in function.events if isinstance(one, Write) and _is_message(one.owner, spared)]
    targets = {id(one.node) for one in set_to}
    given = [
        one.value
        for one in function.declared.own
        if isinstance(one, ast.Assign) and any(id(target) in targets for target in one.targets)
    ]
    for event in function.events:
        match event:
            case Call(node, Known(callee)) if hasattr(callee, "__msgtype__") and callee not in spared:
                given += [*node.args, *(one.value for one in node.keywords)]
    for one in given:
        value = made.get(one.id, one) if isinstance(one, ast.Name) else one
        if any(_converts(part) for part in _terms(value)):
            message = f"'{excerpt(value)}' is in degrees, and messages carry radians"
            yield function.declared.finding(Code.NRP249, one, message, Level.WARNING)


def _is_message(owner: Shape, spared: set[Any]) -> bool:
    return isinstance(owner, Instance) and hasattr(owner.cls, "__msgtype__") and owner.cls not in spared


def _types_sent(function: CheckedFunction) -> tuple[set[Any], set[Any]]:
    """Return the types that a function sends to topics that move nothing, for people, and to all others."""
    told, moving = set[Any](), set[Any]()
    for one in function.function.published:
        info = function.world.topics.get(one.name)
        is_told = info is not None and info.name in function.experiment.topics
        (told if is_told else moving).add(None if info is None else info.type)
    return told, moving


def _terms(value: ast.expr) -> Iterator[ast.expr]:
    """Yield the terms of a sum, without their signs."""
    match value:
        case ast.BinOp(left, ast.Add() | ast.Sub(), right):
            yield from (*_terms(left), *_terms(right))
        case ast.UnaryOp(ast.USub(), operand):
            yield from _terms(operand)
        case _:
            yield value


def _converts(value: ast.expr) -> bool:
    """Return whether a term is an angle times 180 / pi; a product with more factors may hold a gain."""
    match value:
        case ast.BinOp(one, ast.Mult(), other):
            plain = (ast.Name, ast.Attribute, ast.Call)
            return (_is_factor(one) and isinstance(other, plain)) or (
                _is_factor(other) and isinstance(one, plain)
            )
    return _is_in_degrees(value)


def _is_in_degrees(value: ast.expr) -> bool:
    """Return whether an expression is the result of a function that converts, or of ``angle * 180 / pi``."""
    match value:
        case ast.Call(func):
            return ast.unparse(func).endswith(_TO_DEGREES)
        case ast.BinOp(ast.BinOp(_, ast.Mult(), ast.Constant(180)), ast.Div(), divisor):
            return _is_pi(divisor)
    return False


def _is_pi(value: ast.expr) -> bool:
    number = number_of(value)
    return ast.unparse(value).endswith("pi") or (number is not None and abs(number - pi) < _NEARLY)


def _is_factor(value: ast.expr) -> bool:
    """Return whether an expression is 180 / pi, written so or as a number."""
    match value:
        case ast.Constant(int() | float() as number):
            return abs(number - degrees(1.0)) < _ROUNDED
        case ast.BinOp(ast.Constant(180), ast.Div(), divisor):
            return _is_pi(divisor)
    return False


@checks_function(Code.NRP249)
def angles_stay_in_radians(function: CheckedFunction) -> Iterator[Finding]:
    """Look for angles in radians that are compared with degrees or converted from them, and for counts."""
    made = single_values(function)
    for node in function.declared.own:
        match node:
            case ast.Compare(one, [_], [other]):
                for angle, limit in ((one, other), (other, one)):
                    number = number_of(limit)
                    if number is not None and abs(number) > tau and _is_bounded(angle, made):
                        message = (
                            f"'{excerpt(node)}': the angle is in radians and never {number:g}; "
                            f"{number:g} degrees are {radians(number):.4g}"
                        )
                        yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)
            case ast.Call(func, [angle], []):
                name = last_name(func)
                if name in _FROM_DEGREES and (_is_angle(angle, made) or _is_turn_rate(angle)):
                    what = "a turn rate in rad/s" if _is_turn_rate(angle) else "an angle in radians"
                    message = f"'{excerpt(node)}' takes {what} as degrees"
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)
                elif name in TURNING and _counts(angle, made):
                    message = f"'{excerpt(node)}' takes 0, 1, 2, ... as radians; is np.deg2rad meant?"
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)


def single_values(function: CheckedFunction) -> dict[str, ast.expr]:
    """Return the names to which a body assigns one expression, alone or in a row, and that expression."""
    nodes = function.declared.own
    stores = Counter(one.id for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store))
    pairs: list[tuple[ast.expr, ast.expr]] = []
    for node in nodes:
        match node:
            case ast.Assign([ast.Tuple(names)], ast.Tuple(values)) if len(names) == len(values):
                pairs += zip(names, values, strict=True)
            case ast.Assign([name], value):
                pairs.append((name, value))
    return {name.id: value for name, value in pairs if isinstance(name, ast.Name) and stores[name.id] == 1}


def _is_bounded(value: ast.expr, made: Mapping[str, ast.expr]) -> bool:
    """Return whether a value is a sum of angles and numbers: others may hold turns that were counted."""
    terms = list(_terms(made.get(value.id, value) if isinstance(value, ast.Name) else value))
    return any(_is_angle(one, made) for one in terms) and all(
        _is_angle(one, made) or _is_pi(one) or number_of(one) is not None for one in terms
    )


def _is_angle(value: ast.expr, made: Mapping[str, ast.expr]) -> bool:
    """Return whether a value is known to be an angle in radians."""
    match value:
        case ast.Name(name) if name in made:
            return _is_angle(made[name], {key: one for key, one in made.items() if key != name})
        case ast.Attribute(_, name):
            return name in _ANGLES
        case ast.Call(func, [inner]) if last_name(func) in ("abs", "fabs"):
            return _is_angle(inner, made)
        case ast.Call(func):
            return last_name(func) in _INVERSE
        case ast.UnaryOp(ast.USub(), inner) | ast.BinOp(ast.Constant(2 | 2.0), ast.Mult(), inner):
            return _is_angle(inner, made)
        case ast.BinOp(one, ast.Add() | ast.Sub(), other):
            return _is_angle(one, made) or _is_angle(other, made)
    return False


def _is_turn_rate(value: ast.expr) -> bool:
    """Return whether a value is a turn rate of a message, which is in rad/s."""
    match value:
        case ast.Attribute(ast.Attribute(_, "angular_velocity" | "angular"), "x" | "y" | "z"):
            return True
    return False


def _counts(value: ast.expr, made: Mapping[str, ast.expr]) -> bool:
    """Return whether a value is a row of whole numbers with a step of 1."""
    match value:
        case ast.Name(name) if name in made:
            return _counts(made[name], {key: one for key, one in made.items() if key != name})
        case ast.BinOp(one, ast.Add() | ast.Sub(), ast.Constant(int())):
            return _counts(one, made)
        case ast.Call(func, [*limits], []) if 0 < len(limits) < 3:
            return ast.unparse(func) in ("np.arange", "numpy.arange") and not any(
                isinstance(one, ast.Constant) and isinstance(one.value, float) for one in limits
            )
    return False


@checks_function(Code.NRP249)
def angles_of_vectors_take_y_first(function: CheckedFunction) -> Iterator[Finding]:
    """Look for ``atan2(x, y)`` of one vector; ``pi/2 - atan2(x, y)`` and ``atan2(-x, y)`` are right."""
    from_north = {
        id(node.right) for node in function.declared.own
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub)
    }  # fmt: skip
    for node in function.declared.own:
        match node:
            case ast.Call(func, [one, other], []) if last_name(func) in ARCS and id(node) not in from_north:
                x, y = _axis(one), _axis(other)
                if x and y and x[-1:] == "x" and y == x[:-1] + "y":
                    name = last_name(func)
                    message = f"'{excerpt(node)}' has x first; an angle from the x axis is {name}(y, x)"
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)


def _axis(value: ast.expr) -> str:
    """Return the name of a coordinate, or of the one in a difference; empty for other expressions."""
    match value:
        case ast.Name(name) if name in ("x", "y", "dx", "dy"):
            return name
        case ast.Attribute(_, "x" | "y"):
            return ast.unparse(value)
        case ast.BinOp(one, ast.Sub(), other):
            return _axis(one) or _axis(other)
    return ""


def _more_than_a_turn(node: ast.Call, angle: float) -> str:
    return (
        f"'{excerpt(node)}' takes {angle:g} as radians, more than a turn; degrees are math.radians({angle:g})"
    )
