"""Values that are most likely in another unit, and populations that cannot fire."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from math import inf, pi, radians
from typing import Final

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices.sinks import SinkPort, StateRecorderPort
from nrp_core.checks.code.values import adapter_of, is_message, value_of
from nrp_core.checks.network_units import DELAY, TIME, Range, outside, too_strong
from nrp_core.checks.static_experiment import (
    CheckedFunction,
    StaticExperiment,
    checks_experiment,
    checks_function,
    sent_value,
)
from nrp_core.checks.synaptic_effects import too_weak
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import Adapter
from nrp_core.dsl.selection import Selection
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.network.data import Network, Population
from nrp_core.scene.rigid import ROUNDED_TURN_RAD

_TWO_TURNS_RAD: Final = 4 * pi
"""Joints of robots with limits turn less, and wheels are commanded by speeds."""
_MULTIPLE_DEG: Final = 5.0
"""Angles in degrees are multiples of this, as a rule; counted turns are not."""
CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
"""Settings of sources that are in nA."""
_HEAVIEST: Final = 100.0
"""The largest weight, uS or nA: a hundred times the leak of the largest neurons."""
_CURRENT: Final = Range(1e-6, 50.0, "nA", "A", "pA")  # a thousandth of a pA moves no cell
_RANGES: Final = {
    **dict.fromkeys(CURRENTS, _CURRENT),
    **dict.fromkeys(("delay", "dt"), DELAY._replace(high=inf)),
}
"""Of the settings of devices; those of time constants are that of cells."""


@checks_experiment
def check_populations(static: StaticExperiment) -> Iterator[Finding]:
    """Look for populations that nothing can make fire, and whose spikes a function or others need."""
    experiment, network = static.experiment, static.network
    # functions of the platform change cells by the brain's variables, and interventions drive them
    changes = experiment.compatibility or experiment.brain.interventions
    knows_devices = static.is_complete and all(one.code is not Code.NRP239 for one in static.findings)
    if network is None or changes or not knows_devices:
        return
    for label, why in static.summary.unreached.items():
        devices = [one for one in static.devices if has_cells(network, label, one.neurons)]
        sinks = [one for one in devices if isinstance(one, SinkPort)]
        reads_spikes = not all(isinstance(one, StateRecorderPort) for one in sinks)
        leads_on = bool(static.devices) and any(pre == label for pre, _ in static.summary.joined)
        if len(sinks) == len(devices) and (reads_spikes or leads_on):
            then = "a function reads its spikes" if reads_spikes else "its synapses transmit none"
            message = f"no cell of the population '{label}' can fire, and {then}: {why}"
            yield static.warning(Code.NRP377, message, "brain", "model")


def has_cells(network: Network, label: str, neurons: IntArray) -> bool:
    """Return whether cells of a population are among some neurons."""
    first = network.offsets[label]
    return bool(((neurons >= first) & (neurons < first + network.populations[label].size)).any())


@checks_experiment
def check_views(static: StaticExperiment) -> Iterator[Finding]:
    """Look for named populations that have a neuron twice."""
    if static.network is None:
        return
    for name in static.experiment.brain.populations:
        neurons = static.network.views.get(name)
        if neurons is not None and len(set(neurons.tolist())) < len(neurons):
            message = f"the population '{name}' has {len(set(neurons.tolist()))} neurons, some of them twice"
            yield static.warning(Code.NRP211, message, "brain", "populations", name)


@checks_experiment
def report_network(static: StaticExperiment) -> Iterator[Finding]:
    """Report values in another unit, and what the script or file has that the network lacks."""
    collector = Collector(static.experiment.source)
    collector.place(static.summary.findings, "brain", "model")
    yield from collector.findings


# -- devices


@checks_function
def check_devices(function: CheckedFunction) -> Iterator[Finding]:
    """Look for devices with a neuron twice, and for weights, currents and times in a wrong unit."""
    for name, mapping in function.function.mappings.items():
        if isinstance(mapping, MapSpikeSource | MapSpikeSink):
            node = function.declared.nodes.get(name)
            for code, message in _wrong_device(name, mapping, function.adapters.get(name)):
                yield function.warning(code, node, message)


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
        plausible = TIME._replace(high=inf) if setting.startswith("tau_") else _RANGES.get(setting)
        if isinstance(value, int | float) and plausible is not None:
            found = outside(f"{setting} of '{name}'", np.array([value], float), plausible)
            yield from ((Code.NRP297, message) for message in found)


def _driven(selections: list[Selection]) -> list[Population]:
    """Return the populations with cells that are selected."""
    found: dict[str, Population] = {}
    for ids, network in ((one.ids, one.network) for one in selections if one.network is not None):
        found |= {name: one for name, one in network.populations.items() if has_cells(network, name, ids)}
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


@checks_function
def check_currents(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that a body sets in a wrong unit."""
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Attribute(owner, name) as target], value) if name in CURRENTS:
                constant = function.body.constant(value)
                is_device = isinstance(adapter_of(function.body.shape(owner)), Device | DeviceGroup)
                if constant is not None and is_device:
                    for message in outside(f"'{name}'", np.array([constant]), _CURRENT):
                        yield function.warning(Code.NRP297, target, message)


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
        if (found := sent_value(function, node)) is None or found[0].unit != "rad":
            continue
        info, sent = found
        value = sent
        if isinstance(sent, ast.Call) and len(sent.args) == 1:
            value = sent.args[0] if is_message(value_of(function.body.shape(sent.func))) else sent
        angle = function.body.constant(value)
        if angle is not None and abs(angle) > _TWO_TURNS_RAD and not angle % _MULTIPLE_DEG:
            message = (
                f"'{info.name}' takes radians, and {angle:g} is {abs(angle) / (2 * pi):.0f} turns; "
                f"{angle:g} degrees are {radians(angle):.4g}"
            )
            yield function.warning(Code.NRP249, sent, message)
