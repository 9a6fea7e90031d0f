"""Brains with one bug each in what happens when: delays, windows, snapshots, resets."""

from __future__ import annotations

from typing import Any

from registry import Found, register
from small_brain import GRID, STEP_MS, SmallBackend, SmallBrain, State

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.spikes import Spikes

FOUND_BY: Found = {}
found_by = register(FOUND_BY, SmallBackend, "brain")


@found_by(
    "a_cell_can_act_on_itself",
    "a_snapshot_keeps_spikes_in_flight",
    "a_spike_arrives_after_its_delay_and_not_before",
    "a_synaptic_potential_follows_its_equations",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "each_synapse_has_its_own_delay",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "nothing_acts_before_its_delay",
)
class IgnoresDelays(SmallBrain):
    def send(self, neuron: int, time_ms: float) -> None:
        for target, weight, _, receptor in self.targets[neuron]:
            self.post(target, weight, time_ms + 1.0, receptor)


@found_by(
    "a_spike_arrives_after_its_delay_and_not_before",
    "a_synaptic_potential_follows_its_equations",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "input_during_a_refractory_period_acts_after_it",
)
class AddsAMillisecondToDelays(SmallBrain):
    def send(self, neuron: int, time_ms: float) -> None:
        super().send(neuron, time_ms + 1.0)


@found_by(
    "each_synapse_has_its_own_delay",
    "projections_between_the_same_cells_keep_their_delays_and_receptors",
)
class UsesTheFirstDelayForAll(SmallBrain):
    def send(self, neuron: int, time_ms: float) -> None:
        for target, weight, _, receptor in self.targets[neuron]:
            self.post(target, weight, time_ms + self.targets[neuron][0][2], receptor)


@found_by(
    "a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once",
    "a_synaptic_potential_follows_its_equations",
    "an_injected_spike_acts_like_a_spike_of_a_source",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "projections_between_the_same_cells_keep_their_delays_and_receptors",
    "splitting_a_run_is_invisible",
)
class DropsSourceSpikesAtTheEdge(SmallBrain):
    waiting: tuple[IntArray, FloatArray] | None = None

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self.waiting = neurons, times_ms

    def _do_run_until(self, t_ns: int) -> None:
        if self.waiting is not None:
            neurons, times = self.waiting
            inside = times < t_ns / 1e6
            super()._do_fire(neurons[inside], times[inside])
            self.waiting = None
        super()._do_run_until(t_ns)


@found_by(
    "splitting_a_run_is_invisible",
    "two_brains_in_one_process_do_not_disturb_each_other",
)
class DropsSpikesAtTheEdge(SmallBrain):
    def _do_take_spikes(self) -> Spikes:
        self.spikes = [spike for spike in self.spikes if spike[1] < self.live.tick * STEP_MS]
        return super()._do_take_spikes()


@found_by(
    "a_late_recorder_records_no_earlier_spikes",
    "every_spike_is_reported_in_its_own_window",
)
class ReportsSpikesOneWindowLate(SmallBrain):
    def _do_take_spikes(self) -> Spikes:
        edge = self.live.tick * STEP_MS - 1.0
        late = [spike for spike in self.spikes if spike[1] > edge]
        self.spikes = [spike for spike in self.spikes if spike[1] <= edge]
        taken = super()._do_take_spikes()
        self.spikes = late
        return taken


@found_by(
    "a_cell_can_act_on_itself",
    "a_cell_under_a_current_fires_at_the_times_of_its_equations",
    "a_cell_does_not_fire_in_its_refractory_period",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
    "a_source_spike_at_the_edge_of_a_window_is_counted_once_and_acts_once",
    "an_injected_spike_acts_after_its_delay",
    "every_kind_of_cell_can_be_recorded_under_its_own_id",
    "spikes_reach_the_connected_cell_and_no_other",
    "input_during_a_refractory_period_acts_after_it",
    "synaptic_input_outlasts_the_spikes_that_it_causes",
)
class ReportsSpikesTwice(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.spikes.append(self.spikes[-1])


@found_by(
    "a_current_acts_from_the_moment_it_is_set",
    "every_spike_is_reported_in_its_own_window",
    "nothing_acts_before_its_delay",
)
class RunsTooFar(SmallBrain):
    def _do_run_until(self, t_ns: int) -> None:
        super()._do_run_until(t_ns)
        self.step()


@found_by(
    "a_synapse_starts_from_its_initial_value_or_that_is_refused",
    "a_synaptic_potential_follows_its_equations",
    "equal_time_constants_follow_the_equations_or_are_refused",
    "splitting_a_run_is_invisible",
    "two_brains_in_one_process_do_not_disturb_each_other",
)
class StartsEveryWindowAnew(SmallBrain):
    def _do_run_until(self, t_ns: int) -> None:
        self.live.exc[:] = 0.0
        super()._do_run_until(t_ns)


@found_by(
    "a_snapshot_keeps_simultaneous_activity",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
)
class ForgetsSpikesInFlightInASnapshot(SmallBrain):
    def _do_restore(self, saved: State) -> None:
        super()._do_restore(saved)
        self.live.in_flight.clear()


@found_by(
    "a_snapshot_keeps_simultaneous_activity",
    "a_snapshot_keeps_the_refractory_time",
)
class ForgetsTheRefractoryTimeInASnapshot(SmallBrain):
    def _do_restore(self, saved: State) -> None:
        super()._do_restore(saved)
        self.live.free_at[:] = 0


@found_by(
    "a_snapshot_keeps_simultaneous_activity",
    "a_snapshot_keeps_the_membrane_and_its_synapses",
)
class ForgetsSynapsesInASnapshot(SmallBrain):
    def _do_restore(self, saved: State) -> None:
        super()._do_restore(saved)
        self.live.exc[:] = 0.0


@found_by(
    "a_snapshot_keeps_a_current",
    "a_snapshot_keeps_simultaneous_activity",
)
class ForgetsCurrentsInASnapshot(SmallBrain):
    def _do_restore(self, saved: State) -> None:
        super()._do_restore(saved)
        self.live.current[:] = 0.0


@found_by(
    "a_snapshot_keeps_a_current",
    "a_snapshot_keeps_simultaneous_activity",
    "a_snapshot_keeps_spikes_in_flight",
    "a_snapshot_keeps_the_membrane_and_its_synapses",
    "a_snapshot_keeps_the_refractory_time",
    "a_snapshot_keeps_spikes_in_flight_from_a_device",
)
class SharesItsStateWithItsSnapshots(SmallBrain):
    def _do_save(self) -> object:
        self.kept = self.live
        return self.live.tick

    def _do_restore(self, saved: Any) -> None:
        self.live = self.kept
        self.live.tick = saved


@found_by("after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one")
class CountsTicksOnOverAReset(SmallBrain):
    """A reset of the state leaves the counter of ticks at the time of the brain."""

    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        self.live.tick = GRID.number_of(self.now_ns)


@found_by(
    "after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one",
    "a_reset_brain_equals_a_fresh_one",
    "a_reset_forgets_spikes_in_transit",
    "a_reset_repeats_the_noise",
    "a_reset_with_another_seed_equals_a_brain_opened_with_it",
)
class KeepsSpikesInFlightOverAReset(SmallBrain):
    def _do_reset(self, seed: int) -> None:
        kept = {tick - self.live.tick: sent for tick, sent in self.live.in_flight.items()}
        super()._do_reset(seed)
        self.live.in_flight.update(kept)


@found_by(
    "a_cell_starts_from_its_initial_potential_also_after_a_reset",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_reset_brain_equals_a_fresh_one",
    "a_reset_forgets_spikes_in_transit",
    "a_reset_repeats_the_noise",
    "a_reset_with_another_seed_equals_a_brain_opened_with_it",
    "after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one",
)
class KeepsTheMembraneOverAReset(SmallBrain):
    def _do_reset(self, seed: int) -> None:
        v = self.live.v
        super()._do_reset(seed)
        self.live.v = v


@found_by(
    "a_cell_starts_from_its_initial_potential_also_after_a_reset",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_reset_brain_equals_a_fresh_one",
    "a_reset_forgets_spikes_in_transit",
    "a_reset_repeats_the_noise",
    "a_reset_with_another_seed_equals_a_brain_opened_with_it",
    "a_synapse_starts_from_its_initial_value_or_that_is_refused",
    "after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one",
)
class ReseedsOnReset(SmallBrain):
    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        for train in self._trains:
            train.reset(self._seeds.child(f"again {id(object())}"))
