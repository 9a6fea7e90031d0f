"""Brains with one bug each in what acts on whom and how: wiring, devices, equations, declarations."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from nrp_brain_event import EventBackend
from nrp_brain_event.brain import EventBrain
from registry import Found, register
from small_brain import CELL, SmallBackend, SmallBrain

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.network.changes import PARAMETERS, WEIGHTS, ParameterChange
from nrp_core.network.data import Network, Projection
from nrp_core.network.synapses import CONTINUOUS, ELECTRICAL, GRADED, STATIC, STDP

FOUND_BY: Found = {}
found_by = register(FOUND_BY, SmallBackend, "brain")


@found_by(
    "a_cell_can_act_on_itself",
    "a_delay_of_0_is_a_step_of_the_grid_or_is_refused",
    "a_device_acts_within_its_delay_and_a_step",
    "a_fixed_frequency_source_sends_equidistant_spikes",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
    "a_source_acts_only_on_the_selected_neurons",
    "a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once",
    "a_spike_arrives_after_its_delay_and_not_before",
    "a_synaptic_potential_follows_its_equations",
    "an_injected_spike_acts_after_its_delay",
    "each_synapse_has_its_own_delay",
    "each_synapse_has_its_own_weight",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "every_kind_of_cell_can_be_recorded_under_its_own_id",
    "inhibition_keeps_a_cell_from_firing",
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
class SwapsReceptors(SmallBrain):
    def receive(self, target: int, weight: float, receptor: str) -> None:
        super().receive(target, -weight, receptor)


@found_by(
    "a_synaptic_potential_follows_its_equations",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "inhibition_keeps_a_cell_from_firing",
)
class IgnoresInhibition(SmallBrain):
    def receive(self, target: int, weight: float, receptor: str) -> None:
        if receptor == "excitatory":
            super().receive(target, weight, receptor)


@found_by(
    "cells_that_fire_at_once_are_reset_each_to_its_own_potential",
    "a_device_acts_within_its_delay_and_a_step",
    "a_source_acts_only_on_the_selected_neurons",
    "an_injected_spike_acts_after_its_delay",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "each_cell_has_its_own_parameters",
    "each_synapse_has_its_own_delay",
    "each_synapse_has_its_own_weight",
    "every_kind_of_cell_can_be_recorded_under_its_own_id",
    "many_cells_are_independent",
    "nothing_acts_before_its_delay",
    "projections_between_the_same_cells_keep_their_delays_and_receptors",
    "spikes_reach_the_connected_cell_and_no_other",
    "the_noise_of_a_device_does_not_depend_on_other_devices",
    "two_synapses_onto_one_cell_add_up",
)
class LeaksIntoTheNextNeuron(SmallBrain):
    def receive(self, target: int, weight: float, receptor: str) -> None:
        super().receive(target, weight, receptor)
        super().receive((target + 1) % self.network.size, weight, receptor)


@found_by(
    "two_synapses_onto_one_cell_add_up",
)
class KeepsOneSynapseAPair(SmallBrain):
    def outgoing(self) -> Any:
        targets = super().outgoing()
        for neuron, sent in targets.items():
            targets[neuron] = list(dict.fromkeys(sent))
        return targets


@found_by(
    "simultaneous_spikes_of_a_device_add_up",
)
class KeepsOneEventAStep(SmallBrain):
    def _do_inject(self, events: SynapticEvents) -> None:
        _, first = np.unique(np.stack([events.neurons, events.times_ms]), axis=1, return_index=True)
        super()._do_inject(
            SynapticEvents(
                events.neurons[first], events.times_ms[first], events.weights[first], events.receptor
            )
        )


@found_by(
    "a_device_acts_within_its_delay_and_a_step",
    "a_fixed_frequency_source_sends_equidistant_spikes",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
    "an_injected_spike_acts_after_its_delay",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "the_noise_of_a_device_does_not_depend_on_other_devices",
)
class SendsDeviceSpikesAtOnce(SmallBrain):
    def _do_inject(self, events: SynapticEvents) -> None:
        super()._do_inject(dataclasses.replace(events, times_ms=np.zeros(len(events))))


@found_by(
    "a_current_adds_to_the_offset_of_its_cell",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_late_device_acts_from_then_on",
    "a_source_acts_only_on_the_selected_neurons",
    "currents_of_several_sources_add_up",
    "removing_one_of_two_currents_leaves_the_other",
    "the_values_of_a_source_go_to_its_neurons_in_their_order",
)
class GivesCurrentsToTheNextNeuron(SmallBrain):
    def _do_set_current(self, currents_na: FloatArray) -> None:
        super()._do_set_current(np.roll(currents_na, 1))


@found_by(
    "a_current_acts_from_the_moment_it_is_set",
    "a_current_adds_to_the_offset_of_its_cell",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
    "a_late_device_acts_from_then_on",
    "a_removed_device_has_no_effect",
    "a_source_acts_only_on_the_selected_neurons",
    "an_inactive_device_is_silent_and_keeps_its_settings",
    "currents_of_several_sources_add_up",
    "removing_one_of_two_currents_leaves_the_other",
    "the_values_of_a_source_go_to_its_neurons_in_their_order",
)
class TakesCurrentsOneWindowLate(SmallBrain):
    waiting: FloatArray | None = None

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self.waiting = currents_na

    def _do_run_until(self, t_ns: int) -> None:
        super()._do_run_until(t_ns)
        if self.waiting is not None:
            super()._do_set_current(self.waiting)
            self.waiting = None


@found_by(
    "a_current_acts_from_the_moment_it_is_set",
    "a_current_adds_to_the_offset_of_its_cell",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
    "a_late_device_acts_from_then_on",
    "a_removed_device_has_no_effect",
    "a_snapshot_keeps_a_current",
    "a_source_acts_only_on_the_selected_neurons",
    "an_inactive_device_is_silent_and_keeps_its_settings",
    "currents_of_several_sources_add_up",
    "removing_one_of_two_currents_leaves_the_other",
    "the_values_of_a_source_go_to_its_neurons_in_their_order",
)
class TakesCurrentsInPicoamperes(SmallBrain):
    def _do_set_current(self, currents_na: FloatArray) -> None:
        super()._do_set_current(currents_na / 1000)


@found_by(
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_removed_device_has_no_effect",
    "removing_one_of_two_currents_leaves_the_other",
)
class NeverEndsACurrent(SmallBrain):
    def _do_set_current(self, currents_na: FloatArray) -> None:
        super()._do_set_current(np.where(currents_na == 0, self.live.current, currents_na))


@found_by(
    "two_brains_in_one_process_do_not_disturb_each_other",
)
class SharesCurrentsBetweenBrains(SmallBrain):
    shared: FloatArray = np.zeros(0)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        type(self).shared = currents_na.copy()

    def _do_run_until(self, t_ns: int) -> None:
        if len(self.shared) == self.network.size:
            self.live.current = self.shared
        super()._do_run_until(t_ns)

    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        type(self).shared = np.zeros(0)

    def _do_close(self) -> None:
        type(self).shared = np.zeros(0)


@found_by(
    "a_delay_of_0_is_a_step_of_the_grid_or_is_refused",
    "cells_that_fire_at_once_are_reset_each_to_its_own_potential",
    "a_cell_can_act_on_itself",
    "a_snapshot_keeps_spikes_in_flight",
    "a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once",
    "a_spike_arrives_after_its_delay_and_not_before",
    "each_cell_has_its_own_parameters",
    "each_synapse_has_its_own_delay",
    "each_synapse_has_its_own_weight",
    "every_kind_of_cell_can_be_recorded_under_its_own_id",
    "inhibition_keeps_a_cell_from_firing",
    "many_cells_are_independent",
    "projections_between_the_same_populations_add_to_each_other",
    "simultaneous_spikes_of_source_cells_all_act",
    "spikes_reach_the_connected_cell_and_no_other",
    "two_synapses_onto_one_cell_add_up",
    "input_during_a_refractory_period_acts_after_it",
    "synaptic_input_outlasts_the_spikes_that_it_causes",
)
class CountsSourcesOut(SmallBrain):
    def _do_take_spikes(self) -> Spikes:
        taken = super()._do_take_spikes()
        return Spikes(np.cumsum(self.alive)[taken.neurons] - 1, taken.times_ms)


@found_by(
    "global_random_generators_are_neither_read_nor_seeded",
)
class DrawsFromTheGlobalGenerator(SmallBrain):
    def _do_run_until(self, t_ns: int) -> None:
        np.random.random()  # noqa: NPY002  that is the bug
        super()._do_run_until(t_ns)


@found_by(
    "a_synaptic_potential_follows_its_equations",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "reading_changes_nothing",
    "state_is_returned_in_the_requested_order",
)
class IsDisturbedByReading(SmallBrain):
    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        values = super()._do_read_state(variable, neurons)
        self.live.v[neurons] += 0.01
        return values


@found_by(
    "state_is_returned_in_the_requested_order",
)
class ReadsInTheOrderOfIds(SmallBrain):
    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return super()._do_read_state(variable, np.sort(neurons))


@found_by(
    "a_cell_can_act_on_itself",
    "a_cell_under_a_current_fires_at_the_times_of_its_equations",
    "a_cell_does_not_fire_in_its_refractory_period",
    "input_during_a_refractory_period_acts_after_it",
    "synaptic_input_outlasts_the_spikes_that_it_causes",
)
class IsNeverRefractory(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.live.free_at[neuron] = 0


@found_by(
    "a_device_acts_within_its_delay_and_a_step",
    "a_synaptic_potential_follows_its_equations",
    "equal_time_constants_follow_the_equations_or_are_refused",
)
class HasSlowerSynapses(SmallBrain):
    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities)
        self.p["tau_syn_E"] = self.p["tau_syn_E"] * 1.3


@found_by(
    "a_cell_under_a_current_fires_at_the_times_of_its_equations",
    "a_current_acts_from_the_moment_it_is_set",
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
    "a_synaptic_potential_follows_its_equations",
    "equal_time_constants_follow_the_equations_or_are_refused",
)
class LeaksTooFast(SmallBrain):
    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities)
        self.p["tau_m"] = self.p["tau_m"] * 0.9


@found_by(
    "at_least_one_declared_cell_is_a_standard_one",
)
class MisspellsItsCells(SmallBackend):
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), cells=frozenset({"IF_cur_exp"}))


@found_by(
    "undeclared_cells_are_refused",
)
class TakesUnknownCellsForItsOwn(SmallBackend):
    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        known = {
            label: p if p.is_source else dataclasses.replace(p, cell_type=CELL)
            for label, p in network.populations.items()
        }
        return super().open(dataclasses.replace(network, populations=known), seed=seed, options=options)


@found_by(
    "an_unknown_synapse_type_is_refused",
    "a_synapse_type_works_if_declared_and_is_refused_if_not",
)
class TakesEverySynapseForStatic(SmallBackend):
    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        known = tuple(dataclasses.replace(p, synapse_type=STATIC) for p in network.projections)
        return super().open(dataclasses.replace(network, projections=known), seed=seed, options=options)


@found_by(
    "stdp_changes_a_weight_by_the_time_between_spikes",
)
class PromisesPlasticity(SmallBackend):
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), synapses=frozenset({STATIC, STDP}))


class _NeverStops(EventBrain):
    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None:
        pass


@register(FOUND_BY, EventBackend, "brain")(
    "learning_stops_and_continues_or_is_refused",
)
class PromisesToStopLearning(EventBackend):
    def open(self, network: Network, *, seed: int, options: Any) -> Brain:
        return _NeverStops(network, seed, self.capabilities(options), options)


class _NeverRewarded(EventBrain):
    def _do_reward(self, population: str, amount: float) -> None:
        pass


@register(FOUND_BY, EventBackend, "brain")(
    "rewards_from_outside_change_weights_or_are_refused",
)
class PromisesRewards(EventBackend):
    def open(self, network: Network, *, seed: int, options: Any) -> Brain:
        return _NeverRewarded(network, seed, self.capabilities(options), options)


class _Junctions(SmallBrain):
    """Has gap junctions, but only the first cell of each acts on the second."""

    def continuous(self) -> list[Projection]:
        return [p for p in self.network.projections if p.synapse_type in CONTINUOUS]

    def integrate(self) -> None:
        s, alone = self.live, self.live.current
        for p in self.continuous():
            pre, post = (
                self.network.offsets[name] + at for name, at in ((p.pre, p.pre_index), (p.post, p.post_index))
            )
            s.current = alone.copy()
            np.add.at(s.current, post, p.weight * (s.v[pre] - s.v[post]))
        super().integrate()
        s.current = alone


@found_by("a_gap_junction_carries_current_both_ways")
class LetsJunctionsPassOneWay(SmallBackend):
    brain = _Junctions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), synapses=frozenset({STATIC, ELECTRICAL}))


class _Release(_Junctions):
    """Has graded release, but all or nothing."""

    def integrate(self) -> None:
        s, alone = self.live, self.live.current
        for p in self.continuous():
            s.current = alone.copy()
            v = s.v[self.network.offsets[p.pre] + p.pre_index]
            np.add.at(s.current, p.post_index, p.weight * (v > p.synapse_parameters["v_th"]))
        SmallBrain.integrate(self)
        s.current = alone


@found_by("graded_release_follows_the_voltage_of_its_source")
class ReleasesAllOrNothing(SmallBackend):
    brain = _Release

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), synapses=frozenset({STATIC, GRADED}))


class _Unmoved(SmallBrain):
    def _do_set_parameters(self, change: ParameterChange) -> None:
        pass

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return projection.weight.copy()

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        pass


@found_by(
    "a_reset_undoes_changes_and_a_snapshot_keeps_them",
    "each_weight_gets_its_own_new_value",
    "parameters_change_from_now_on_or_are_refused",
    "current_weights_can_be_read",
    "weights_change_from_now_on_or_are_refused",
)
class PromisesChanges(SmallBackend):
    brain = _Unmoved

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), changes=frozenset({PARAMETERS, WEIGHTS}))


@found_by(
    "a_snapshot_keeps_a_current",
    "a_snapshot_keeps_simultaneous_activity",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_the_membrane_and_its_synapses",
    "a_snapshot_keeps_the_refractory_time",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
    "a_snapshot_keeps_the_values_of_devices",
    "a_snapshot_of_another_network_is_refused",
    "undeclared_snapshots_are_refused",
)
class PromisesSnapshots(SmallBrain):
    def _do_save(self) -> object:
        raise NotImplementedError


@found_by(
    "delays_are_used_as_precisely_as_they_are_given",
    "a_brain_with_a_grid_stops_only_on_it_and_one_without_stops_anywhere",
    "a_cell_under_a_current_fires_at_the_times_of_its_equations",
    "a_device_acts_within_its_delay_and_a_step",
    "a_cell_does_not_fire_in_its_refractory_period",
    "a_spike_arrives_after_its_delay_and_not_before",
    "splitting_a_run_is_invisible",
    "input_during_a_refractory_period_acts_after_it",
)
class HidesItsGrid(SmallBackend):
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), resolution_ns=None)


@found_by(
    "a_delay_of_0_is_a_step_of_the_grid_or_is_refused",
    "the_spikes_of_a_brain_with_a_grid_lie_on_it",
)
class NamesACoarserGridThanItHas(SmallBackend):
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return dataclasses.replace(super().capabilities(options), resolution_ns=1_000_000)
