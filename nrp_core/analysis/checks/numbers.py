"""Divisions, and the units of the values of devices."""

from __future__ import annotations

from collections.abc import Iterator
from math import tau

from nrp_core.analysis.events import Add, Divide, Write
from nrp_core.analysis.registry import checks_experiment, checks_function
from nrp_core.analysis.shapes import UNITS, Known, Number, Shape, item_of
from nrp_core.analysis.study import Examined, Study
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP232)
def nothing_is_divided_by_zero(function: Examined) -> Iterator[Finding]:
    """Look for constant divisors that are zero."""
    for event in function.events:
        match event:
            case Divide(node, left, Known(int() | float() as divisor)) if divisor == 0:
                if not (isinstance(left, Known) and isinstance(left.value, str)):
                    yield function.declared.finding(Code.NRP232, node, "this divides by zero")


@checks_function(Code.NRP233)
def units_agree(function: Examined) -> Iterator[Finding]:
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


@checks_experiment(Code.NRP249)
def angles_have_units(study: Study) -> Iterator[Finding]:
    """Look for angles of poses given in degrees instead of radians."""
    experiment = study.experiment
    for name in experiment.world.robots:
        for i, what in enumerate(("roll", "pitch", "yaw"), start=3):
            keys = "world", "robots", name, "pose", i
            written, reached = experiment.source.nearest(keys)
            value = written.value
            if reached == keys and isinstance(value, (int, float)) and abs(value) > tau:
                message = f"the {what} of '{name}' is {value:g} rad, more than a turn; write '{value:g} deg'"
                yield written.place.finding(Code.NRP249, message, Level.WARNING)


def _unit(shape: Shape) -> str | None:
    found = shape if isinstance(shape, Number) else item_of(shape)
    return found.unit if isinstance(found, Number) else None
