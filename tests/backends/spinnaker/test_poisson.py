"""Poisson populations that the machine draws itself."""

from collections.abc import Callable

import numpy as np
import pytest
from nrp_brain_spinnaker.hardware import POISSON_SOURCES_PER_CORE
from nrp_brain_spinnaker.machine.generator import mean_interval

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.network.data import Population, Projection

MS = 1_000_000


def poisson(size: int, rate: float, start: float = 0.0, duration: float = np.inf) -> Population:
    given = {"rate": rate, "start": start, "duration": duration}
    return Population("p", size, "SpikeSourcePoisson", {name: np.full(size, v) for name, v in given.items()})


def counts(brain: Brain, until_ms: int) -> np.ndarray:
    """Return how often each cell fires."""
    recorder = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="all")
    brain.run_until(until_ms * MS)
    return np.bincount(recorder.spikes().neurons, minlength=brain.network.size)


@pytest.mark.parametrize(
    ("rate", "duration_ms"),
    [(2.0, 2000), (9.0, 2000), (20.0, 1000), (700.0, 100), (4000.0, 50), (25000.0, 20)],
)
def test_mean_and_variance_are_those_of_poisson(
    rate: float, duration_ms: int, open_brain: Callable[..., Brain]
) -> None:
    size = 400
    seen = counts(open_brain(poisson(size, rate), poisson="machine"), duration_ms)
    expected = rate * duration_ms / 1000
    if rate < 10:  # slow sources have a whole number of ticks as their mean interval
        expected = duration_ms / mean_interval(rate, 1000)
    error = np.sqrt(expected / size)
    assert seen.mean() == pytest.approx(expected, abs=4 * error)
    assert seen.var() == pytest.approx(expected, rel=0.3)


def test_sources_are_silent_outside_their_time(open_brain: Callable[..., Brain]) -> None:
    brain = open_brain(poisson(50, 500.0, start=20.0, duration=30.0), poisson="machine")
    recorder = brain.add_sink(SpikeRecorder(), np.arange(50), name="all")
    brain.run_until(100 * MS)
    times = recorder.spikes().times_ms
    assert (times.min(), times.max()) == (21.0, 50.0)


def test_a_rate_of_zero_never_spikes(open_brain: Callable[..., Brain]) -> None:
    assert counts(open_brain(poisson(50, 0.0), poisson="machine"), 1000).sum() == 0


def test_cells_of_one_core_and_of_two_are_independent(open_brain: Callable[..., Brain]) -> None:
    brain = open_brain(poisson(POISSON_SOURCES_PER_CORE + 20, 100.0), poisson="machine")
    assert len(brain._poisson.generators) == 2
    seen = counts(brain, 1000)
    assert len({tuple(row) for row in brain._poisson.generators.tolist()}) == 2
    assert np.corrcoef(seen[:20], seen[-20:])[0, 1] < 0.7


def test_drawn_spikes_go_through_the_networks_synapses(
    cells: Callable[..., Population], connect: Callable[..., Projection], open_brain: Callable[..., Brain]
) -> None:
    parts = poisson(1, 50.0), cells("n", "IF_curr_delta"), connect("p", "n", 20.0, 2.0)
    brain = open_brain(*parts, poisson="machine")
    recorder = brain.add_sink(SpikeRecorder(), [0, 1], name="all")
    brain.run_until(500 * MS)
    spikes = recorder.spikes()
    sent = spikes.times_ms[(spikes.neurons == 0) & (spikes.times_ms <= 498)]
    arrived = spikes.times_ms[spikes.neurons == 1]
    assert len(sent) > 10
    assert set(arrived) <= set(sent + 2)


def test_by_default_the_core_draws(open_brain: Callable[..., Brain]) -> None:
    a, b = (counts(open_brain(poisson(20, 200.0), substeps=n), 200) for n in (1, 2))
    assert (a == b).all()
    assert a.sum() > 500
