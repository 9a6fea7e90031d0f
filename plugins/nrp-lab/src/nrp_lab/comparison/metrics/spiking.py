"""The activity of neurons: rates, regularity and times of spikes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.experiment.model.experiment import Experiment
from nrp_lab.comparison.distances import filtered_trains
from nrp_lab.comparison.metrics.base import DistanceMetric, Margin, ScalarMetric
from nrp_lab.comparison.signals import RunSignals

_SMALL = 20
"""Populations up to this size are reported neuron by neuron."""
_MOST_TRAINS = 50
"""Of larger groups, this many neurons, evenly spread, represent all in a distance."""
_FEWEST_INTERVALS = 3
_TAU_S = 0.02
"""About the time constant of a membrane: the resolution of the next neuron."""


class FiringRate(ScalarMetric):
    """Spikes per neuron and second, of groups and of the neurons of small populations."""

    name, title, unit = "rate", "Firing rate", "Hz"
    margin = Margin(at_least=1.0)  # a spike a second

    def values(self, run: RunSignals) -> Mapping[str, float]:
        return {
            part: sum(map(len, trains)) / (max(len(trains), 1) * (run.duration_s or 1.0))
            for part, trains in _parts(run)
        }

    def resolution(self, run: RunSignals) -> float:
        """One spike in a run."""
        return 1.0 / (run.duration_s or 1.0)


class Activity(ScalarMetric):
    """Spikes of all neurons, and the synapses that they reach (synaptic events), in a simulated second."""

    name, title, unit = "activity", "Activity", "Hz"
    is_compared = False  # as are the rates of populations
    margin = Margin(at_least=1.0)  # a spike a second
    needs_recording = False

    def parts(self, experiment: Experiment) -> Collection[str]:
        return "spikes", "synaptic_events"

    def values(self, run: RunSignals) -> Mapping[str, float]:
        activity, end_s = run.result.get("activity") or {}, run.result.get("sim_time_s")
        return {name: count / end_s for name, count in activity.items()} if end_s else {}


class Irregularity(ScalarMetric):
    """Coefficient of variation of the intervals between spikes: 0 for a clock, 1 for a Poisson process."""

    name, title = "cv", "Irregularity (CV)"
    margin = Margin(at_least=0.05)  # cells of one kind differ more

    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        return {part: _mean_cv(trains) for part, trains in _parts(run)}

    def resolution(self, run: RunSignals) -> float:
        return 1e-3


class SpikeTrains(DistanceMetric):
    """Van Rossum distance between the trains of each neuron, averaged over the neurons of a population.

    With 20 ms, one spike more or less is a distance of 1; a spike that is late by 2 ms is one of 0.4.
    """

    name, title = "spike_trains", "Spike trains (van Rossum)"

    def features(self, run: RunSignals) -> Mapping[str, FloatArray]:
        found = {}
        for label in run.numbers.spikes:
            trains = run.trains_s(label)
            chosen = np.linspace(0, len(trains) - 1, min(len(trains), _MOST_TRAINS)).round().astype(int)
            found[label] = filtered_trains([trains[i] for i in chosen], run.duration_s, _TAU_S)
        return found

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        samples = min(one.shape[1], other.shape[1])
        return float(np.linalg.norm(one[:, :samples] - other[:, :samples], axis=1).mean())

    def resolution(self, run: RunSignals) -> float:
        return 1e-6


def _parts(run: RunSignals) -> Iterator[tuple[str, list[FloatArray]]]:
    for group in run.groups:
        yield group, run.trains_s(group)
    for label in run.numbers.spikes:
        trains = run.trains_s(label)
        if 1 < len(trains) <= _SMALL:
            yield from ((f"{label}[{number}]", [train]) for number, train in enumerate(trains))


def _mean_cv(trains_s: list[FloatArray]) -> float | None:
    """Return the mean over the neurons that spike often enough; None if there are none."""
    intervals = [np.diff(train) for train in trains_s if len(train) > _FEWEST_INTERVALS]
    values = [float(one.std(ddof=1) / one.mean()) for one in intervals if one.mean() > 0]
    return float(np.mean(values)) if values else None
