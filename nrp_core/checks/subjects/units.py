"""Values that are most likely in another unit: angles, currents, weights, times."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from math import pi, radians
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain.network.data import Network, Population
from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.values import Known, adapter_of, is_message
from nrp_core.checks.network_units import too_strong
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.checks.unreachable_thresholds import too_weak
from nrp_core.clock import milliseconds
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import ParameterMapping, PublishedTopic
from nrp_core.dsl.selection import BrainRoot, Selection, select
from nrp_core.errors import NrpError
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
_REMEMBERED: Final = 100.0
"""Time constants after which a spike is forgotten beyond doubt."""


# -- devices


@checks_experiment(Code.NRP211, Code.NRP297, Code.NRP377)
def check_mappings(static: StaticExperiment) -> Iterator[Finding]:
    """Check the mappings of all functions."""
    if static.network is not None:
        for declared in static.declared:
            yield from _check_mappings_of(declared.function, static.network)


def _check_mappings_of(function: TransferFunction, network: Network) -> Iterator[Finding]:
    """Yield findings about mappings with a neuron twice or an unlikely weight."""
    for name, mapping in function.mappings.items():
        match mapping:
            case MapSpikeSource() | MapSpikeSink():
                verb = "drives" if mapping.drives else "reads"
                for ids in _chosen(mapping, network):
                    most = int(np.unique(ids, return_counts=True)[1].max())
                    if most > 1:
                        message = f"'{name}' {verb} the same neuron {most} times: {mapping.selector!r}"
                        yield _at(mapping, Code.NRP211, message)
                        break
                if size := _too_strong_source(mapping, network):
                    yield _at(mapping, Code.NRP297, f"weight of '{name}' is {size}")
                elif size := _too_weak_source(mapping, network):
                    yield _at(mapping, Code.NRP377, f"weight of '{name}' is {size}")


def _too_strong_source(mapping: MapSpikeSource | MapSpikeSink, network: Network) -> str:
    """Return the weight of a source with its effect on its cells if that is implausibly large."""
    return next(filter(None, _sizes(too_strong, mapping, network)), "")


def _too_weak_source(mapping: MapSpikeSource | MapSpikeSink, network: Network) -> str:
    """Return the weight of a source if it takes none of its cells to their threshold at any rate."""
    sizes = list(_sizes(too_weak, mapping, network))
    return sizes[0] if sizes and all(sizes) else ""


def _sizes(
    judge: Callable[[float, Population], str], mapping: MapSpikeSource | MapSpikeSink, network: Network
) -> Iterator[str]:
    """Yield the judgement of the weight of a source for each population that it drives."""
    weight = mapping.options.get("weight")
    if not isinstance(mapping, MapSpikeSource) or not isinstance(weight, int | float):
        return
    if "synapse_type" in mapping.options:
        return  # it may transmit a small share of the weight
    driven = [ids for ids in _chosen(mapping, network) if ids.size]
    for label, population in network.populations.items():
        first = network.offsets[label]
        if any(((ids >= first) & (ids < first + population.size)).any() for ids in driven):
            yield "" if population.is_source else judge(abs(weight), population)


def _chosen(
    mapping: MapSpikeSource | MapSpikeSink, network: Network
) -> Iterator[np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Yield the neurons of each device of a mapping; unbindable mappings are reported elsewhere."""
    try:
        selected = select(mapping.selector, BrainRoot(network))
    except (NrpError, ValueError, TypeError):
        return
    yield from (one.ids for one in ([selected] if isinstance(selected, Selection) else selected))


def _at(mapping: ParameterMapping, code: Code, message: str) -> Finding:
    place = mapping.place
    return Finding(code, message, Level.WARNING, Path(place.path), place.line)


@checks_function(Code.NRP297)
def check_device_settings(function: CheckedFunction) -> Iterator[Finding]:
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
    return any(network is not None and _too_strong_source(mapping, network) != "" for network in networks[:1])


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


@checks_experiment(Code.NRP249)
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


@checks_function(Code.NRP249)
def check_commanded_angles(function: CheckedFunction) -> Iterator[Finding]:
    """Look for constant commands of joints that are angles in degrees."""
    for node in function.declared.own:
        match node:
            case ast.Call(ast.Attribute(owner, "send_message"), [sent]) if isinstance(
                topic := adapter_of(function.body.shape(owner)), PublishedTopic
            ):
                info = topic.info
            case ast.Return(ast.expr() as sent) if function.returns_to is not None:
                info = function.returns_to
            case _:
                continue
        value = sent
        if isinstance(sent, ast.Call) and len(sent.args) == 1:
            callee = function.body.shape(sent.func)
            value = sent.args[0] if isinstance(callee, Known) and is_message(callee.value) else sent
        if message := _in_degrees(info, function.body.constant(value)):
            yield function.declared.finding(Code.NRP249, sent, message, Level.WARNING)


@checks_experiment(Code.NRP249)
def check_angles_of_events(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events that command a joint by an angle in degrees."""
    for name, event in static.experiment.events.items():
        for published in event.publish:
            info = static.topics.get(static.experiment.aliases.get(published.topic, published.topic))
            given = published.value
            value = next(iter(given.values()), None) if isinstance(given, dict) else given
            if info is not None and isinstance(value, int | float) and (message := _in_degrees(info, value)):
                place = static.experiment.place("events", name, "publish")
                yield place.finding(Code.NRP249, message, Level.WARNING)


def _in_degrees(info: TopicInfo, angle: float | None) -> str:
    """Return that a command is in degrees; empty if it may be in the unit of its topic."""
    if angle is None or info.unit != "rad" or abs(angle) <= _TWO_TURNS_RAD or angle % _MULTIPLE_DEG:
        return ""
    return (
        f"'{info.name}' takes radians, and {angle:g} is {abs(angle) / (2 * pi):.0f} turns; "
        f"{angle:g} degrees are {radians(angle):.4g}"
    )
