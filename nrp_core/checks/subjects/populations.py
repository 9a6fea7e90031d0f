"""Populations that cannot fire, named populations with a neuron twice, and values of networks."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort, StateRecorderPort
from nrp_core.checks.check import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.experiment.model.collector import Collector
from nrp_core.findings import Code, Finding, Level


@checks_experiment
def check_populations(static: StaticExperiment) -> Iterator[Finding]:
    """Look for populations that nothing can make fire, and whose spikes a function or others need."""
    experiment = static.experiment
    # functions of the platform change cells by the brain's variables, and interventions drive them
    changes = experiment.compatibility or experiment.brain.interventions
    if static.network is None or changes or not _knows_devices(static):
        return
    for label, why in static.summary.unreached.items():
        devices = _devices(static, label)
        reads_spikes = any(
            isinstance(one, SinkPort) and not isinstance(one, StateRecorderPort) for one in devices
        )
        leads_on = bool(static.devices) and any(pre == label for pre, _ in static.summary.joined)
        is_driven = any(isinstance(one, SourcePort) for one in devices)
        if not is_driven and (reads_spikes or leads_on):
            then = "a function reads its spikes" if reads_spikes else "its synapses transmit none"
            message = f"no cell of the population '{label}' can fire, and {then}: {why}"
            yield experiment.place("brain", "model").finding(Code.NRP377, message, Level.WARNING)


def _knows_devices(static: StaticExperiment) -> bool:
    """Return whether all devices and their neurons are known before the run."""
    return static.is_complete and all(one.code is not Code.NRP239 for one in static.findings)


def _devices(static: StaticExperiment, label: str) -> list[SourcePort | SinkPort]:
    """Return the devices on cells of a population."""
    assert static.network is not None
    first = static.network.offsets[label]
    after = first + static.network.populations[label].size
    return [one for one in static.devices if ((one.neurons >= first) & (one.neurons < after)).any()]


@checks_experiment
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


@checks_experiment
def report_network(static: StaticExperiment) -> Iterator[Finding]:
    """Report values in another unit, and what the script or file has that the network lacks."""
    collector = Collector(static.experiment.source)
    collector.place(static.summary.findings, "brain", "model")
    yield from collector.findings
