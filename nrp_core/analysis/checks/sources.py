"""Values of sources in a wrong unit, or that stay where they once were set."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core.analysis.events import Write
from nrp_core.analysis.registry import checks_function
from nrp_core.analysis.scopes import own_nodes
from nrp_core.analysis.shapes import UNITS, Known
from nrp_core.analysis.study import Examined
from nrp_core.clock import seconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.mappings import MapSpikeSource
from nrp_core.findings import Code, Finding, Level

_CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
_WEAKEST_NA: Final = 1e-6
"""A thousandth of a pA, which moves no cell."""
_PERIODS: Final = 0.5
"""How much of its period a wave needs to be one."""


@checks_function(Code.NRP297)
def currents_are_in_na(function: Examined) -> Iterator[Finding]:
    """Look for currents with a factor that turns nA into A, and for phases in radians."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True):
                value = _assigned(function, node)
                tiny = next((one for one in _factors(value) if 0 < abs(one) < _WEAKEST_NA), None)
                if name in _CURRENTS and tiny is not None:
                    message = f"'{name}' is in nA and is set to {tiny:g} or a multiple; is it meant in A?"
                    yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)
                elif name == "phase" and _has_pi(value):
                    yield function.declared.finding(Code.NRP297, node, _DEGREES, Level.WARNING)
    for name, mapping in function.function.mappings.items():
        decorator = function.declared.nodes.get(name)
        given = decorator.keywords if isinstance(decorator, ast.Call) else []
        if isinstance(mapping, MapSpikeSource) and any(
            one.arg == "phase" and _has_pi(one.value) for one in given
        ):
            yield function.declared.finding(Code.NRP297, decorator, _DEGREES, Level.WARNING)


_DEGREES: Final = "'phase' is in degrees, and pi belongs to radians: half a turn is 180"


@checks_function(Code.NRP248)
def waves_have_periods(function: Examined) -> Iterator[Finding]:
    """Look for frequencies with which a current hardly changes during the run."""
    end_s = seconds(function.experiment.duration)
    for event in function.events:
        match event:
            case Write(node, Known(Device()), "frequency", True, Known(int() | float() as frequency)):
                if 0 < frequency * end_s < _PERIODS:
                    message = (
                        f"a frequency of {frequency:g} Hz is {frequency * end_s:.2g} periods in a run of "
                        f"{end_s:g} s; is it meant in kHz?"
                    )
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def sources_are_switched_off(function: Examined) -> Iterator[Finding]:
    """Look for sources that are only ever set to one number, where something was seen, and so keep it."""
    conditional = {
        id(node): choice.test
        for choice in own_nodes(function.declared.node.body)
        if isinstance(choice, ast.If)
        for node in own_nodes([*choice.body, *choice.orelse])
    }
    writes = [
        (event.owner.value, event)
        for event in function.events
        if isinstance(event, Write) and event.exists and event.name in UNITS
        if isinstance(event.owner, Known) and isinstance(event.owner.value, Device | DeviceGroup)
    ]
    for source, event in writes:
        alike = [one for owner, one in writes if owner is source and one.name == event.name]
        test = conditional.get(id(event.node))
        match event.value:
            case Known(int() | float() as value) if value and len(alike) == 1 and test is not None:
                if any(_is_read(one) for one in ast.walk(test)):
                    unit = UNITS[event.name]
                    message = (
                        f"'{event.name}' stays at {value:g} {unit} once it was set: nothing sets it to "
                        f"another value; write {value:g} if {ast.unparse(test):.40} else 0"
                    )
                    yield function.declared.finding(Code.NRP320, event.node, message, Level.WARNING)


def _is_read(node: ast.AST) -> bool:
    """Return whether a part of a condition is about something that changes and changes back, unlike time."""
    return isinstance(node, ast.Attribute | ast.Call | ast.Subscript)


def _assigned(function: Examined, target: ast.expr) -> ast.expr | None:
    """Return the value that a plain assignment gives to an attribute."""
    for node in own_nodes(function.declared.node.body):
        if isinstance(node, ast.Assign) and any(one is target for one in node.targets):
            return node.value
    return None


def _factors(value: ast.expr | None) -> Iterator[float]:
    """Yield the numbers by which a product is multiplied."""
    match value:
        case ast.Constant(int() | float() as number):
            yield number
        case ast.BinOp(left, ast.Mult(), right):
            yield from (*_factors(left), *_factors(right))


def _has_pi(value: ast.expr | None) -> bool:
    parts = () if value is None else ast.walk(value)
    return any(getattr(one, "attr", getattr(one, "id", "")) == "pi" for one in parts)
