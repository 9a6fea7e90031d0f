"""Contract: devices are added and removed at any time; seed and name determine their noise."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from nrp_conformance.brain.kit import BrainKit, Train, record, times, train
from nrp_core.brain import (
    Brain,
    DCSource,
    FixedFrequencySource,
    PoissonSource,
    SpikeInjector,
    VoltageRecorder,
)
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError
from nrp_core.network.currents import InjectedCurrent


class DeviceTests(BrainKit):
    """The effect of devices on a network, and its end."""

    def test_a_late_device_acts_from_then_on(self) -> None:
        brain = self.open(self.cells("n", 2))
        recorded = record(brain)
        self.run(brain, 20)
        brain.add_source(DCSource(amplitude=3 * self.sample.current_na), [1], name="late")
        self.run(brain, 50)
        found = train(recorded)
        assert {neuron for neuron, _ in found} == {1}
        assert all(time > 20 for _, time in found)

    def test_a_current_of_the_network_flows_at_its_times_again_after_a_reset(self) -> None:
        on, off = self.grid_ns(20) / NS_PER_MS, self.grid_ns(50) / NS_PER_MS
        strong = 3 * self.sample.current_na
        current = InjectedCurrent(np.array([1]), np.array([on, off]), np.array([strong, 0.0]))
        brain = self.open(self.cells("n", 3), currents=[current])
        recorded = record(brain)
        self.run(brain, 90)
        found = train(recorded)
        assert {neuron for neuron, _ in found} == {1}
        times_ms = [time for _, time in found]
        assert on < min(times_ms) <= max(times_ms) < off + 5.0
        by_device = self.open(self.cells("n", 3))
        again = record(by_device)
        by_device.add_source(DCSource(amplitude=strong, start=on, stop=off), [1], name="current")
        self.run(by_device, 90)
        assert train(again) == found
        brain.reset()
        self.run(brain, 90)
        assert train(recorded) == found

    def test_a_late_recorder_records_no_earlier_spikes(self) -> None:
        brain = self.open(*self.busy())
        always = record(brain)
        self.run(brain, 20)
        late = record(brain, name="late")
        self.run(brain, 45)
        assert train(late) == train(always, self.grid_ns(20) / 1e6)
        assert train(late)

    def test_a_removed_device_has_no_effect(self) -> None:
        brain = self.open(self.cells("n"))
        recorded = record(brain)
        source = brain.add_source(DCSource(amplitude=3 * self.sample.current_na), [0], name="dc")
        self.run(brain, 30)
        assert train(recorded), "the device had no effect"
        brain.remove(source)
        self.run(brain, 90)
        settled = [time for _, time in train(recorded) if time > 30 + self.tolerance_ms]
        assert not settled

    def test_an_injected_spike_acts_after_its_delay(self) -> None:
        brain = self.open(self.cells("n", 3))
        recorded = record(brain)
        port = brain.add_source(SpikeInjector(weight=self.sample.strong, delay=3.0), [2, 1], name="injector")
        self.run(brain, 12)
        port.inject_spikes([0])  # type: ignore[attr-defined]
        self.run(brain, 40)
        ((neuron, time),) = train(recorded)
        assert neuron == 2
        assert 15 - self.tolerance_ms < time < 25

    def test_a_voltage_recorder_samples_readable_values_and_changes_nothing(self) -> None:
        if "v" not in self.capabilities.state_variables:
            brain = self.open(self.cells("n"))
            with pytest.raises(CapabilityError):
                brain.add_sink(VoltageRecorder(), [0], name="v")
            return
        driven = self.cells("n", 2, i_offset=[self.sample.current_na, 0.0])
        watched, read = self.open(driven), self.open(driven)
        port: Any = watched.add_sink(VoltageRecorder(dt=2.0), [1, 0], name="v")
        self.run(watched, 41)
        sampled, values = port.samples()
        assert sampled.tolist() == [self.grid_ns(t_ms) / NS_PER_MS for t_ms in range(0, 41, 2)]
        for time, row in zip(sampled, values, strict=True):
            self.run(read, time)
            assert row.tolist() == read.read_state("v", [1, 0]).tolist()

    def test_simultaneous_spikes_of_a_device_add_up(self) -> None:
        """Two generators of half the strength on one neuron have the effect of one."""
        sample = self.sample
        brain = self.open(self.cells("n", 2))
        recorded = record(brain)
        for neuron, n in enumerate((1, 2)):
            spec = FixedFrequencySource(rate=50.0, weight=sample.strong / n, delay=1.0, n=n)
            brain.add_source(spec, [neuron], name=f"{n} generators")
        self.run(brain, 50)
        assert times(recorded, 0), "the device had no effect"
        assert times(recorded, 1) == pytest.approx(times(recorded, 0), abs=self.tolerance_ms)

    def test_a_current_adds_to_the_offset_of_its_cell(self) -> None:
        """A cell with both fires before cells with either."""
        current_na = 1.5 * self.sample.current_na
        brain = self.open(self.cells("n", 3, i_offset=[current_na, 0.0, current_na]))
        recorded = record(brain)
        brain.add_source(DCSource(amplitude=current_na), [0, 1], name="dc")
        self.run(brain, 120)
        both, injected, offset = (min(times(recorded, cell)) for cell in range(3))
        assert both < min(injected, offset)

    def test_removing_one_of_two_currents_leaves_the_other(self) -> None:
        brain = self.open(self.cells("n", 2))
        recorded = record(brain)
        going = brain.add_source(DCSource(amplitude=1.5 * self.sample.current_na), [0, 1], name="going")
        brain.add_source(DCSource(amplitude=1.5 * self.sample.current_na), [1], name="staying")
        self.run(brain, 20)
        brain.remove(going)
        self.run(brain, 120)  # an adapting cell needs more time
        assert {neuron for neuron, time in train(recorded) if time > 30} == {1}

    def test_an_inactive_device_is_silent_and_keeps_its_settings(self) -> None:
        brain = self.open(self.cells("n"))
        recorded = record(brain)
        source = brain.add_source(DCSource(amplitude=3 * self.sample.current_na), [0], name="dc")
        source.active = False
        self.run(brain, 40)
        assert not train(recorded)
        source.active = True
        self.run(brain, 80)
        assert train(recorded), "the device had no effect"

    def test_a_device_that_does_nothing_leaves_no_trace(self) -> None:
        self.require_repeatable()

        def disturb(brain: Brain) -> None:
            brain.add_source(PoissonSource(rate=0.0, weight=self.sample.strong), [1, 2], name="idle")
            brain.add_source(DCSource(amplitude=0.0), [0], name="none")
            brain.remove(brain.add_source(DCSource(amplitude=9.0), [0, 5], name="gone"))
            record(brain, name="another")

        assert self._noisy_train(disturb) == self._noisy_train()

    def test_the_noise_of_a_device_does_not_depend_on_other_devices(self) -> None:
        self.require_repeatable()

        def drive(brain: Brain, name: str, neuron: int) -> None:
            brain.add_source(PoissonSource(rate=60.0, weight=self.sample.strong), [neuron], name=name)

        def alone(brain: Brain) -> None:
            drive(brain, "left", 0)

        def after_another(brain: Brain) -> None:
            drive(brain, "right", 1)
            drive(brain, "left", 0)

        one, two = (self._driven(setup) for setup in (alone, after_another))
        assert len(one) > 5
        assert [event for event in two if event[0] == 0] == one
        assert [time for neuron, time in two if neuron == 1] != [time for _, time in one]

    def test_equal_seeds_give_equal_noise_and_different_seeds_different_noise(self) -> None:
        self.require_repeatable()
        assert self._noisy_train() == self._noisy_train()
        assert self._noisy_train() != self._noisy_train(seed=2)

    def test_global_random_generators_are_neither_read_nor_seeded(self) -> None:
        self.require_repeatable()
        trains = []
        for seed in (1, 2):
            random.seed(seed)
            np.random.seed(seed)  # noqa: NPY002  the global generator is what is watched
            before = _global_generators()
            trains.append(self._noisy_train())
            assert _global_generators() == before
        assert trains[0] == trains[1]

    @pytest.mark.parametrize("value", [float("nan"), float("inf")])
    def test_a_value_that_is_not_finite_is_refused(self, value: float) -> None:
        brain = self.open(self.cells("n"))
        source = brain.add_source(DCSource(), [0], name="dc")
        with pytest.raises(ValueError, match="finite"):
            source.amplitude = value  # type: ignore[attr-defined]
        self.run(brain, 5)

    def _driven(self, setup: Callable[[Brain], None]) -> Train:
        brain = self.open(self.cells("n", 2))
        recorded = record(brain)
        setup(brain)
        self.run(brain, 300)
        return train(recorded)

    def _noisy_train(self, setup: Callable[[Brain], None] = lambda _: None, *, seed: int = 1) -> Train:
        with self.open(*self.busy(), seed=seed) as brain:
            recorded = record(brain)
            setup(brain)
            for until in (15, 30, 60):
                self.run(brain, until)
            return train(recorded)


def _global_generators() -> object:
    return random.getstate(), repr(np.random.get_state())  # noqa: NPY002
