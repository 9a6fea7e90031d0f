"""Contract: connected cells act on each other and others do not; each has its own parameters and state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from nrp_conformance.brain.kit import BrainKit, connect, record, spikes, times, train
from nrp_core.brain import DCSource, FixedFrequencySource, LeakyIntegratorExp, SpikeRecorderPort
from nrp_core.errors import NeuronSelectionError
from nrp_core.network.data import Population

N_MANY = 300
"""More cells than one byte can count, and more than one core of some hardware holds."""


class CellTests(BrainKit):
    """The first cell or synapse does not determine the values of all others."""

    def test_each_synapse_has_its_own_weight(self) -> None:
        """The order of the synapses differs from the order of the sources and of the targets."""
        strong, weak = self.sample.strong, self.sample.weak
        fan = connect("s", "n", [weak, strong, weak, 0.0], 2.0, pairs=[(2, 1), (0, 2), (1, 0), (0, 3)])
        brain = self.open(spikes("s", [5.0], [5.0], [5.0]), self.cells("n", 4), fan)
        recorded = record(brain, range(3, 7))
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(recorded)} == {5}, "only the third cell has a strong synapse"

    def test_each_cell_has_its_own_parameters(self) -> None:
        """Each cell of a population behaves as it does in a population of its own."""
        self.require_repeatable()
        sample, n = self.sample, 3
        values = {
            name: [value * (1 + 0.04 * i) for i in range(n)]
            for name, value in sample.all_parameters.items()
            if isinstance(value, float)
        }
        values["i_offset"] = [1.5 * sample.current_na] * n
        recorded = self._under_inputs(self.cells("n", n, **values))
        for i in range(n):
            own: Any = {name: each[i] for name, each in values.items()}
            expected = times(self._under_inputs(self.cells("n", **own)), 1)
            assert expected, "no cell fired"
            assert times(recorded, 1 + i) == expected, f"cell {i} of a population with {values}"

    def test_cells_that_fire_at_once_are_reset_each_to_its_own_potential(self) -> None:
        """Two cells that fire at the same spike then behave as each does alone."""
        self.require_repeatable()
        sample = self.sample
        values: dict[str, Any] = {"i_offset": [1.5 * sample.current_na] * 2}
        reset, threshold = (sample.all_parameters.get(name) for name in ("v_reset", "v_thresh"))
        if reset is not None and threshold is not None:
            values["v_reset"] = [reset, reset - 0.5 * abs(threshold - reset)]
        both = self._after_a_kick(self.cells("n", 2, **values))
        for i in range(2):
            own: Any = {name: each[i] for name, each in values.items()}
            expected = times(self._after_a_kick(self.cells("n", **own)), 1)
            assert len(expected) > 1, "no cell fired twice"
            assert times(both, 1 + i) == expected, f"cell {i} of a population with {values}"

    def _after_a_kick(self, population: Population) -> SpikeRecorderPort:
        """Run cells, make them fire by one strong spike, and return their spikes."""
        pairs = [(0, i) for i in range(population.size)]
        kick = connect("s", "n", self.sample.strong, 2.0, pairs=pairs)
        brain = self.open(spikes("s", [5.0]), population, kick)
        recorded = record(brain)
        self.run(brain, 80)
        return recorded

    def _under_inputs(self, population: Population) -> SpikeRecorderPort:
        """Run cells with synapses of both kinds, and return the results."""
        inputs = [(0, i) for i in range(population.size)]
        sample = self.sample
        brain = self.open(
            spikes("s", [4.0, 23.0, 41.0]), population,
            connect("s", "n", 3 * sample.weak, 2.0, pairs=inputs),
            connect(
                "s", "n", 3 * sample.weak * sample.inhibitory_sign, 9.0,
                pairs=inputs, receptor="inhibitory",
            ),
        )  # fmt: skip
        recorded = record(brain)
        self.run(brain, 80)
        return recorded

    def test_a_cell_starts_from_its_initial_potential_also_after_a_reset(self) -> None:
        higher = [0.0, 4.0, 2.0]
        driven = self.cells("n", 3, i_offset=self.sample.current_na)
        start_mv = driven.initial_values["v"] + higher
        brain = self.open(replace(driven, initial_values={**driven.initial_values, "v": start_mv}))
        recorded = record(brain)
        for _ in range(2):
            if "v" in self.capabilities.state_variables:
                assert brain.read_state("v", [0, 1, 2]) == pytest.approx(start_mv, abs=0.01)
            self.run(brain, 60)
            first = [min(times(recorded, neuron)) for neuron in range(3)]
            assert first[1] <= first[2] <= first[0], f"of cells that start {higher} mV above the rest"
            assert first[1] < first[0], f"of cells that start {higher} mV above the rest"
            brain.reset()

    def test_a_cell_can_act_on_itself(self) -> None:
        strong = self.sample.strong
        kick, loop = connect("s", "n", strong, 1.0), connect("n", "n", strong, 20.0)
        brain = self.open(spikes("s", [5.0]), self.cells("n"), kick, loop)
        recorded = record(brain, [1])
        self.run(brain, 45)
        assert len(times(recorded, 1)) == 2

    def test_projections_between_the_same_populations_add_to_each_other(self) -> None:
        strong = self.sample.strong
        both = [
            replace(connect("s", "n", strong, 2.0, pairs=[(0, cell)]), label=f"to cell {cell}")
            for cell in (0, 1)
        ]
        brain = self.open(spikes("s", [5.0]), self.cells("n", 2), *both)
        recorded = record(brain, [1, 2])
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(recorded)} == {1, 2}

    def test_simultaneous_spikes_of_source_cells_all_act(self) -> None:
        pairs = [(0, 0), (1, 1), (2, 2)]
        hit = connect("s", "n", self.sample.strong, 2.0, pairs=pairs)
        brain = self.open(spikes("s", *[[5.0]] * 3), self.cells("n", 3), hit)
        recorded = record(brain, range(3, 6))
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(recorded)} == {3, 4, 5}

    def test_many_cells_are_independent(self) -> None:
        one, other = 257, N_MANY - 2
        trains = [[5.0] if source == one else [] for source in range(N_MANY)]
        pairs = [(i, (i + other - one) % N_MANY) for i in range(N_MANY)]
        hit = connect("s", "n", self.sample.strong, 1.0, pairs=pairs)
        brain = self.open(spikes("s", *trains), self.cells("n", N_MANY), hit)
        recorded = record(brain)
        self.run(brain, 30)
        assert {neuron for neuron, _ in train(recorded)} == {one, N_MANY + other}


class WiringTests(BrainKit):
    """Connections between cells."""

    def test_spikes_reach_the_connected_cell_and_no_other(self) -> None:
        hit = connect("s", "n", self.sample.strong, 1.0, pairs=[(1, 2)])
        brain = self.open(self.cells("quiet", 2), spikes("s", [], [5.0]), self.cells("n", 4), hit)
        recorded = record(brain, [0, 1, 4, 5, 6, 7])
        self.run(brain, 30)
        assert [neuron for neuron, _ in train(recorded)] == [6]

    def test_a_driven_population_does_not_leak_into_another(self) -> None:
        driven = self.cells("driven", 3, i_offset=self.sample.current_na)
        brain = self.open(driven, self.cells("alone", 3))
        recorded = record(brain)
        self.run(brain, 60)
        assert {neuron for neuron, _ in train(recorded)} == {0, 1, 2}

    def test_two_brains_in_one_process_do_not_disturb_each_other(self) -> None:
        self.require_repeatable()
        alone = self.open(*self.busy())
        expected = record(alone)
        self.run(alone, 60)
        one, two = self.open(*self.busy()), self.open(*self.busy(), seed=2)
        recorded, other = record(one), record(two)
        two.add_source(DCSource(amplitude=2 * self.sample.current_na), [0, 3], name="dc")
        for until in range(4, 61, 4):
            self.run(one, until)
            self.run(two, until)
        assert train(recorded) == train(expected)
        assert train(other) != train(expected)

    def test_inhibition_keeps_a_cell_from_firing(self) -> None:
        sample = self.sample
        volley = spikes("s", [float(t) for t in range(5, 58, 2)])
        free = self.cells("free", i_offset=sample.current_na)
        held = self.cells("held", i_offset=sample.current_na)
        brain = self.open(volley, free, held, self.inhibition("s", "held", sample.strong))
        recorded = record(brain)
        self.run(brain, 60)
        assert len(times(recorded, 2)) < len(times(recorded, 1))

    def test_two_synapses_onto_one_cell_add_up(self) -> None:
        sample = self.sample
        twice = connect("s", "twice", sample.strong / 2, 2.0, pairs=[(0, 0), (0, 0)])
        once = connect("s", "once", sample.strong, 2.0)
        brain = self.open(spikes("s", [4.0]), self.cells("once"), self.cells("twice"), once, twice)
        recorded = record(brain)
        self.run(brain, 30)
        assert times(recorded, 1), "no cell fired"
        assert times(recorded, 2) == pytest.approx(times(recorded, 1), abs=self.tolerance_ms)

    def test_a_source_acts_only_on_the_selected_neurons(self) -> None:
        brain = self.open(self.cells("a", 3), self.cells("b", 3))
        recorded = record(brain)
        brain.add_source(DCSource(amplitude=[9 * self.sample.current_na] * 2), [4, 1], name="dc")
        spec = FixedFrequencySource(rate=100.0, weight=self.sample.strong, delay=1.0)
        brain.add_source(spec, [2], name="source")
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(recorded)} == {1, 2, 4}

    def test_the_values_of_a_source_go_to_its_neurons_in_their_order(self) -> None:
        brain = self.open(self.cells("a", 4))
        recorded = record(brain)
        brain.add_source(DCSource(amplitude=[0.0, 3 * self.sample.current_na]), [3, 1], name="dc")
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(recorded)} == {1}

    def test_currents_of_several_sources_add_up(self) -> None:
        half = DCSource(amplitude=self.sample.current_na / 2)
        brain = self.open(self.cells("both"), self.cells("whole", i_offset=self.sample.current_na))
        recorded = record(brain)
        for name in ("one", "two"):
            brain.add_source(half, [0], name=name)
        self.run(brain, 60)
        assert times(recorded, 1), "no cell fired"
        assert times(recorded, 0) == pytest.approx(times(recorded, 1), abs=self.tolerance_ms)

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
        recorded = record(brain)
        self.run(brain, 30)
        assert [neuron for neuron, _ in train(recorded)] == [2, 5]
        assert times(recorded, 2) == [4.0]

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
