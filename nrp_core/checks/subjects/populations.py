"""Populations that nothing reaches, sources and projections without an effect."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort, StateRecorderPort
from nrp_core.checks.check import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.experiment.model.collector import Collector
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP290, Code.NRP377)
def check_populations(static: StaticExperiment) -> Iterator[Finding]:
    """Look for populations without a synapse and without a device, as far as all devices are known.

    Look also for those whose spikes a function reads although nothing can make them fire.
    """
    if static.network is None or not _knows_devices(static):
        return
    experiment = static.experiment
    connected = {end for pair in static.summary.joined for end in pair}
    place = experiment.place("brain", "model")
    # functions of the platform change cells by the brain's variables, and interventions drive them
    changes = experiment.compatibility or experiment.brain.interventions
    mute = [] if changes else static.summary.mute
    unreached = {} if changes else static.summary.unreached
    for label, population in static.network.populations.items():
        devices = _devices(static, label)
        if label not in connected and not devices:
            message = f"the population '{label}' ({population.size} cells) has no synapse and no device"
            yield place.finding(Code.NRP290, message, Level.NOTE)
        reads_spikes = any(
            isinstance(one, SinkPort) and not isinstance(one, StateRecorderPort) for one in devices
        )
        leads_on = bool(static.devices) and any(pre == label for pre, _ in static.summary.joined)
        is_driven = any(isinstance(one, SourcePort) for one in devices)
        if (label in mute or label in unreached) and not is_driven and (reads_spikes or leads_on):
            then = "a function reads its spikes" if reads_spikes else "its synapses transmit none"
            why = "no synapse and no device excites it, and its own current does not take it to its threshold"
            message = f"no cell of the population '{label}' can fire, and {then}: {unreached.get(label, why)}"
            code = Code.NRP377 if label in unreached else Code.NRP290
            yield place.finding(code, message, Level.WARNING)


@checks_experiment(Code.NRP290)
def check_paths(static: StaticExperiment) -> Iterator[Finding]:
    """Look for networks in which no synapses lead from what functions drive to what they read."""
    if static.network is None or not _knows_devices(static) or static.experiment.compatibility:
        return
    devices = {label: _devices(static, label) for label in static.network.populations}
    driven, read = (
        {label for label, some in devices.items() if any(isinstance(one, kind) for one in some)}
        for kind in (SourcePort, SinkPort)
    )
    reached = set(driven)
    while more := {post for pre, post in static.summary.joined if pre in reached} - reached:
        reached |= more
    if driven and read and not reached & read:
        message = (
            "nothing that functions drive reaches anything that they read: no synapses lead from "
            f"{_listed(driven)} to {_listed(read)}"
        )
        place = static.experiment.place("brain", "model")
        yield place.finding(Code.NRP290, message, Level.WARNING)


def _knows_devices(static: StaticExperiment) -> bool:
    """Return whether all devices and their neurons are known before the run."""
    return static.is_complete and all(one.code is not Code.NRP239 for one in static.findings)


def _devices(static: StaticExperiment, label: str) -> list[SourcePort | SinkPort]:
    """Return the devices on cells of a population."""
    assert static.network is not None
    first = static.network.offsets[label]
    after = first + static.network.populations[label].size
    return [one for one in static.devices if ((one.neurons >= first) & (one.neurons < after)).any()]


def _listed(labels: set[str]) -> str:
    return ", ".join(map(repr, sorted(labels)))


@checks_experiment(Code.NRP211)
def check_views(static: StaticExperiment) -> Iterator[Finding]:
    """Look for named populations that have a neuron twice."""
    if static.network is None:
        return
    for name in static.experiment.brain.populations:
        neurons = static.network.views.get(name)
        if neurons is not None and len(set(neurons.tolist())) < len(neurons):
            message = f"the population '{name}' has {len(set(neurons.tolist()))} neurons, some of them twice"
            place = static.experiment.place("brain", "populations", name)
            yield place.finding(Code.NRP211, message, Level.WARNING)


@checks_experiment(Code.NRP297, Code.NRP308)
def report_network(static: StaticExperiment) -> Iterator[Finding]:
    """Report values in another unit, and what the script or file has that the network lacks."""
    collector = Collector(static.experiment.source)
    collector.place(static.summary.findings, "brain", "model")
    yield from collector.findings
