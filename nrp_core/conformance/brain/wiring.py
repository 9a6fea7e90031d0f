"""Contract: connected cells act on each other, others do not; selections select the right neurons."""

from __future__ import annotations

import pytest

from nrp_core.brain.devices.sinks import LeakyIntegratorExp
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource
from nrp_core.conformance.brain.kit import BrainKit, record, times, train
from nrp_core.conformance.brain.parts import connect, spikes
from nrp_core.errors import NeuronSelectionError


class WiringTests(BrainKit):
    """Connections between cells."""

    def test_spikes_reach_the_connected_cell_and_no_other(self) -> None:
        hit = connect("s", "n", self.sample.strong, 1.0, pairs=[(1, 2)])
        brain = self.open(self.cells("quiet", 2), spikes("s", [], [5.0]), self.cells("n", 4), hit)
        heard = record(brain, [0, 1, 4, 5, 6, 7])
        self.run(brain, 30)
        assert [neuron for neuron, _ in train(heard)] == [6]

    def test_a_driven_population_does_not_leak_into_another(self) -> None:
        driven = self.cells("driven", 3, i_offset=self.sample.current_na)
        brain = self.open(driven, self.cells("alone", 3))
        heard = record(brain)
        self.run(brain, 60)
        assert {neuron for neuron, _ in train(heard)} == {0, 1, 2}

    def test_two_brains_in_one_process_do_not_disturb_each_other(self) -> None:
        self.require_repeatable()
        alone = self.open(*self.busy())
        expected = record(alone)
        self.run(alone, 60)
        one, two = self.open(*self.busy()), self.open(*self.busy(), seed=2)
        heard, other = record(one), record(two)
        two.add_source(DCSource(amplitude=2 * self.sample.current_na), [0, 3], name="dc")
        for until in range(4, 61, 4):
            self.run(one, until)
            self.run(two, until)
        assert train(heard) == train(expected)
        assert train(other) != train(expected)

    def test_inhibition_keeps_a_cell_from_firing(self) -> None:
        sample = self.sample
        volley = spikes("s", [float(t) for t in range(5, 58, 2)])
        free = self.cells("free", i_offset=sample.current_na)
        held = self.cells("held", i_offset=sample.current_na)
        brain = self.open(volley, free, held, self.inhibition("s", "held", sample.strong))
        heard = record(brain)
        self.run(brain, 60)
        assert len(times(heard, 2)) < len(times(heard, 1))

    def test_two_synapses_onto_one_cell_add_up(self) -> None:
        sample = self.sample
        twice = connect("s", "twice", sample.strong / 2, 2.0, pairs=[(0, 0), (0, 0)])
        once = connect("s", "once", sample.strong, 2.0)
        brain = self.open(spikes("s", [4.0]), self.cells("once"), self.cells("twice"), once, twice)
        heard = record(brain)
        self.run(brain, 30)
        assert times(heard, 1), "no cell fired"
        assert times(heard, 2) == pytest.approx(times(heard, 1), abs=self.tolerance_ms)

    def test_a_source_acts_only_on_the_selected_neurons(self) -> None:
        brain = self.open(self.cells("a", 3), self.cells("b", 3))
        heard = record(brain)
        brain.add_source(DCSource(amplitude=[9 * self.sample.current_na] * 2), [4, 1], name="dc")
        spec = FixedFrequencySource(rate=100.0, weight=self.sample.strong, delay=1.0)
        brain.add_source(spec, [2], name="source")
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(heard)} == {1, 2, 4}

    def test_the_values_of_a_source_go_to_its_neurons_in_their_order(self) -> None:
        brain = self.open(self.cells("a", 4))
        heard = record(brain)
        brain.add_source(DCSource(amplitude=[0.0, 3 * self.sample.current_na]), [3, 1], name="dc")
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(heard)} == {1}

    def test_currents_of_several_sources_add_up(self) -> None:
        half = DCSource(amplitude=self.sample.current_na / 2)
        brain = self.open(self.cells("both"), self.cells("whole", i_offset=self.sample.current_na))
        heard = record(brain)
        for name in ("one", "two"):
            brain.add_source(half, [0], name=name)
        self.run(brain, 60)
        assert times(heard, 1), "no cell fired"
        assert times(heard, 0) == pytest.approx(times(heard, 1), abs=self.tolerance_ms)

    def test_a_sink_reads_only_the_selected_neurons(self) -> None:
        brain = self.open(*self.busy())
        everything, some = record(brain), record(brain, [6, 0, 9], "some")
        self.run(brain, 50)
        assert train(some) == [event for event in train(everything) if event[0] in (0, 6, 9)]
        assert train(some)

    def test_every_kind_of_cell_can_be_recorded_under_its_own_id(self) -> None:
        """Global ids number all populations in the order of their definition, including sources."""
        strong = self.sample.strong
        brain = self.open(
            self.cells("a", 2), spikes("s", [4.0], []), self.cells("b", 2),
            connect("s", "b", strong, 1.0, pairs=[(0, 1)]),
        )  # fmt: skip
        heard = record(brain)
        self.run(brain, 30)
        assert [neuron for neuron, _ in train(heard)] == [2, 5]
        assert times(heard, 2) == [4.0]

    def test_a_leaky_integrator_listens_to_all_of_its_neurons(self) -> None:
        brain = self.open(spikes("s", [5.0], [5.0]), self.cells("n"))
        both = brain.add_sink(LeakyIntegratorExp(), [0, 1], name="both")
        one = brain.add_sink(LeakyIntegratorExp(), [1], name="one")
        self.run(brain, 10)
        assert one.voltage > 0.0  # type: ignore[attr-defined]
        assert both.voltage == pytest.approx(2 * one.voltage)  # type: ignore[attr-defined]

    @pytest.mark.parametrize("neurons", [[4], [-1], [0, 99]])
    def test_neurons_that_do_not_exist_are_refused(self, neurons: list[int]) -> None:
        brain = self.open(self.cells("n", 4))
        with pytest.raises(NeuronSelectionError):
            brain.add_source(DCSource(amplitude=1.0), neurons, name="dc")
        with pytest.raises(NeuronSelectionError):
            record(brain, neurons)
