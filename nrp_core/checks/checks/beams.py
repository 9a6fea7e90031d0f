"""Infinite distances of a scanner that are averaged, and beams that are counted from the wrong end."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.choices import number_of
from nrp_core.checks.events import Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.sensor_msgs import LaserScan

_AVERAGES: Final = ("mean", "average", "sum", "std", "var")
"""Functions and methods whose result is infinite or not a number as soon as one value is infinite."""


@checks_function(Code.NRP320)
def distances_are_finite_when_averaged(function: CheckedFunction) -> Iterator[Finding]:
    """Look for means and sums of the distances of a scanner as they are in its message."""
    ranges = {
        id(event.node)
        for event in function.events
        if isinstance(event, Read) and event.name == "ranges" and event.owner == Instance(LaserScan)
    }
    for node in function.declared.own:
        match node:
            case ast.Call(ast.Attribute(whole, name), [], []) if name in _AVERAGES:
                pass
            case ast.Call(func, [whole], []) if last_name(func) in _AVERAGES:
                pass
            case _:
                continue
        part = whole.value if isinstance(whole, ast.Subscript) else whole
        if id(part) in ranges:
            message = (
                f"'{excerpt(node)}' is not finite as soon as one beam reaches nothing, which is 'inf'; "
                "np.minimum(..., range_max) limits the distances"
            )
            yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def beams_are_counted_from_the_first_angle(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the number of a beam that is a negative angle divided by the increment."""
    for node in function.declared.own:
        match node:
            case ast.Subscript(
                _, ast.Call(func, [ast.BinOp(angle, ast.Div(), ast.Attribute(_, "angle_increment"))], [])
            ) if last_name(func) in ("int", "round"):
                number = number_of(angle)
                if number is not None and number < 0:
                    message = (
                        f"'{excerpt(node)}' has a negative index, which counts from the last beam: "
                        "beams are counted from angle_min, (angle - angle_min) / angle_increment"
                    )
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)
