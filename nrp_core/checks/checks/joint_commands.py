"""Angles that are commanded in degrees to joints that take radians."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from math import pi, radians
from types import MethodType
from typing import Final

from nrp_core.checks.events import Call, Return
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.shapes import Known, Shape
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.parameters.topics import PublishedTopic
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.topics import TopicInfo

_TURNS_RAD: Final = 4 * pi
"""Two turns: joints of robots with limits turn less, and wheels are commanded by speeds."""
_WHOLE: Final = 5.0
"""Angles in degrees are multiples of this, as a rule; counted turns are not."""


@checks_function(Code.NRP249)
def joints_are_commanded_in_radians(function: CheckedFunction) -> Iterator[Finding]:
    """Look for constant commands of joints that are angles in degrees."""
    made = {
        id(event.node): event.given[0]
        for event in function.events
        if isinstance(event, Call) and len(event.given) == 1 and _is_message(event.callee)
    }
    for event in function.events:
        match event:
            case Call(node, Known(MethodType() as method), (value,)) if isinstance(
                method.__self__, PublishedTopic
            ):
                info, sent = method.__self__.info, node.args[0] if node.args else node
            case Return(node, value) if value is not None and function.returns_to is not None and node.value:
                info, sent = function.returns_to, node.value
            case _:
                continue
        message = _in_degrees(info, made.get(id(sent), value))
        if message:
            yield function.declared.finding(Code.NRP249, sent, message, Level.WARNING)


@checks_experiment(Code.NRP249)
def events_command_radians(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events that command a joint by an angle in degrees."""
    for name, event in static.experiment.events.items():
        for said in event.publish:
            info = static.topics.get(static.experiment.aliases.get(said.topic, said.topic))
            value = next(iter(said.value.values()), None) if isinstance(said.value, dict) else said.value
            message = "" if info is None else _in_degrees(info, Known(value))
            if message:
                place = static.experiment.place("events", name, "publish")
                yield place.finding(Code.NRP249, message, Level.WARNING)


def _is_message(callee: Shape) -> bool:
    return isinstance(callee, Known) and hasattr(callee.value, "__msgtype__")


def _in_degrees(info: TopicInfo, value: Shape | ast.AST) -> str:
    """Return that a command is in degrees; empty if it may be in the unit of its topic."""
    match value:
        case Known(int() | float() as angle) if info.unit == "rad" and not isinstance(angle, bool):
            if abs(angle) > _TURNS_RAD and angle % _WHOLE == 0:
                return (
                    f"'{info.name}' takes radians, and {angle:g} is {abs(angle) / (2 * pi):.0f} turns; "
                    f"{angle:g} degrees are {radians(angle):.4g}"
                )
    return ""
