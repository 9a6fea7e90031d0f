"""Contract: the order of calls, the end of runs, and the time from which writes act."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nrp_conformance.base import skip_undeclared
from nrp_conformance.brain.kit import EXACT_MS, SAMPLES, BrainKit, connect, record, spikes, times, train
from nrp_conformance.brain.reference import Arrival, first_spike_ms
from nrp_core.brain import BRAIN_INTERFACE_VERSION, DCSource, FixedFrequencySource
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.errors import CapabilityError, LifecycleError, NetworkError


class LifecycleTests(BrainKit):
    """The life cycle of a brain, from opening to closing."""

    def test_a_fresh_brain_is_at_time_zero_with_its_seed(self) -> None:
        brain = self.open(self.cells("n", 3), seed=12)
        assert (brain.now_ns, brain.seed, brain.network.size) == (0, 12, 3)
        assert self.backend.interface_version == BRAIN_INTERFACE_VERSION

    def test_at_least_one_declared_cell_is_a_standard_one(self) -> None:
        """Nearly all tests need one of the standard cells."""
        declared = self.capabilities.cells
        assert declared & SAMPLES.keys(), f"declared: {sorted(declared)}; standard: {sorted(SAMPLES)}"

    def test_time_does_not_run_backwards(self) -> None:
        brain = self.open(self.cells("n"))
        self.run(brain, 10)
        with pytest.raises(LifecycleError):
            self.run(brain, 5)
        assert brain.now_ns == self.grid_ns(10)

    def test_running_to_the_current_time_does_nothing(self) -> None:
        brain = self.open(*self.busy())
        recorded = record(brain)
        self.run(brain, 20)
        before = len(recorded.spikes())
        self.run(brain, 20)
        assert len(recorded.spikes()) == before

    def test_a_closed_brain_refuses_every_call_and_can_be_closed_again(self) -> None:
        brain = self.open(self.cells("n"))
        self.run(brain, 5)
        brain.close()
        brain.close()
        for attempt in (
            lambda: self.run(brain, 10),
            brain.reset,
            brain.snapshot,
            lambda: brain.add_source(DCSource(amplitude=1.0), [0], name="dc"),
        ):
            with pytest.raises(LifecycleError):
                attempt()

    def test_closing_one_brain_leaves_another_running(self) -> None:
        one, two = self.open(*self.busy()), self.open(*self.busy())
        recorded = record(two)
        self.run(one, 10)
        one.close()
        self.run(two, 30)
        assert len(recorded.spikes())

    def test_an_empty_window_and_a_network_without_synapses_are_valid(self) -> None:
        brain = self.open(self.cells("n", 1))
        recorded = record(brain)
        for step in range(1, 6):
            brain.run_until(step * max(NS_PER_MS, self.capabilities.resolution_ns or 0))
        assert len(recorded.spikes()) == 0


class TimingTests(BrainKit):
    """The timing of a brain."""

    def test_every_spike_is_reported_in_its_own_window(self) -> None:
        brain = self.open(*self.busy())
        recorded = record(brain)
        since, known = 0.0, 0
        window_ns = self.grid_ns(0.7)
        for until_ns in range(window_ns, self.grid_ns(80), window_ns):
            brain.run_until(until_ns)
            reported, now = train(recorded, since), milliseconds(brain.now_ns)
            assert brain.now_ns == until_ns
            assert all(since < time <= now for _, time in reported), (since, now, reported)
            assert len(train(recorded)) == known + len(reported), "a spike of an earlier window came late"
            since, known = now, known + len(reported)

    def test_splitting_a_run_is_invisible(self) -> None:
        self.require_repeatable()
        random = np.random.default_rng(5)
        trains = []
        for n_cuts in (0, 1, 7, 60):
            with self.open(*self.busy()) as brain:
                recorded = record(brain)
                for cut in sorted(random.uniform(0, 80, n_cuts)):
                    self.run(brain, cut)
                self.run(brain, 80)
                trains.append(train(recorded))
        whole, *others = trains
        assert len(whole) > 20
        assert others == [whole] * len(others)

    def test_a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once(self) -> None:
        edge = milliseconds(self.grid_ns(20))
        brain = self.open(spikes("s", [edge]), self.cells("n"), connect("s", "n", self.sample.strong, 2.0))
        recorded = record(brain)
        for until in (10, 20, 30, 45):
            self.run(brain, until)
        assert times(recorded, 0) == [edge]
        assert len(times(recorded, 1)) == 1

    @pytest.mark.parametrize("delay", [1.0, 2.5, 8.0, 14.0, 70.0])
    def test_a_spike_arrives_after_its_delay_and_not_before(self, delay: float) -> None:
        sample = self.sample
        brain = self.open(spikes("s", [10.0]), self.cells("n"), connect("s", "n", sample.strong, delay))
        recorded = record(brain, [1])
        self.run(brain, 31 + delay)
        expected = first_spike_ms(sample, [Arrival(10.0 + delay, sample.strong)])
        fired = times(recorded, 1)
        assert fired, "the synapse had no effect"
        assert expected - self.tolerance_ms <= fired[0] <= expected + self.tolerance_ms + 1e-9

    @pytest.mark.parametrize("pre", ["source", "cell"])
    def test_a_delay_of_0_is_a_step_of_the_grid_or_is_refused(self, pre: str) -> None:
        if self.capabilities.resolution_ns is None:
            skip_undeclared("a resolution")
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
            recorded = record(brain)
            self.run(brain, 30)
            found.append(times(recorded, 2))
        assert found[0]
        assert found[1] == found[0]

    def test_each_synapse_has_its_own_delay(self) -> None:
        delays = [9.0, 2.0, 5.5]
        fan = connect("s", "n", self.sample.strong, delays, pairs=[(0, 0), (0, 1), (0, 2)])
        brain = self.open(spikes("s", [5.0]), self.cells("n", 3), fan)
        recorded = record(brain)
        self.run(brain, 35)
        first = [times(recorded, 1 + i)[0] - delay for i, delay in enumerate(delays)]
        assert first == pytest.approx([first[0]] * 3, abs=self.tolerance_ms + 1e-9)

    @pytest.mark.parametrize("t_ms", [0.0, 13.0, 20.5])
    def test_a_current_acts_from_the_moment_it_is_set(self, t_ms: float) -> None:
        sample, t_ns = self.sample, self.grid_ns(t_ms)
        brain = self.open(self.cells("n"))
        recorded = record(brain)
        source = brain.add_source(DCSource(), [0], name="dc")
        brain.run_until(t_ns)
        source.amplitude = 3 * sample.current_na  # type: ignore[attr-defined]
        self.run(brain, t_ms + 30)
        latency = first_spike_ms(sample, [], current_na=3 * sample.current_na)
        expected = milliseconds(t_ns) + latency
        assert times(recorded, 0), "the current had no effect"
        assert expected - EXACT_MS <= times(recorded, 0)[0] <= expected + self.tolerance_ms + EXACT_MS

    @pytest.mark.parametrize("delay", [0.5, 1.0, 6.0])
    def test_a_device_acts_within_its_delay_and_a_step(self, delay: float) -> None:
        sample, t_ns = self.sample, self.grid_ns(12.0)
        brain = self.open(self.cells("n"))
        recorded = record(brain)
        spec = FixedFrequencySource(weight=sample.strong, delay=delay)
        source = brain.add_source(spec, [0], name="source")
        brain.run_until(t_ns)
        source.rate = 100.0  # type: ignore[attr-defined]  # the first spike after one period
        brain.run_until(t_ns + 30 * NS_PER_MS)
        arrival = milliseconds(t_ns) + 10.0 + delay
        latency = first_spike_ms(sample, [Arrival(0.0, sample.strong)])
        assert times(recorded, 0), "the device had no effect"
        assert (
            arrival + latency - EXACT_MS
            <= times(recorded, 0)[0]
            <= arrival + latency + self.tolerance_ms + EXACT_MS
        )
