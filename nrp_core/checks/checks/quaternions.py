"""Parts of quaternions that are taken as angles, or in the order of another library."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.checks.angles import ARCS, CONVERSIONS, TURNING
from nrp_core.checks.events import Add, Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.geometry_msgs import Quaternion

_ANGLES: Final = ("yaw", "heading", "theta", "angle", "roll", "pitch")
_TAKES_ANGLES: Final = (*TURNING, *CONVERSIONS)
_NOT_AN_ANGLE: Final = (
    "'{:.60}' is part of a quaternion, not an angle; the yaw of a level robot is 2 * math.atan2(q.z, q.w)"
)
_ORDERS: Final = {
    "euler_from_quaternion": "xyzw", "quaternion_matrix": "xyzw", "from_quat": "xyzw", "quat2euler": "wxyz",
    "quat2mat": "wxyz",
}  # fmt: skip
"""Functions of tf, SciPy and transforms3d, and the order in which they take a quaternion."""


@checks_function(Code.NRP233)
def parts_of_quaternions_are_no_angles(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a component of an orientation that is kept as an angle, or given to a function of angles."""
    for node in function.declared.own:
        match node:
            case ast.Assign(
                [ast.Name(name)], ast.Attribute(ast.Attribute(_, "orientation"), "x" | "y" | "z" | "w")
            ):
                if any(one in name.lower() for one in _ANGLES):
                    message = _NOT_AN_ANGLE.format(ast.unparse(node.value))
                    yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)
            case ast.Call(
                func, [ast.Attribute(ast.Attribute(_, "orientation"), "x" | "y" | "z" | "w") as part], []
            ):
                if last_name(func) in _TAKES_ANGLES:
                    message = _NOT_AN_ANGLE.format(ast.unparse(part))
                    yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


@checks_function(Code.NRP233)
def parts_of_quaternions_are_no_terms(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a component of an orientation that is added to a number beyond 1, or subtracted from it."""
    parts = {
        id(event.node)
        for event in function.events
        if isinstance(event, Read) and event.owner == Instance(Quaternion)
    }
    for event in function.events:
        match event:
            case Add(ast.BinOp(one, _, other) as node, left, right):
                for part, term in ((one, right), (other, left)):
                    match term:
                        case Known(int() | float() as number) if id(part) in parts and abs(number) > 1:
                            message = _NOT_AN_ANGLE.format(ast.unparse(part))
                            yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


@checks_function(Code.NRP249)
def quaternions_are_read_in_order(function: CheckedFunction) -> Iterator[Finding]:
    """Look for parts of quaternions in the order of another library, and for their angle upside down."""
    own = {one.name for one in function.declared.source.tree.body if isinstance(one, ast.FunctionDef)}
    for node in function.declared.own:
        if not isinstance(node, ast.Call):
            continue
        name = last_name(node.func)
        match node.args:
            case [ast.Attribute(_, "w"), ast.Attribute(_, "x" | "y" | "z" as part)] if name in ARCS:
                message = f"'{excerpt(node)}': half the angle is {name}({part}, w), in this order"
                yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)
            case [ast.List(parts) | ast.Tuple(parts), *_] if (
                name in _ORDERS.keys() - own and not node.keywords
            ):
                order = "".join(one.attr for one in parts if isinstance(one, ast.Attribute))
                if sorted(order) == sorted(_ORDERS[name]) and order != _ORDERS[name]:
                    message = (
                        f"'{excerpt(node)}' takes the parts as {', '.join(_ORDERS[name])}, and they "
                        f"are given as {', '.join(order)}"
                    )
                    yield function.declared.finding(Code.NRP249, node, message, Level.WARNING)
