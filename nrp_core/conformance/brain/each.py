"""Contract: every cell and every synapse has its own parameters and state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from nrp_core.brain.devices.sinks import SpikeRecorderPort
from nrp_core.brain.network.data import Population
from nrp_core.conformance.brain.kit import BrainKit, record, times, train
from nrp_core.conformance.brain.parts import connect, spikes

N_MANY = 300
"""More cells than one byte can count, and more than one core of some hardware holds."""


class EachTests(BrainKit):
    """The first cell or synapse does not determine the values of all others."""

    def test_each_synapse_has_its_own_weight(self) -> None:
        """The order of the synapses differs from the order of the sources and of the targets."""
        strong, weak = self.sample.strong, self.sample.weak
        fan = connect("s", "n", [weak, strong, weak, 0.0], 2.0, pairs=[(2, 1), (0, 2), (1, 0), (0, 3)])
        brain = self.open(spikes("s", [5.0], [5.0], [5.0]), self.cells("n", 4), fan)
        heard = record(brain, range(3, 7))
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(heard)} == {5}, "only the third cell has a strong synapse"

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
        heard = self._under_inputs(self.cells("n", n, **values))
        for i in range(n):
            own: Any = {name: each[i] for name, each in values.items()}
            expected = times(self._under_inputs(self.cells("n", **own)), 1)
            assert expected, "no cell fired"
            assert times(heard, 1 + i) == expected, f"cell {i} of a population with {values}"

    def test_cells_that_fire_at_once_are_reset_each_to_its_own_potential(self) -> None:
        """Two cells that one spike makes fire go on as each of them does alone."""
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
        """Run cells that one strong spike makes fire, and return their spikes."""
        pairs = [(0, i) for i in range(population.size)]
        kick = connect("s", "n", self.sample.strong, 2.0, pairs=pairs)
        brain = self.open(spikes("s", [5.0]), population, kick)
        heard = record(brain)
        self.run(brain, 80)
        return heard

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
        heard = record(brain)
        self.run(brain, 80)
        return heard

    def test_a_cell_starts_from_its_initial_potential_also_after_a_reset(self) -> None:
        higher = [0.0, 4.0, 2.0]
        driven = self.cells("n", 3, i_offset=self.sample.current_na)
        start_mv = driven.initial_values["v"] + higher
        brain = self.open(replace(driven, initial_values={**driven.initial_values, "v": start_mv}))
        heard = record(brain)
        for _ in range(2):
            if "v" in self.capabilities.state_variables:
                assert brain.read_state("v", [0, 1, 2]) == pytest.approx(start_mv, abs=0.01)
            self.run(brain, 60)
            first = [min(times(heard, neuron)) for neuron in range(3)]
            assert first[1] <= first[2] <= first[0], f"of cells that start {higher} mV above the rest"
            assert first[1] < first[0], f"of cells that start {higher} mV above the rest"
            brain.reset()

    def test_a_cell_can_act_on_itself(self) -> None:
        strong = self.sample.strong
        kick, loop = connect("s", "n", strong, 1.0), connect("n", "n", strong, 20.0)
        brain = self.open(spikes("s", [5.0]), self.cells("n"), kick, loop)
        heard = record(brain, [1])
        self.run(brain, 45)
        assert len(times(heard, 1)) == 2

    def test_projections_between_the_same_populations_add_to_each_other(self) -> None:
        strong = self.sample.strong
        both = [
            replace(connect("s", "n", strong, 2.0, pairs=[(0, cell)]), label=f"to cell {cell}")
            for cell in (0, 1)
        ]
        brain = self.open(spikes("s", [5.0]), self.cells("n", 2), *both)
        heard = record(brain, [1, 2])
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(heard)} == {1, 2}

    def test_simultaneous_spikes_of_source_cells_all_act(self) -> None:
        pairs = [(0, 0), (1, 1), (2, 2)]
        hit = connect("s", "n", self.sample.strong, 2.0, pairs=pairs)
        brain = self.open(spikes("s", *[[5.0]] * 3), self.cells("n", 3), hit)
        heard = record(brain, range(3, 6))
        self.run(brain, 40)
        assert {neuron for neuron, _ in train(heard)} == {3, 4, 5}

    def test_many_cells_are_independent(self) -> None:
        one, other = 257, N_MANY - 2
        trains = [[5.0] if source == one else [] for source in range(N_MANY)]
        pairs = [(i, (i + other - one) % N_MANY) for i in range(N_MANY)]
        hit = connect("s", "n", self.sample.strong, 1.0, pairs=pairs)
        brain = self.open(spikes("s", *trains), self.cells("n", N_MANY), hit)
        heard = record(brain)
        self.run(brain, 30)
        assert {neuron for neuron, _ in train(heard)} == {one, N_MANY + other}
