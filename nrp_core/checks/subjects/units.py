"""Values that are most likely in another unit: angles, currents, weights, times."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from math import pi, radians
from typing import Final

import numpy as np

from nrp_core.brain.network.data import Population
from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.values import Known, adapter_of, is_message
from nrp_core.checks.network_units import too_strong
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment, sent_value
from nrp_core.checks.unreachable_thresholds import too_weak
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import Adapter
from nrp_core.dsl.selection import Selection
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.rigid import ROUNDED_TURN_RAD
from nrp_core.world.topics import TopicInfo

_TWO_TURNS_RAD: Final = 4 * pi
"""Joints of robots with limits turn less, and wheels are commanded by speeds."""
_MULTIPLE_DEG: Final = 5.0
"""Angles in degrees are multiples of this, as a rule; counted turns are not."""
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


# -- devices


@checks_function
def check_devices(function: CheckedFunction) -> Iterator[Finding]:
    """Look for devices with a neuron twice, and for weights, currents and times in a wrong unit."""
    for name, mapping in function.function.mappings.items():
        if isinstance(mapping, MapSpikeSource | MapSpikeSink):
            node = function.declared.nodes.get(name)
            for code, message in _wrong_device(name, mapping, function.adapters.get(name)):
                yield function.declared.finding(code, node, message, Level.WARNING)


def _wrong_device(
    name: str, mapping: MapSpikeSource | MapSpikeSink, adapter: Adapter | None
) -> Iterator[tuple[Code, str]]:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    selections = [one.selection for one in devices if isinstance(one, Device) and one.selection.size]
    most = max((int(np.unique(one.ids, return_counts=True)[1].max()) for one in selections), default=0)
    if most > 1:
        verb = "drives" if mapping.drives else "reads"
        yield Code.NRP211, f"'{name}' {verb} the same neuron {most} times: {mapping.selector!r}"
    weight = mapping.options.get("weight")
    # a law of synapses may transmit a small share of the weight
    if mapping.drives and isinstance(weight, int | float) and "synapse_type" not in mapping.options:
        yield from _wrong_weight(name, abs(weight), _driven(selections))
    for setting, value in mapping.options.items():
        if isinstance(value, int | float) and (unit := _implausible(setting, abs(value))):
            yield Code.NRP297, f"{setting} of '{name}' is {value:g} {unit}"


def _driven(selections: list[Selection]) -> list[Population]:
    """Return the populations with cells that are selected."""
    found: dict[str, Population] = {}
    for ids, network in ((one.ids, one.network) for one in selections if one.network is not None):
        for label, population in network.populations.items():
            first = network.offsets[label]
            if ((ids >= first) & (ids < first + population.size)).any():
                found[label] = population
    return list(found.values())


def _wrong_weight(name: str, weight: float, driven: list[Population]) -> Iterator[tuple[Code, str]]:
    """Yield that a weight is implausibly large for some cells, or takes no cells to their threshold."""
    cells = [one for one in driven if not one.is_source]
    strong, weak = ([judge(weight, one) for one in cells] for judge in (too_strong, too_weak))
    if any(strong):
        yield Code.NRP297, f"weight of '{name}' is {next(filter(None, strong))}"
    elif weight > _HEAVIEST:
        yield Code.NRP297, f"weight of '{name}' is {weight:g} uS or nA; is it meant in nS or pA?"
    elif weak and all(weak) and len(cells) == len(driven):
        yield Code.NRP377, f"weight of '{name}' is {weak[0]}"


def _implausible(setting: str, size: float) -> str:
    """Return the unit of a setting and the one that is probably meant; empty for a plausible value."""
    shortest_ms = _SHORTEST_DELAY_MS if setting in ("delay", "dt") else _SHORTEST_MS
    if (setting.startswith("tau_") or setting in ("delay", "dt")) and 0 < size < shortest_ms:
        return "ms; is it meant in s?"
    return _implausible_current(size) if setting in CURRENTS else ""


def _implausible_current(size: float) -> str:
    if size > _STRONGEST_NA:
        return "nA; is it meant in pA?"
    return "nA; is it meant in A?" if 0.0 < size < _WEAKEST_NA else ""


@checks_function
def check_currents(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that a body sets in a wrong unit."""
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Attribute(owner, name) as target], value) if name in CURRENTS:
                is_device = isinstance(adapter_of(function.body.shape(owner)), Device | DeviceGroup)
                constant = function.body.constant(value) if is_device else None
                if constant is not None and (message := _implausible_current(abs(constant))):
                    message = f"'{name}' is {constant:g} {message}"
                    yield function.declared.finding(Code.NRP297, target, message, Level.WARNING)


@checks_experiment
def check_poses(static: StaticExperiment) -> Iterator[Finding]:
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


# -- angles and times


@checks_function
def check_commanded_angles(function: CheckedFunction) -> Iterator[Finding]:
    """Look for constant commands of joints that are angles in degrees."""
    for node in function.declared.own:
        if (found := sent_value(function, node)) is None:
            continue
        info, sent = found
        value = sent
        if isinstance(sent, ast.Call) and len(sent.args) == 1:
            callee = function.body.shape(sent.func)
            value = sent.args[0] if isinstance(callee, Known) and is_message(callee.value) else sent
        if message := _in_degrees(info, function.body.constant(value)):
            yield function.declared.finding(Code.NRP249, sent, message, Level.WARNING)


def _in_degrees(info: TopicInfo, angle: float | None) -> str:
    """Return that a command is in degrees; empty if it may be in the unit of its topic."""
    if angle is None or info.unit != "rad" or abs(angle) <= _TWO_TURNS_RAD or angle % _MULTIPLE_DEG:
        return ""
    return (
        f"'{info.name}' takes radians, and {angle:g} is {abs(angle) / (2 * pi):.0f} turns; "
        f"{angle:g} degrees are {radians(angle):.4g}"
    )
