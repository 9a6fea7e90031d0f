"""What every brain has from the core: the order of one advance, devices, checks, snapshots."""

from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha, SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.errors import CapabilityError, DivergedError, NeuronSelectionError, SnapshotError
from nrp_core.network.data import Network, Population, Projection

ABILITIES = BrainCapabilities(
    cells=frozenset({"Echo"}), synapses=frozenset({"static"}), state_variables=frozenset({"v"}), snapshot=True
)


class EchoBrain(Brain):
    """Each cell fires whenever something arrives; logs what it is asked to do."""

    def __init__(self, network: Network, capabilities: BrainCapabilities = ABILITIES) -> None:
        super().__init__(network, seed=3, capabilities=capabilities, identity="echo")
        self.log: list[Any] = []
        self.pending: list[tuple[float, int]] = []
        self.fired: list[tuple[float, int]] = []

    def _do_run_until(self, t_ns: int) -> None:
        self.log.append(("run", milliseconds(t_ns)))
        self.fired += [event for event in self.pending if event[0] <= milliseconds(t_ns)]
        self.pending = [event for event in self.pending if event[0] > milliseconds(t_ns)]

    def _do_take_spikes(self) -> Spikes:
        times, ids = np.array(self.fired).T if self.fired else (np.empty(0), np.empty(0))
        self.fired = []
        return Spikes(ids.astype(np.int64), times)

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self.log.append(("fire", neurons.tolist(), times_ms.tolist()))

    def _do_inject(self, events: SynapticEvents) -> None:
        self.pending += zip(events.times_ms.tolist(), events.neurons.tolist(), strict=True)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self.log.append(("current", currents_na.tolist()))

    def _do_reset(self, seed: int) -> None:
        self.pending, self.fired = [], []

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return -65.0 + neurons

    def _do_save(self) -> object:
        return list(self.pending)

    def _do_restore(self, saved: Any) -> None:
        self.pending = saved

    def _do_close(self) -> None:
        self.log.append("close")


def network() -> Network:
    """Return two echoing cells, and a source with the global id 2."""
    trains = (np.array([0.0, 7.0, 7.5, 30.0]),)
    echo = Population("echo", 2, "Echo", {})
    return Network({"echo": echo, "list": Population("list", 1, "SpikeSourceArray", {}, {}, trains)})


@pytest.fixture
def brain() -> EchoBrain:
    return EchoBrain(network())


def recorded(brain: Brain, *ends_ms: float) -> list[tuple[float, int]]:
    """Run and return all spikes as pairs."""
    recorder = brain.add_sink(SpikeRecorder(), np.arange(3), name="all")
    for end_ms in ends_ms:
        brain.run_until(round(end_ms * NS_PER_MS))
    spikes = recorder.spikes()
    return list(zip(spikes.times_ms.tolist(), spikes.neurons.tolist(), strict=True))


def test_spikes_of_sources_are_sent_once_and_seen_by_sinks(brain: EchoBrain) -> None:
    assert recorded(brain, 7.0, 7.2, 20.0) == [(0.0, 2), (7.0, 2), (7.5, 2)]
    assert [entry for entry in brain.log if entry[0] == "fire"] == [
        ("fire", [2, 2], [0.0, 7.0]),
        ("fire", [2], [7.5]),
    ]


def test_a_device_acts_from_the_window_after_it_was_added_until_it_is_removed(brain: EchoBrain) -> None:
    brain.run_until(10 * NS_PER_MS)
    clock = brain.add_source(FixedFrequencySource(rate=1000.0, delay=0.0), [1], name="clock")
    assert recorded(brain, 12.0) == [(11.0, 1), (12.0, 1)]
    brain.remove(clock)
    brain.run_until(15 * NS_PER_MS)
    assert brain.pending == []
    assert [type(port).__name__ for port in brain.devices] == ["SpikeRecorderPort"]


def test_a_removed_sink_records_nothing(brain: EchoBrain) -> None:
    recorder = brain.add_sink(SpikeRecorder(), [2], name="list")
    brain.run_until(5 * NS_PER_MS)
    brain.remove(recorder)
    brain.run_until(10 * NS_PER_MS)
    assert recorder.spikes().times_ms.tolist() == [0.0]


def test_the_noise_of_one_device_does_not_depend_on_the_others(brain: EchoBrain) -> None:
    crowded = EchoBrain(network())
    crowded.add_source(PoissonSource(rate=900.0), [0], name="other")
    for each in (brain, crowded):
        each.add_source(PoissonSource(rate=300.0), [1], name="mine")
    mine = [pair for pair in recorded(crowded, 50.0, 100.0) if pair[1] == 1]
    assert mine == [pair for pair in recorded(brain, 100.0) if pair[1] == 1]
    assert len(mine) > 10


def test_currents_add_up_and_are_handed_over_only_when_they_change(brain: EchoBrain) -> None:
    one = brain.add_source(DCSource(amplitude=0.5), [0, 1], name="one")
    two = brain.add_source(DCSource(amplitude=1.0), [1, 1], name="two")
    brain.run_until(1 * NS_PER_MS)
    brain.run_until(2 * NS_PER_MS)
    two.active = False
    brain.run_until(3 * NS_PER_MS)
    brain.remove(one)
    brain.remove(two)
    brain.run_until(4 * NS_PER_MS)
    brain.run_until(5 * NS_PER_MS)
    expected = [[0.5, 2.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 0.0]]
    assert [entry[1] for entry in brain.log if entry[0] == "current"] == expected


def test_a_reset_brain_runs_as_it_did_at_first_and_with_another_seed_otherwise(brain: EchoBrain) -> None:
    source = brain.add_source(PoissonSource(rate=500.0), [0], name="noise")
    first = recorded(brain, 40.0)
    source.rate = 5.0
    brain.reset()
    assert source.rate == 500.0
    assert recorded(brain, 40.0) == first
    brain.reset(seed=4)
    assert recorded(brain, 40.0) != first


def test_a_reset_activates_devices(brain: EchoBrain) -> None:
    source = brain.add_source(PoissonSource(rate=500.0), [0], name="noise")
    integrator = brain.add_sink(LeakyIntegratorAlpha(), [0], name="integrator")
    first = recorded(brain, 40.0)
    assert first
    source.active = integrator.active = False
    brain.reset()
    assert source.active
    assert integrator.active
    assert recorded(brain, 40.0) == first


def test_a_snapshot_holds_devices_and_spikes_in_transit(brain: EchoBrain) -> None:
    source = brain.add_source(PoissonSource(rate=500.0, delay=15.0), [0, 1], name="noise")
    integrator = brain.add_sink(LeakyIntegratorAlpha(), [0, 1], name="integrator")
    brain.run_until(20 * NS_PER_MS)
    snapshot = brain.snapshot()
    brain.run_until(60 * NS_PER_MS)
    voltage = integrator.voltage
    source.rate = 2.0
    brain.restore(snapshot)
    assert brain.now_ns == 20 * NS_PER_MS
    brain.run_until(60 * NS_PER_MS)
    assert integrator.voltage == voltage != 0.0


def test_a_snapshot_with_other_devices_is_refused(brain: EchoBrain, golden: Golden) -> None:
    brain.add_source(PoissonSource(), [0], name="noise")
    snapshot = brain.snapshot()
    brain.add_sink(SpikeRecorder(), [0], name="all")
    with golden.raises(SnapshotError, match=r"\['PoissonPort noise'"):
        brain.restore(snapshot)


def test_neurons_that_do_not_exist_are_refused(brain: EchoBrain, golden: Golden) -> None:
    for ids in ([3], [-1], [0, 7]):
        with golden.raises(NeuronSelectionError, match=r"0\.\.2"):
            brain.add_source(PoissonSource(), ids, name="noise")
        with golden.raises(NeuronSelectionError, match=r"0\.\.2"):
            brain.add_sink(SpikeRecorder(), ids, name="all")
        with golden.raises(NeuronSelectionError, match=r"0\.\.2"):
            brain.read_state("v", ids)


@pytest.mark.parametrize("ids", [np.array([True, False, True]), [0.5], [1.0], "cells", ["0"]])
def test_neurons_are_given_by_whole_numbers(brain: EchoBrain, ids: Any) -> None:
    says = r"neurons are given by their global ids, whole numbers, not by .*network.neurons\(NAME\)"
    for call in (
        lambda: brain.add_source(PoissonSource(), ids, name="noise"),
        lambda: brain.read_state("v", ids),
        lambda: brain.set_parameters(ids, {"tau_m": 3.0}),
    ):
        with pytest.raises(NeuronSelectionError, match=says):
            call()
    assert brain.read_state("v", []).size == 0
    assert brain.read_state("v", np.uint8(1)).shape == (1,)


def test_a_state_variable_is_given_by_its_name(brain: EchoBrain) -> None:
    with pytest.raises(CapabilityError, match=r"\[0\]"):
        brain.read_state(np.array([0]), "v")  # type: ignore[arg-type]


def test_devices_are_described_as_such(brain: EchoBrain, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match="'noise'.*SourceSpec"):
        brain.add_source(3, [0], name="noise")  # type: ignore[arg-type]
    with golden.raises(NeuronSelectionError, match="'all'.*PoissonSource.*SinkSpec"):
        brain.add_sink(PoissonSource(), [0], name="all")  # type: ignore[arg-type]


def test_a_source_cannot_drive_cells_that_only_emit(brain: EchoBrain, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match="'noise'.*'list'"):
        brain.add_source(PoissonSource(), [0, 2], name="noise")


def test_only_declared_state_is_read(brain: EchoBrain, golden: Golden) -> None:
    assert brain.read_state("v", [1, 0]).tolist() == [-64.0, -65.0]
    with golden.raises(CapabilityError, match="EchoBrain.*'w'"):
        brain.read_state("w", [0])


def test_only_declared_cells_and_synapses_are_opened(golden: Golden) -> None:
    strange = Network({"a": Population("a", 1, "Strange", {})})
    with golden.raises(CapabilityError, match="'a'"):
        EchoBrain(strange)
    index, number = np.zeros(1, np.int32), np.ones(1)
    plastic = Projection("p", "echo", "echo", "excitatory", index, index, number, number, "stdp")
    with golden.raises(CapabilityError, match="'p'"):
        EchoBrain(Network(network().populations, (plastic,)))


def test_without_snapshots_saving_is_refused(golden: Golden) -> None:
    brain = EchoBrain(network(), BrainCapabilities(frozenset({"Echo"}), frozenset()))
    with golden.raises(CapabilityError):
        brain.snapshot()


def test_a_spike_time_that_is_not_a_number_is_an_error(brain: EchoBrain, golden: Golden) -> None:
    brain.fired = [(np.nan, 0)]
    with golden.raises(DivergedError) as error:
        brain.run_until(5 * NS_PER_MS)
    assert error.value.t_ns == 5 * NS_PER_MS
