"""Values of sources in a wrong unit, or that stay where they once were set."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from math import tau
from typing import Final

from nrp_core.checks.events import Multiply, Read, Write
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import UNITS, Instance, Known, Number, Shape
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.clock import seconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.mappings import MapSpikeSource
from nrp_core.dsl.functions.variables import Variable
from nrp_core.findings import Code, Finding, Level

CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
"""Settings of sources that are in nA."""
_WEAKEST_NA: Final = 1e-6
"""A thousandth of a pA, which moves no cell."""
_TIMES: Final = ("sec", "secs")
"""Parts of the times in messages, which only grow."""
_PERIODS: Final = 0.5
"""How much of its period a wave needs to be one."""


@checks_function(Code.NRP297)
def currents_are_in_na(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents with a factor that turns nA into A, and for phases in radians."""
    products = {id(event.node): event for event in function.events if isinstance(event, Multiply)}
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, shape):
                value = _assigned(function, node)
                factor = abs(_factor(shape, products.get(id(value))))
                if name in CURRENTS and 0 < factor < _WEAKEST_NA:
                    message = f"'{name}' is in nA and is set to {factor:g} or a multiple; is it meant in A?"
                    yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)
                elif name == "phase" and isinstance(shape, Known) and _is_in_radians(shape.value, value):
                    yield function.declared.finding(Code.NRP297, node, _DEGREES, Level.WARNING)
    for name, mapping in function.function.mappings.items():
        decorator = function.declared.nodes.get(name)
        given = decorator.keywords if isinstance(decorator, ast.Call) else []
        if isinstance(mapping, MapSpikeSource) and any(
            one.arg == "phase" and _is_in_radians(mapping.options.get("phase"), one.value) for one in given
        ):
            yield function.declared.finding(Code.NRP297, decorator, _DEGREES, Level.WARNING)


_DEGREES: Final = "'phase' is in degrees, and pi belongs to radians: half a turn is 180"


@checks_function(Code.NRP248)
def waves_have_periods(function: CheckedFunction) -> Iterator[Finding]:
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
def currents_are_not_rounded(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that are set to a rate or voltage divided with ``//``."""
    read = {id(node) for node, owner in _levels(function) if isinstance(owner, Known)}
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True) if name in CURRENTS:
                value = _assigned(function, node)
                if not isinstance(value, ast.BinOp) or not isinstance(value.op, ast.FloorDiv):
                    continue
                if any(id(one) in read for one in ast.walk(value.left)):
                    text = ast.unparse(value)
                    message = f"'{text:.60}' rounds down to a whole number; a quotient is written '/'"
                    yield function.declared.finding(Code.NRP320, value, message, Level.WARNING)


@checks_function(Code.NRP320)
def sources_are_switched_off(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources that are only ever set to one number, where a level was passed, and so keep it."""
    if any(isinstance(one, Variable) for one in function.adapters.values()):
        return  # the function may remember that it set them, and they stay on purpose
    nodes = list(ast.walk(function.declared.node))
    if any(isinstance(one, ast.Global | ast.Nonlocal) for one in nodes):
        return  # as in a variable
    uses = Counter(one.id for one in nodes if isinstance(one, ast.Name))
    read = {id(node) for node, _ in _levels(function)}
    tests = {
        id(node): choice.test
        for choice in function.declared.own
        if isinstance(choice, ast.If)
        for node in own_nodes(choice.body)
    }
    for event in function.events:
        if not isinstance(event, Write) or event.name not in UNITS:
            continue
        match event, tests.get(id(event.node)):
            case (
                Write(ast.Attribute(ast.Name(source)) as node, Known(Device() | DeviceGroup()), name, True,
                      Known(int() | float() as value)),
                ast.Compare(one, [ast.Lt() | ast.LtE() | ast.Gt() | ast.GtE()], [other]) as test,
            ) if value and uses[source] == 1 and read & {id(one), id(other)}:  # fmt: skip
                message = (
                    f"'{name}' stays at {value:g} {UNITS[name]} once it was set: nothing sets it to another "
                    f"value; write {value:g} if {excerpt(test, 40)} else 0"
                )
                yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


def _levels(function: CheckedFunction) -> Iterator[tuple[ast.expr, Shape]]:
    """Yield the reads of rates, voltages and parts of messages, which rise and fall, and their owners."""
    for event in function.events:
        match event:
            case Read(node, Known(Device()) as owner, "rate" | "voltage", True):
                yield node, owner
            case Read(node, Instance() as owner, name, True) if name not in _TIMES:
                yield node, owner


def _assigned(function: CheckedFunction, target: ast.expr) -> ast.expr | None:
    """Return the value that a plain assignment gives to an attribute."""
    for node in function.declared.own:
        if isinstance(node, ast.Assign) and any(one is target for one in node.targets):
            return node.value
    return None


def _factor(value: Shape, product: Multiply | None) -> float:
    """Return a constant, or that by which something measured in a known unit is multiplied; otherwise 0."""
    if isinstance(value, Known) and isinstance(value.value, int | float):
        return value.value
    match product:
        case (
            Multiply(ast.BinOp(ast.Attribute()), Number(unit), Known(int() | float() as number))
            | Multiply(ast.BinOp(_, _, ast.Attribute()), Known(int() | float() as number), Number(unit))
        ) if unit:  # fmt: skip
            return number
    return 0.0


def _is_in_radians(phase: object, written: ast.expr | None) -> bool:
    """Return whether a phase of at most a turn in radians is a multiple of pi."""
    return isinstance(phase, int | float) and abs(phase) <= tau and _powers_of_pi(written) > 0


def _powers_of_pi(value: ast.expr | None) -> int:
    match value:
        case ast.UnaryOp(operand=operand):
            return _powers_of_pi(operand)
        case ast.BinOp(left, ast.Mult(), right):
            return _powers_of_pi(left) + _powers_of_pi(right)
        case ast.BinOp(left, ast.Div(), right):
            return _powers_of_pi(left) - _powers_of_pi(right)
    return getattr(value, "attr", getattr(value, "id", "")) == "pi"
