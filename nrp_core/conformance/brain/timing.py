"""Contract: runs end at the requested time, windows do not overlap, and writes act from now on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.conformance.brain.kit import EXACT_MS, BrainKit, record, times, train
from nrp_core.conformance.brain.parts import connect, spikes
from nrp_core.conformance.brain.reference import Arrival, first_spike_ms
from nrp_core.conformance.guard import undeclared
from nrp_core.errors import CapabilityError, NetworkError


class TimingTests(BrainKit):
    """The timing of a brain."""

    def test_every_spike_is_reported_in_its_own_window(self) -> None:
        brain = self.open(*self.busy())
        heard = record(brain)
        since, known = 0.0, 0
        window_ns = self.grid_ns(0.7)
        for until_ns in range(window_ns, self.grid_ns(80), window_ns):
            brain.run_until(until_ns)
            reported, now = train(heard, since), milliseconds(brain.now_ns)
            assert brain.now_ns == until_ns
            assert all(since < time <= now for _, time in reported), (since, now, reported)
            assert len(train(heard)) == known + len(reported), "a spike of an earlier window came late"
            since, known = now, known + len(reported)

    def test_splitting_a_run_is_invisible(self) -> None:
        self.require_repeatable()
        random = np.random.default_rng(5)
        trains = []
        for n_cuts in (0, 1, 7, 60):
            with self.open(*self.busy()) as brain:
                heard = record(brain)
                for cut in sorted(random.uniform(0, 80, n_cuts)):
                    self.run(brain, cut)
                self.run(brain, 80)
                trains.append(train(heard))
        whole, *others = trains
        assert len(whole) > 20
        assert others == [whole] * len(others)

    def test_a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once(self) -> None:
        edge = milliseconds(self.grid_ns(20))
        brain = self.open(spikes("s", [edge]), self.cells("n"), connect("s", "n", self.sample.strong, 2.0))
        heard = record(brain)
        for until in (10, 20, 30, 45):
            self.run(brain, until)
        assert times(heard, 0) == [edge]
        assert len(times(heard, 1)) == 1

    @pytest.mark.parametrize("delay", [1.0, 2.5, 8.0, 14.0, 70.0])
    def test_a_spike_arrives_after_its_delay_and_not_before(self, delay: float) -> None:
        sample = self.sample
        brain = self.open(spikes("s", [10.0]), self.cells("n"), connect("s", "n", sample.strong, delay))
        heard = record(brain, [1])
        self.run(brain, 31 + delay)
        expected = first_spike_ms(sample, [Arrival(10.0 + delay, sample.strong)])
        fired = times(heard, 1)
        assert fired, "the synapse had no effect"
        assert expected - self.tolerance_ms <= fired[0] <= expected + self.tolerance_ms + 1e-9

    @pytest.mark.parametrize("pre", ["source", "cell"])
    def test_a_delay_of_0_is_a_step_of_the_grid_or_is_refused(self, pre: str) -> None:
        if self.capabilities.resolution_ns is None:
            undeclared("a resolution")
        strong, step_ms = self.sample.strong, milliseconds(self.capabilities.resolution_ns)
        found = []
        for delay in (step_ms, 0.0):
            synapses = (
                connect("source", "cell", strong, 1.0),
                replace(connect(pre, "n", strong, delay), label="n"),
            )
            try:
                brain = self.open(spikes("source", [5.0]), self.cells("cell"), self.cells("n"), *synapses)
            except (CapabilityError, NetworkError):
                assert not delay
                return
            heard = record(brain)
            self.run(brain, 30)
            found.append(times(heard, 2))
        assert found[0]
        assert found[1] == found[0]

    def test_each_synapse_has_its_own_delay(self) -> None:
        delays = [9.0, 2.0, 5.5]
        fan = connect("s", "n", self.sample.strong, delays, pairs=[(0, 0), (0, 1), (0, 2)])
        brain = self.open(spikes("s", [5.0]), self.cells("n", 3), fan)
        heard = record(brain)
        self.run(brain, 35)
        first = [times(heard, 1 + i)[0] - delay for i, delay in enumerate(delays)]
        assert first == pytest.approx([first[0]] * 3, abs=self.tolerance_ms + 1e-9)

    @pytest.mark.parametrize("t_ms", [0.0, 13.0, 20.5])
    def test_a_current_acts_from_the_moment_it_is_set(self, t_ms: float) -> None:
        sample, t_ns = self.sample, self.grid_ns(t_ms)
        brain = self.open(self.cells("n"))
        heard = record(brain)
        source = brain.add_source(DCSource(), [0], name="dc")
        brain.run_until(t_ns)
        source.amplitude = 3 * sample.current_na  # type: ignore[attr-defined]
        self.run(brain, t_ms + 30)
        latency = first_spike_ms(sample, [], current_na=3 * sample.current_na)
        expected = milliseconds(t_ns) + latency
        assert times(heard, 0), "the current had no effect"
        assert expected - EXACT_MS <= times(heard, 0)[0] <= expected + self.tolerance_ms + EXACT_MS

    @pytest.mark.parametrize("delay", [0.5, 1.0, 6.0])
    def test_a_device_acts_within_its_delay_and_a_step(self, delay: float) -> None:
        sample, t_ns = self.sample, self.grid_ns(12.0)
        brain = self.open(self.cells("n"))
        heard = record(brain)
        spec = FixedFrequencySource(weight=sample.strong, delay=delay)
        source = brain.add_source(spec, [0], name="source")
        brain.run_until(t_ns)
        source.rate = 100.0  # type: ignore[attr-defined]  # the first spike after one period
        brain.run_until(t_ns + 30 * NS_PER_MS)
        arrival = milliseconds(t_ns) + 10.0 + delay
        latency = first_spike_ms(sample, [Arrival(0.0, sample.strong)])
        assert times(heard, 0), "the device had no effect"
        assert (
            arrival + latency - EXACT_MS
            <= times(heard, 0)[0]
            <= arrival + latency + self.tolerance_ms + EXACT_MS
        )
