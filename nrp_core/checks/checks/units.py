"""Values that are most likely in another unit: angles, currents, weights, times."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from math import pi, radians
from types import MethodType
from typing import Final

from nrp_core.checks.checks.device_weights import too_strong_source
from nrp_core.checks.code.shapes import UNITS, Add, Call, Known, Number, Read, Return, Shape, Write, item_of
from nrp_core.checks.code.syntax import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.clock import milliseconds
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import PublishedTopic
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.rigid import ROUNDED_TURN_RAD
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


CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
"""Settings of sources that are in nA."""
_WEAKEST_NA: Final = 1e-6
"""A thousandth of a pA, which moves no cell."""
_HEAVIEST: Final = 100.0
"""The largest weight, uS or nA: a hundred times the leak of the largest neurons."""
_STRONGEST_NA: Final = 50.0
_SHORTEST_MS: Final = 0.05
_SHORTEST_DELAY_MS: Final = 0.01
"""As for the cells and synapses of a brain script."""
_REMEMBERED: Final = 100.0
"""Time constants after which a spike is forgotten beyond doubt."""


@checks_function(Code.NRP297)
def settings_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for weights, time constants and delays of devices in a wrong unit."""
    step_ms = milliseconds(function.experiment.timestep)
    for name, mapping in function.function.mappings.items():
        if not isinstance(mapping, MapSpikeSource | MapSpikeSink):
            continue
        node = function.declared.nodes.get(name)
        for setting, value in mapping.options.items():
            if not isinstance(value, int | float):
                continue
            if setting == "weight" and _is_beyond_leak(mapping, function.adapters.get(name)):
                continue  # reported with its effect on the cells
            message = _implausible(setting, abs(value)) or _forgetful(setting, value, step_ms)
            if message:
                message = f"{setting} of '{name}' is {value:g} {message}"
                yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)


def _is_beyond_leak(mapping: MapSpikeSource | MapSpikeSink, adapter: object) -> bool:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    networks = [one.selection.network for one in devices if isinstance(one, Device)]
    return any(network is not None and too_strong_source(mapping, network) != "" for network in networks[:1])


def _implausible(setting: str, size: float) -> str:
    """Return the unit of a setting and the one that is probably meant; empty for a plausible value."""
    if setting == "weight" and size > _HEAVIEST:
        return "uS or nA; is it meant in nS or pA?"
    shortest_ms = _SHORTEST_DELAY_MS if setting in ("delay", "dt") else _SHORTEST_MS
    if (setting.startswith("tau_") or setting in ("delay", "dt")) and 0 < size < shortest_ms:
        return "ms; is it meant in s?"
    return _implausible_current(size) if setting in CURRENTS else ""


def _forgetful(setting: str, tau_ms: float, step_ms: float) -> str:
    """Return that a rate is forgotten between two steps, which read it; empty if it is not."""
    if setting != "tau_fall" or tau_ms * _REMEMBERED >= step_ms:
        return ""
    return f"ms: a rate that is read every {step_ms:g} ms has forgotten nearly all of its spikes"


def _implausible_current(size: float) -> str:
    if size > _STRONGEST_NA:
        return "nA; is it meant in pA?"
    return "nA; is it meant in A?" if 0.0 < size < _WEAKEST_NA else ""


@checks_function(Code.NRP297)
def currents_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that a body sets in a wrong unit."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, Known(int() | float() as value)):
                message = _implausible_current(abs(value)) if name in CURRENTS else ""
                if message:
                    message = f"'{name}' is {value:g} {message}"
                    yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)


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
