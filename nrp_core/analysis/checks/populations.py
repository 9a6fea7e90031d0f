"""Populations that nothing reaches, sources and projections without an effect."""

from __future__ import annotations

from collections.abc import Iterator

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
