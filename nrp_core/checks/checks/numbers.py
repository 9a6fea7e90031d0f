"""Divisions, and the units of the values of devices."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_core.checks.events import Add, Divide, Read, Write
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import UNITS, Known, Number, Shape, item_of
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.clock import seconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.findings import Code, Finding, Level

_THOUSAND: Final = 1000.0


@checks_function(Code.NRP232)
def nothing_is_divided_by_zero(function: CheckedFunction) -> Iterator[Finding]:
    """Look for constant divisors that are zero."""
    for event in function.events:
        match event:
            case Divide(node, left, Known(int() | float() as divisor)) if divisor == 0:
                if not (isinstance(left, Known) and isinstance(left.value, str)):
                    yield function.declared.finding(Code.NRP232, node, "this divides by zero")


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


@checks_function(Code.NRP233)
def times_in_loops_are_in_ms(function: CheckedFunction) -> Iterator[Finding]:
    """Look for loops over the times of a recorder, in ms, that compare them with ``t``, in s."""
    nodes = function.declared.own
    for loop in nodes:
        if not isinstance(loop, ast.For | ast.comprehension):
            continue
        text = ast.unparse(loop.iter).partition("[")[0]
        name, _, attribute = text.partition(".")
        if attribute != "times" or not isinstance(function.adapters.get(name), Device):
            continue
        spikes = {one.id for one in ast.walk(loop.target) if isinstance(one, ast.Name)}
        for node in nodes:
            match node:
                case ast.Compare(ast.Name(spike), _, [other]) | ast.BinOp(other, ast.Sub(), ast.Name(spike)):
                    if spike in spikes and _is_time(other):
                        message = f"'{text}' is in ms, and '{excerpt(node)}' combines it with s"
                        yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


def _is_time(node: ast.expr) -> bool:
    """Return whether an expression is ``t``, or ``t`` and a constant span."""
    match node:
        case ast.Name("t") | ast.BinOp(ast.Name("t"), ast.Add() | ast.Sub(), ast.Constant()):
            return True
    return False


@checks_function(Code.NRP233)
def the_time_is_in_s(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a time in s that is divided by 1000, as one in ms would be."""
    end_s = seconds(function.experiment.duration)
    for event in function.events:
        match event:
            case Divide(ast.BinOp(ast.Name("t"), ast.Div()) as node, Number("s"), Known(1000 | 1000.0)):
                if end_s < _THOUSAND:
                    message = (
                        f"'t' is in s, so that '{ast.unparse(node)}' is at most {end_s / _THOUSAND:g} "
                        "in this run; milliseconds are 1000 * t"
                    )
                    yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


def _unit(shape: Shape) -> str | None:
    found = shape if isinstance(shape, Number) else item_of(shape)
    return found.unit if isinstance(found, Number) else None
