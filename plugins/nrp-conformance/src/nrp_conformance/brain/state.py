"""Contract: a reset brain equals a new one, a restored one continues exactly, after any sequence of calls."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import rule

from nrp_conformance.brain.kit import (
    BrainKit,
    Part,
    Train,
    connect,
    network,
    record,
    spikes,
    times,
    train,
)
from nrp_conformance.sequences import SequenceMachine, check_sequences
from nrp_core.brain import (
    Brain,
    DCSource,
    FixedFrequencySource,
    LeakyIntegratorAlpha,
    PoissonSource,
    PopulationRate,
    SpikeRecorderPort,
)
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.errors import SnapshotError

Watched = tuple[Brain, SpikeRecorderPort]


class SequenceTests(BrainKit):
    """Calls in random order."""

    level = "sequences"

    def test_any_sequence_of_calls_has_one_meaning(self) -> None:
        self.require_repeatable()
        check_sequences(partial(_BrainMachine, self), examples=20, length=15)


class _BrainMachine(SequenceMachine):
    """Sets devices while a brain runs, is reset and is restored."""

    def __init__(self, kit: BrainKit) -> None:
        self._kit = kit
        step_ns = kit.capabilities.resolution_ns or NS_PER_MS // 7
        super().__init__(can_restore=kit.capabilities.snapshot, step_ns=step_ns * -(-NS_PER_MS // step_ns))

    def fresh(self) -> Brain:
        kit, sample = self._kit, self._kit.sample
        brain = kit.backend.open(network(*kit.busy()), seed=3, options=kit.chosen)
        brain.add_source(PoissonSource(rate=80.0, weight=sample.strong), [5, 6], name="noise")
        brain.add_source(FixedFrequencySource(rate=30.0, weight=sample.strong), [7], name="beat")
        brain.add_source(DCSource(), [0, 8], name="dc")
        record(brain)
        return brain

    def apply(self, simulation: Brain, name: str, value: Any) -> None:
        device, _, setting = name.partition(".")
        port: Any = next(port for port in simulation.devices if port.name == device)
        setattr(port, setting, value)

    def observed(self, simulation: Brain) -> object:
        return train(simulation.devices[-1])  # type: ignore[arg-type]  # the recorder came last

    @rule(rate=st.sampled_from([0.0, 50.0, 400.0]))
    def set_noise(self, rate: float) -> None:
        self.do("noise.rate", rate)

    @rule(rate=st.sampled_from([0.0, 30.0, 90.0]))
    def set_beat(self, rate: float) -> None:
        self.do("beat.rate", rate)

    @rule(share=st.sampled_from([0.0, 0.5, 2.0]))
    def set_current(self, share: float) -> None:
        self.do("dc.amplitude", share * self._kit.sample.current_na)

    @rule(name=st.sampled_from(["noise", "beat", "dc"]), active=st.booleans())
    def switch(self, name: str, active: bool) -> None:
        self.do(f"{name}.active", active)


class StateTests(BrainKit):
    """A state contains everything that the future depends on."""

    def test_a_reset_brain_equals_a_fresh_one(self) -> None:
        self.require_repeatable()
        brain, recorded = self._with_devices()
        self.run(brain, 60)
        expected = train(recorded)
        for stop in (23, 47):
            brain.reset()
            assert brain.now_ns == 0
            assert not train(recorded)
            self.run(brain, stop)
        brain.reset()
        self.run(brain, 60)
        assert train(recorded) == expected

    def test_after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one(self) -> None:
        """The time continues: all spikes are later by the time of the reset."""
        self.require_repeatable()
        fresh, brain = self.open(*self.busy()), self.open(*self.busy())
        recorded_fresh, recorded = record(fresh), record(brain)
        self.run(fresh, 60)
        expected = train(recorded_fresh)
        reset_ns = self.grid_ns(23)
        brain.run_until(reset_ns)
        brain.reset("state")
        assert brain.now_ns == reset_ns
        brain.run_until(reset_ns + fresh.now_ns)
        found = train(recorded, milliseconds(reset_ns))
        assert [neuron for neuron, _ in found] == [neuron for neuron, _ in expected]
        shifted = [time - milliseconds(reset_ns) for _, time in found]
        assert shifted == pytest.approx([time for _, time in expected], abs=1e-6)

    def test_a_reset_forgets_spikes_in_transit(self) -> None:
        """Spikes in flight, a refractory membrane and a current of the old run are gone."""
        self.require_repeatable()
        brain = self.open(
            spikes("s", [2.0]), self.cells("n"), self.cells("m"),
            connect("s", "n", self.sample.strong, 14.0), connect("s", "m", self.sample.strong, 1.0),
        )  # fmt: skip
        recorded = record(brain)
        source = brain.add_source(DCSource(), [1], name="dc")
        self.run(brain, 30)
        expected = train(recorded)
        brain.reset()
        self.run(brain, 10)
        source.amplitude = 5 * self.sample.current_na  # type: ignore[attr-defined]
        brain.run_until(brain.now_ns + NS_PER_MS)
        brain.reset()
        self.run(brain, 30)
        assert train(recorded) == expected

    def test_a_reset_with_another_seed_equals_a_brain_opened_with_it(self) -> None:
        self.require_repeatable()
        first, recorded_first = self._with_devices()
        second, recorded = self._with_devices(seed=2)
        self.run(second, 50)
        self.run(first, 20)
        first.reset(seed=2)
        self.run(first, 50)
        assert first.seed == 2
        assert train(recorded_first) == train(recorded)

    def test_a_reset_repeats_the_noise(self) -> None:
        """By default a reset keeps the current seed."""
        self.require_repeatable()
        brain, recorded = self._with_devices(seed=7)
        self.run(brain, 40)
        expected = train(recorded)
        brain.reset()
        self.run(brain, 40)
        assert (brain.seed, train(recorded)) == (7, expected)

    def test_reading_changes_nothing(self) -> None:
        self.require_repeatable()
        variables = sorted(self.capabilities.state_variables & {"v"})
        quiet, recorded = self._with_devices()
        watched, recorded_there = self._with_devices()
        for until in range(2, 51, 2):
            self.run(quiet, until)
            self.run(watched, until)
            for variable in variables:
                watched.read_state(variable, list(range(9)))
            _ = train(recorded_there)
        assert train(recorded_there) == train(recorded)

    def test_a_snapshot_keeps_spikes_in_flight(self) -> None:
        """The snapshot is taken while a spike travels along a synapse of the network."""
        slow = connect("s", "n", self.sample.strong, 14.0)
        found = self._check_continuation((spikes("s", [5.0]), self.cells("n"), slow), 12.0, 40.0)
        assert [neuron for neuron, _ in found] == [1]

    def test_a_snapshot_keeps_spikes_in_flight_from_a_device(self) -> None:
        """The snapshot is taken between the emission of a device's spike and its arrival."""

        def drive(brain: Brain) -> None:
            spec = FixedFrequencySource(rate=100.0, weight=self.sample.strong, delay=8.0, duration=11.0)
            brain.add_source(spec, [0], name="source")

        assert len(self._check_continuation((self.cells("n"),), 14.0, 40.0, drive)) == 1

    def test_a_snapshot_keeps_the_refractory_time(self) -> None:
        """The snapshot is taken after a spike, while the membrane is refractory."""
        self.require_snapshot()
        driven = self.cells("n", i_offset=3 * self.sample.current_na)
        recorded = record(first := self.open(driven))
        self.run(first, 40)
        fired = times(recorded, 0)
        assert fired, "a cell under a current did not fire"
        assert fired[0] <= 40, f"in 40 ms a cell fired at {fired[0]:g} ms"
        self._check_continuation((driven,), fired[0] + 1.5, 60.0)

    def test_a_snapshot_keeps_the_membrane_and_its_synapses(self) -> None:
        """The snapshot is taken between an input and the spike that it causes."""
        driven = self.cells("n", i_offset=0.8 * self.sample.current_na)
        parts = (spikes("s", [3.0]), driven, connect("s", "n", self.sample.weak, 1.0))
        assert self._check_continuation(parts, 5.0, 60.0), "no cell fired"

    def test_a_snapshot_keeps_a_current(self) -> None:
        def drive(brain: Brain) -> None:
            brain.add_source(DCSource(amplitude=1.5 * self.sample.current_na), [0], name="dc")

        assert self._check_continuation((self.cells("n"),), 3.0, 60.0, drive), "the current had no effect"

    def test_a_snapshot_keeps_simultaneous_activity(self) -> None:
        self.require_repeatable()
        for stop in (7.0, 18.0, 41.0):
            assert self._check_continuation(self.busy(), stop, 80.0, self._drive), "no cell fired"

    def test_a_snapshot_keeps_the_values_of_devices(self) -> None:
        self.require_snapshot()
        shown = []
        for restored in (False, True):
            brain = self.open(spikes("s", [4.0, 9.5, 21.0]), self.cells("n"))
            sinks = [brain.add_sink(LeakyIntegratorAlpha(delay=3.0), [0], name="leaky")]
            sinks += [brain.add_sink(PopulationRate(), [0], name="rate")]
            self.run(brain, 10)
            if restored:
                snapshot = brain.snapshot()
                self.run(brain, 25)
                brain.restore(snapshot)
            self.run(brain, 30)
            shown.append([getattr(sink, str(sink.quantity)) for sink in sinks])
        assert shown[0] == shown[1]
        assert all(shown[0])

    def test_a_snapshot_of_another_network_is_refused(self) -> None:
        self.require_snapshot()
        one, two = self.open(self.cells("n", 2)), self.open(self.cells("n", 3))
        snapshot = one.snapshot()
        with pytest.raises(SnapshotError):
            two.restore(snapshot)

    def _check_continuation(
        self, parts: tuple[Part, ...], stop_ms: float, until_ms: float,
        setup: Callable[[Brain], None] = lambda _: None,
    ) -> Train:  # fmt: skip
        """Check that a restored run equals an uninterrupted one; return its events after the snapshot."""
        self.require_snapshot()

        def opened() -> Watched:
            brain = self.open(*parts)
            setup(brain)
            return brain, record(brain)

        brain, recorded = opened()
        self.run(brain, stop_ms)
        snapshot, left_ms = brain.snapshot(), milliseconds(brain.now_ns)
        self.run(brain, until_ms)
        expected = train(recorded, left_ms)
        fresh, recorded_there = opened()
        for again, found in ((brain, recorded), (fresh, recorded_there)):
            again.restore(snapshot)
            assert milliseconds(again.now_ns) == left_ms
            self.run(again, until_ms)
            assert train(found, left_ms) == expected
        return expected

    def _with_devices(self, seed: int = 1) -> Watched:
        brain = self.open(*self.busy(), seed=seed)
        self._drive(brain)
        return brain, record(brain)

    def _drive(self, brain: Brain) -> None:
        sample = self.sample
        brain.add_source(PoissonSource(rate=120.0, weight=sample.strong / 2), [5, 6, 7], name="noise")
        brain.add_source(FixedFrequencySource(rate=70.0, weight=sample.strong), [8], name="beat")
        brain.add_source(DCSource(amplitude=[0.2 * sample.current_na, 0.0]), [0, 1], name="dc")
