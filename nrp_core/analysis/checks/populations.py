"""Populations that nothing reaches, sources and projections without an effect."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from nrp_core.analysis.registry import checks_experiment
from nrp_core.analysis.study import Study
from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.devices.state_recorder import StateRecorderPort
from nrp_core.clock import milliseconds
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP290)
def populations_take_part(study: Study) -> Iterator[Finding]:
    """Look for populations without a synapse and without a device, as far as all devices are known.

    Look also for those whose spikes a function reads although nothing can make them fire.
    """
    if study.network is None or not study.is_complete:
        return
    if any(finding.code is Code.NRP239 for finding in study.collector.findings):
        return  # a device whose neurons are known only in the run
    experiment = study.experiment
    place = experiment.place("brain", "model")
    # functions of the platform change cells by the brain's variables, and interventions drive them
    mute = [] if experiment.compatibility or experiment.brain.interventions else study.mute
    for label, population in study.network.populations.items():
        first = study.network.offsets[label]
        after = first + population.size
        devices = [one for one in study.devices if ((one.neurons >= first) & (one.neurons < after)).any()]
        if label in study.unconnected and not devices:
            message = f"the population '{label}' ({population.size} cells) has no synapse and no device"
            yield place.finding(Code.NRP290, message, Level.NOTE)
        reads_spikes = any(
            isinstance(one, SinkPort) and not isinstance(one, StateRecorderPort) for one in devices
        )
        if label in mute and reads_spikes and not any(isinstance(one, SourcePort) for one in devices):
            message = (
                f"no cell of the population '{label}' can fire, and a function reads its spikes: no synapse "
                "and no device excites it, and its own current does not take it to its threshold"
            )
            yield place.finding(Code.NRP290, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def spikes_come_in_time(study: Study) -> Iterator[Finding]:
    """Look for sources and projections without an effect before the end of the run."""
    end_ms = milliseconds(study.experiment.duration)
    for part, first_ms in study.silent:
        if first_ms is None or first_ms >= end_ms:
            when = "" if first_ms is None else f" before {first_ms:g} ms, and the run ends at {end_ms:g} ms"
            place = study.experiment.place("brain", "model")
            yield place.finding(Code.NRP248, part + when, Level.NOTE)


@checks_experiment(Code.NRP211)
def neurons_are_picked_once(study: Study) -> Iterator[Finding]:
    """Look for named populations that have a neuron twice."""
    if study.network is None:
        return
    for name in study.experiment.brain.populations:
        neurons = study.network.views.get(name)
        if neurons is not None and len(set(neurons.tolist())) < len(neurons):
            message = f"the population '{name}' has {len(set(neurons.tolist()))} neurons, some of them twice"
            place = study.experiment.place("brain", "populations", name)
            yield place.finding(Code.NRP211, message, Level.WARNING)


@checks_experiment(Code.NRP304)
def populations_are_apart_or_nested(study: Study) -> Iterator[Finding]:
    """Look for named populations that share some of their neurons, but not all neurons of either."""
    if study.network is None:
        return
    views = study.network.views
    named = {
        name: frozenset(views[name].tolist()) for name in study.experiment.brain.populations if name in views
    }
    for (one, first), (other, second) in combinations(named.items(), 2):
        shared = first & second
        if shared and shared != first and shared != second:
            message = (
                f"'{one}' and '{other}' share {len(shared)} of their {len(first)} and {len(second)} neurons; "
                "a slice ends before its second number, so that '0:5' and '5:8' share none"
            )
            place = study.experiment.place("brain", "populations", other)
            yield place.finding(Code.NRP304, message, Level.WARNING)
