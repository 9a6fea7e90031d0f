"""Divisions, and the units of the values of devices."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.events import Add, Read, Write
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import UNITS, Known, Number, Shape, item_of
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP233)
def units_agree(function: CheckedFunction) -> Iterator[Finding]:
    """Look for quantities in one unit that are used in place of another."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, value) if name in UNITS:
                unit = _unit(value)
                if unit and unit != UNITS[name]:
                    message = (
                        f"'{name}' is in {UNITS[name]} and is set from a quantity in {unit}: "
                        f"the factor between them is in {UNITS[name]}/{unit}"
                    )
                    yield function.declared.finding(Code.NRP233, node, message, Level.NOTE)
            case Add(node, Number(first), Number(second)) if first and second and first != second:
                message = f"a quantity in {first} is combined with one in {second}"
                yield function.declared.finding(Code.NRP233, node, message, Level.NOTE)


@checks_function(Code.NRP233)
def times_of_recorders_are_in_ms(function: CheckedFunction) -> Iterator[Finding]:
    """Look for times of a recorder, in ms, that are combined with a time in s."""
    times = {
        id(event.node)
        for event in function.events
        if isinstance(event, Read) and event.name == "times" and isinstance(event.owner, Known)
        if isinstance(event.owner.value, Device)
    }
    for event in function.events:
        match event:
            case Add(ast.BinOp(one, _, other) | ast.Compare(one, _, [other]) as node, left, right):
                for mine, with_, shape in ((one, other, right), (other, one, left)):
                    read = mine
                    while isinstance(read, ast.Subscript):
                        read = read.value
                    is_plain = isinstance(with_, ast.Name)  # a product may hold the factor
                    if is_plain and shape == Number("s") and id(read) in times:
                        text = excerpt(node)
                        message = f"'{ast.unparse(read)}' is in ms, and '{text}' combines it with s"
                        yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


def _unit(shape: Shape) -> str | None:
    found = shape if isinstance(shape, Number) else item_of(shape)
    return found.unit if isinstance(found, Number) else None
