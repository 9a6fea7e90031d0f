"""Brains with one bug each in what each cell and each synapse has of its own."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from typing import Any

import numpy as np
from nrp_brain_minimal.brain import MinimalBackend, MinimalBrain
from registry import Found, register
from small_brain import STEP_MS, SmallBackend, SmallBrain

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainOptions
from nrp_core.brain.devices.short_term import CONSTANTS, released_share
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.network.data import Network, Projection

FOUND_BY: Found = {}
found_by = register(FOUND_BY, SmallBackend, "brain")


class _Opens(MinimalBackend):
    brain: type[MinimalBrain] = MinimalBrain

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return self.brain(network, seed=seed, capabilities=self.capabilities(options))


found_by_with_short_term = register(FOUND_BY, _Opens, "brain")


class _Wires(SmallBrain):
    """Takes other synapses than it was given."""

    def outgoing(self) -> Any:
        given = self.network
        self.network = dataclasses.replace(given, projections=tuple(self.changed(given.projections)))
        try:
            return super().outgoing()
        finally:
            self.network = given

    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        raise NotImplementedError


@found_by("a_synapse_starts_from_its_initial_value_or_that_is_refused")
class StartsWithoutSynapticCurrent(SmallBrain):
    def fresh(self) -> Any:
        self.exc0[:], self.inh0[:] = 0.0, 0.0
        return super().fresh()


@found_by("equal_time_constants_follow_the_equations_or_are_refused")
class DividesByTheDifferenceOfTimeConstants(SmallBrain):
    def left_behind(self, tau: FloatArray, leak: FloatArray, fade: FloatArray) -> FloatArray:
        rate = 1 / tau - 1 / self.p["tau_m"] + ~self.alive
        return np.divide(leak - fade, rate, out=np.zeros_like(rate), where=rate != 0)


@found_by(
    "a_spike_arrives_after_its_delay_and_not_before",
    "each_synapse_has_its_own_delay",
    "nothing_acts_before_its_delay",
)
class RoundsDelaysToMilliseconds(_Wires):
    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        return [dataclasses.replace(p, delay_ms=np.maximum(1.0, p.delay_ms.round())) for p in projections]


@found_by(
    "a_spike_arrives_after_its_delay_and_not_before",
)
class KeepsThirtyTwoMillisecondsOfDelay(_Wires):
    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        return [dataclasses.replace(p, delay_ms=p.delay_ms % 32.0) for p in projections]


@found_by(
    "each_synapse_has_its_own_weight",
    "input_during_a_refractory_period_acts_after_it",
)
class TakesTheFirstWeightOfAProjectionForAll(_Wires):
    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        return [dataclasses.replace(p, weight=np.full(p.size, p.weight[0])) for p in projections]


@found_by(
    "a_delay_of_0_is_a_step_of_the_grid_or_is_refused",
    "a_cell_can_act_on_itself",
    "projections_between_the_same_cells_keep_their_delays_and_receptors",
    "projections_between_the_same_populations_add_to_each_other",
    "two_synapses_onto_one_cell_add_up",
)
class TurnsTheSecondProjectionRound(_Wires):
    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        return [dataclasses.replace(p, weight=-p.weight) if i == 1 else p for i, p in enumerate(projections)]


@found_by(
    "projections_between_the_same_populations_add_to_each_other",
)
class KeepsTheLastProjectionOfAPair(_Wires):
    def changed(self, projections: tuple[Projection, ...]) -> list[Projection]:
        return list({(p.pre, p.post): p for p in projections}.values())


@found_by(
    "a_cell_can_act_on_itself",
)
class LeavesOutSynapsesOntoOneself(SmallBrain):
    def outgoing(self) -> Any:
        found = super().outgoing()
        others = {pre: [sent for sent in all_sent if sent[0] != pre] for pre, all_sent in found.items()}
        return defaultdict(list, others)


@found_by(
    "many_cells_are_independent",
)
class CountsTargetsInAByte(SmallBrain):
    def post(self, target: int, weight: float, time_ms: float, receptor: str) -> None:
        super().post(target % 256, weight, time_ms, receptor)


@found_by(
    "projections_between_the_same_cells_keep_their_delays_and_receptors",
    "simultaneous_spikes_of_source_cells_all_act",
)
class HearsOneSourceAtATime(SmallBrain):
    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        _, first = np.unique(times_ms, return_index=True)
        super()._do_fire(neurons[first], times_ms[first])


@found_by(
    "cells_that_fire_at_once_are_reset_each_to_its_own_potential",
    "each_cell_has_its_own_parameters",
)
class TakesTheFirstCellOfAPopulationForAll(SmallBrain):
    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities)
        for label, population in network.populations.items():
            if not population.is_source:
                for name in self.p.keys() - {"i_offset"}:
                    self.p[name][network.ids_of(label)] = population.parameters[name][0]


@found_by(
    "a_cell_starts_from_its_initial_potential_also_after_a_reset",
)
class StartsAtRest(SmallBrain):
    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities)
        self.v0 = self.p["v_rest"].copy()
        self.live = self.fresh()


@found_by(
    "a_cell_under_a_current_fires_at_the_times_of_its_equations",
    "a_cell_does_not_fire_in_its_refractory_period",
    "nothing_acts_before_its_delay",
)
class ResetsToTheRest(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.live.v[neuron] = self.p["v_rest"][neuron]


@found_by(
    "a_cell_does_not_fire_in_its_refractory_period",
)
class IsRefractoryForAStepTooFew(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.live.free_at[neuron] -= 1


@found_by(
    "input_during_a_refractory_period_acts_after_it",
)
class HearsNothingWhileRefractory(SmallBrain):
    def receive(self, target: int, weight: float, receptor: str) -> None:
        if self.live.tick >= self.live.free_at[target]:
            super().receive(target, weight, receptor)


@found_by_with_short_term(
    "a_snapshot_keeps_the_depression_of_synapses",
)
class ForgetsDepressionInASnapshot(MinimalBrain):
    def _do_restore(self, saved: Any) -> None:
        super()._do_restore(saved)
        self._now.synapses = self._at_rest.copy()


@found_by_with_short_term(
    "a_reset_restores_depressed_synapses",
)
class KeepsDepressionOverAReset(MinimalBrain):
    def _do_reset(self, seed: int) -> None:
        kept = self._now.synapses
        super()._do_reset(seed)
        self._now.synapses = kept


@found_by_with_short_term(
    "each_synapse_depresses_by_its_own_constants",
)
class TakesTheConstantsOfTheFirstSynapseForAll(MinimalBrain):
    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities)
        for name in CONSTANTS:
            self._at_rest[name] = self._at_rest[name][:1]
        self._now = self._fresh()


@found_by_with_short_term(
    "each_synapse_depresses_by_its_own_constants",
)
class SharesOneResourceAmongSynapses(MinimalBrain):
    def _send(self, neuron: int, time_ms: float) -> None:
        own = self._now.synapses[self._first[neuron] : self._first[neuron + 1]]
        share = released_share(own[0], time_ms) if own["plastic"].any() else 1.0
        self._post(own["target"], own["receptor"], own["weight"] * share, time_ms + own["delay_ms"])


@found_by_with_short_term(
    "a_cell_can_act_on_itself",
    "a_delay_of_0_is_a_step_of_the_grid_or_is_refused",
    "a_device_acts_within_its_delay_and_a_step",
    "a_fixed_frequency_source_sends_equidistant_spikes",
    "a_reset_restores_depressed_synapses",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
    "a_source_acts_only_on_the_selected_neurons",
    "a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once",
    "a_spike_arrives_after_its_delay_and_not_before",
    "a_synaptic_potential_follows_its_equations",
    "a_tsodyks_markram_synapse_follows_its_equations",
    "an_injected_spike_acts_after_its_delay",
    "each_synapse_depresses_by_its_own_constants",
    "each_synapse_has_its_own_delay",
    "each_synapse_has_its_own_weight",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "every_kind_of_cell_can_be_recorded_under_its_own_id",
    "input_during_a_refractory_period_acts_after_it",
    "many_cells_are_independent",
    "projections_between_the_same_populations_add_to_each_other",
    "simultaneous_spikes_of_a_device_add_up",
    "simultaneous_spikes_of_source_cells_all_act",
    "spikes_reach_the_connected_cell_and_no_other",
    "synaptic_input_outlasts_the_spikes_that_it_causes",
    "the_noise_of_a_device_does_not_depend_on_other_devices",
    "two_synapses_onto_one_cell_add_up",
)
class ScalesJumpsByTheStep(MinimalBrain):
    def _post(self, target: IntArray, receptor: IntArray, weight: FloatArray, at_ms: FloatArray) -> None:
        super()._post(target, receptor, weight * STEP_MS, at_ms)
