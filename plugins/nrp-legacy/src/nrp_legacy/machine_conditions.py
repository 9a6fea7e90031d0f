"""Conditions of monitors that a message can never meet, or always meets."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import Any, Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.code.shapes import hints
from nrp_core.checks.code.syntax import excerpt, number_of, own_nodes
from nrp_core.dsl.parameters.messages import message_packages
from nrp_core.findings import Code
from nrp_core.world.raycast.solids import width_m
from nrp_core.world.scene.model import Scene

Callback = ast.Lambda | ast.FunctionDef

_NS: Final = 1e9
_CLOCK: Final = "ClockMonitorState"
_MIRRORED: Final = {ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE}
_PARTS: Final = tuple(f".orientation.{part}" for part in "xyzw")


def doubtful_conditions(
    tree: ast.Module, duration_s: float
) -> Iterator[tuple[Code, ast.expr | ast.stmt, str]]:
    """Yield the code, the place and a sentence for each condition that is decided before the run.

    Args:
        tree: the file.
        duration_s: duration of the run, s.
    """
    is_concurrent = any(isinstance(node, ast.Name | ast.Attribute) and "Concurrence" in ast.unparse(node)
                        for node in ast.walk(tree))  # fmt: skip
    for call, callback in monitors(tree):
        answers = _answers(callback)
        if not any(answers):
            assert isinstance(callback, ast.FunctionDef)
            message = f"'{callback.name}' returns nothing: the state ends with its first message"
            yield Code.NRP237, callback, message
        elif not (is_concurrent or _is_limited(call)) and all(
            isinstance(one, ast.Constant) and one.value for one in answers
        ):
            yield Code.NRP327, call, "the condition is always true: the state waits until the run ends"
        kind = _message_of(call)
        for node in ast.walk(callback):
            if isinstance(node, ast.Compare) and len(node.ops) == 1:
                clock_s = duration_s if ast.unparse(call.func).endswith(_CLOCK) else None
                message = _decided(node, _parameter(callback), clock_s) or _of_other_kind(
                    node, callback, kind
                )
                if message:
                    yield Code.NRP327, node, message


def distant_places(tree: ast.Module, scene: Scene) -> Iterator[tuple[ast.expr, str]]:
    """Yield the comparisons of positions with places farther away than a scene is wide."""
    wide_m = width_m(scene)
    for _, callback in monitors(tree):
        for node in ast.walk(callback):
            if not isinstance(node, ast.Compare) or not re.search(r"\.position\.[xy]\b", ast.unparse(node)):
                continue
            for number in map(number_of, (node.left, *node.comparators)):
                if number is not None and abs(number) > wide_m:
                    message = f"'{excerpt(node)}': {number:g} m is outside the scene, {wide_m:.3g} m wide"
                    yield node, message


def monitors(tree: ast.Module) -> Iterator[tuple[ast.Call, Callback]]:
    """Yield each call that makes a monitor, with its condition if this file defines it."""
    functions = {node.name: node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("MonitorState"):
            for given in (*node.args, *(one.value for one in node.keywords)):
                match given:
                    case ast.Lambda():
                        yield node, given
                    case ast.Name(name) if name in functions:
                        yield node, functions[name]


def _answers(callback: Callback) -> list[ast.expr | None]:
    """Return the values that a condition can have; None where it returns nothing, which ends the state."""
    if isinstance(callback, ast.Lambda):
        return [callback.body]
    returns = [node.value for node in own_nodes(callback.body) if isinstance(node, ast.Return)]
    return returns if isinstance(callback.body[-1], ast.Return) else [*returns, None]


def _is_limited(call: ast.Call) -> bool:
    """Return whether a monitor may end after a number of messages, ``max_checks``."""
    return len(call.args) > 3 or any(one.arg in ("max_checks", None) for one in call.keywords)


def _parameter(callback: Callback) -> str:
    """Return the name of the message, the last parameter."""
    names = [one.arg for one in callback.args.args]
    return names[-1] if names else ""


def _decided(node: ast.Compare, parameter: str, clock_s: float | None) -> str:
    """Return that a comparison has the same answer for every message; empty if it does not."""
    left, right, sign = node.left, node.comparators[0], type(node.ops[0])
    if number_of(left) is not None:
        left, right, sign = right, left, _MIRRORED.get(sign, sign)
    limit, what = number_of(right), ast.unparse(left)
    if limit is None or what.partition(".")[0] != parameter:
        return ""
    low, high, why = _range(what, parameter, clock_s)
    answer = {
        ast.Gt: (limit >= high, limit < low), ast.GtE: (limit > high, limit < low),
        ast.Lt: (limit <= low, limit > high), ast.LtE: (limit < low, limit > high),
        ast.Eq: (not low <= limit <= high, False), ast.NotEq: (False, not low <= limit <= high),
    }.get(sign, (False, False))  # fmt: skip
    if not any(answer):
        return ""
    return f"'{excerpt(node)}' is {'never' if answer[0] else 'always'} true: {why}"


def _range(what: str, parameter: str, clock_s: float | None) -> tuple[float, float, str]:
    """Return the limits of a part of a message, and the reason for them."""
    if what.endswith(_PARTS):
        return -1.0, 1.0, "a part of a quaternion is from -1 to 1"
    seconds = (parameter, f"{parameter}.secs", f"{parameter}.sec", f"{parameter}.to_sec()")
    if clock_s is not None and what in seconds:
        return 0.0, clock_s, f"the run is from 0 s to {clock_s:g} s"
    if clock_s is not None and what == f"{parameter}.nsecs":
        return 0.0, _NS - 1, "nsecs are the nanoseconds since the last whole second"
    return float("-inf"), float("inf"), ""


def _message_of(call: ast.Call) -> type | None:
    """Return the type of the messages of a ``MonitorState``, if only one package has a type of that name."""
    given = call.args[1:2] or [one.value for one in call.keywords if one.arg == "msg_type"]
    if not given or last_name(call.func) != "MonitorState":
        return None
    name = last_name(given[0])
    found = [
        kind for one in message_packages().values() if isinstance(kind := getattr(one.msg, name, None), type)
    ]
    return found[0] if len(found) == 1 else None


def _of_other_kind(node: ast.Compare, callback: Callback, kind: type | None) -> str:
    """Return that a field never equals a value because one of them is a text."""
    owner, *path = ast.unparse(node.left).split(".")
    if kind is None or owner != _parameter(callback) or not isinstance(node.ops[0], ast.Eq | ast.NotEq):
        return ""
    field: Any = kind
    for name in path:
        field = hints(field).get(name) if isinstance(field, type) else None
    match node.comparators[0]:
        case ast.Constant(str()) if field in (bool, int, float):
            return f"'{excerpt(node)}' compares a {field.__name__} with a text: they are never equal"
        case ast.Constant(int() | float()) if field is str:
            return f"'{excerpt(node)}' compares a text with a number: they are never equal"
    return ""
