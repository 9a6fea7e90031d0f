"""Populations that nothing reaches, sources and projections without an effect."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from nrp_core.analysis.registry import checks_experiment
from nrp_core.analysis.study import Study
from nrp_core.clock import milliseconds
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP290)
def populations_take_part(study: Study) -> Iterator[Finding]:
    """Look for populations without a synapse and without a device, as far as all devices are known."""
    if study.network is None or not study.is_complete:
        return
    first = 0
    for label, population in study.network.populations.items():
        cells = range(first, first + population.size)
        first += population.size
        if label in study.unconnected and study.driven.isdisjoint(cells):
            message = f"the population '{label}' ({population.size} cells) has no synapse and no device"
            place = study.experiment.place("brain", "model")
            yield place.finding(Code.NRP290, message, Level.NOTE)


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
