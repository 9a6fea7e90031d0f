"""The state of a brain is reset while time goes on: it fires as it did from time 0, as much later."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha, SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network, Population

BACKENDS = [("event", {}), ("event", {"resolution": "0.1 ms"}), ("spinnaker", {})]
Open = Callable[..., Brain]
Train = tuple[list[int], list[float]]


@pytest.fixture(params=BACKENDS, ids=str)
def opened(
    request: pytest.FixtureRequest,
    cells: Callable[..., Population],
    spike_source: Callable[..., Population],
    connect: Callable[..., object],
) -> Open:
    name, options = request.param

    def open_it() -> Brain:
        backend = brains().load(name)
        given = spike_source("given", [0.0, 3.0, 4.0, 9.0, 22.0, 23.0, 41.0])
        populations = {"given": given, "cell": cells("cell", "IF_curr_exp", 2, i_offset=0.4)}
        synapses = [connect("given", "cell", 8.0, 6.0, pairs=[(0, 0)]), connect("cell", "cell", 5.0, 2.0)]
        network = Network(populations, synapses)
        return backend.open(network, seed=5, options=backend.options.model_validate(options))

    return open_it


def fired(brain: Brain, since_ms: float, until_ms: float, recorder: object) -> Train:
    """Run from one time to another; return ids, and times after the first, of the spikes between."""
    brain.run_until(round(until_ms * NS_PER_MS))
    spikes = recorder.spikes().within(since_ms, until_ms)  # type: ignore[attr-defined]
    return spikes.neurons.tolist(), np.round(spikes.times_ms - since_ms, 6).tolist()


@pytest.mark.parametrize("after_ms", [1, 10, 24, 60])
def test_it_fires_as_from_the_beginning(opened: Open, after_ms: int) -> None:
    fresh, brain = opened(), opened()
    expected = fired(fresh, -1e-9, 80, fresh.add_sink(SpikeRecorder(), [0, 1, 2], name="all"))
    assert len(expected[0]) > 10
    recorder = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="all")
    brain.run_until(after_ms * NS_PER_MS)
    brain.reset("state")
    assert brain.now_ns == after_ms * NS_PER_MS
    assert fired(brain, after_ms, after_ms + 80, recorder) == expected


def test_devices_keep_their_values_and_what_they_recorded(opened: Open) -> None:
    brain = opened()
    recorder = brain.add_sink(SpikeRecorder(), [1, 2], name="all")
    voltage = brain.add_sink(LeakyIntegratorAlpha(), [1], name="voltage")
    source = brain.add_source(DCSource(), [2], name="dc")
    source.amplitude = 3.0  # type: ignore[attr-defined]
    brain.add_source(FixedFrequencySource(rate=100.0, delay=1.0, weight=6.0), [1], name="clock")
    brain.run_until(50 * NS_PER_MS)
    before, level = recorder.spikes(), voltage.voltage  # type: ignore[attr-defined]
    brain.reset("state")
    assert (len(recorder.spikes()), voltage.voltage) == (len(before), level)  # type: ignore[attr-defined]
    brain.run_until(100 * NS_PER_MS)
    later = recorder.spikes().within(50, 100)
    assert (later.neurons == 1).sum() > 1
    assert (later.neurons == 2).sum() > 5


def test_a_snapshot_holds_the_time_of_the_last_reset_of_the_state(opened: Open) -> None:
    brain = opened()
    recorder = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="all")
    brain.run_until(13 * NS_PER_MS)
    brain.reset("state")
    brain.run_until(17 * NS_PER_MS)
    saved = brain.snapshot()
    first = fired(brain, 17, 60, recorder)
    brain.restore(saved)
    assert fired(brain, 17, 60, recorder) == first
    brain.reset()
    again = fired(brain, -1e-9, 80, recorder)
    fresh = opened()
    assert again == fired(fresh, -1e-9, 80, fresh.add_sink(SpikeRecorder(), [0, 1, 2], name="all"))


def test_spike_times_that_are_given_later_are_those_of_the_run(opened: Open) -> None:
    brain = opened()
    recorder = brain.add_sink(SpikeRecorder(), [0], name="given")
    brain.run_until(30 * NS_PER_MS)
    brain.reset("state")
    brain.set_spike_times("given", [[20.0, 33.0, 35.0]])
    assert fired(brain, 30, 50, recorder)[1] == [3.0, 5.0]
