"""Brains with one bug each at the limits of numbers: signs, truncation, wrap-around, floors, first values."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from registry import Found, register
from small_brain import STEP_MS, SmallBackend, SmallBrain, State

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.spikes import Spikes, SynapticEvents

FOUND_BY: Found = {}
found_by = register(FOUND_BY, SmallBackend, "brain")
WRAPPED = 512


@found_by(
    "a_synaptic_potential_follows_its_equations",
)
class TakesOneSynapticTimeConstantForBoth(SmallBrain):
    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.p["tau_syn_I"] = self.p["tau_syn_E"]


@found_by(
    "a_synapse_starts_from_its_initial_value_or_that_is_refused",
)
class StartsWithoutInhibitoryCurrent(SmallBrain):
    def fresh(self) -> State:
        started = super().fresh()
        started.inh[:] = 0.0
        return started


@found_by(
    "a_synapse_starts_from_its_initial_value_or_that_is_refused",
)
class ForgetsInitialCurrentsOnAReset(SmallBrain):
    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        self.live.exc[:] = 0.0


@found_by(
    "a_fixed_frequency_source_sends_equidistant_spikes",
    "a_spike_arrives_after_its_delay_and_not_before",
    "splitting_a_run_is_invisible",
    "the_noise_of_a_device_does_not_depend_on_other_devices",
    "two_brains_in_one_process_do_not_disturb_each_other",
)
class WrapsLongDelays(SmallBrain):
    def post(self, target: int, weight: float, time_ms: float, receptor: str) -> None:
        tick = max(self.live.tick, ceil(time_ms / STEP_MS - 1e-9))
        wrapped = self.live.tick + (tick - self.live.tick) % WRAPPED
        self.live.in_flight[wrapped].append((target, weight, receptor))


@found_by(
    "nothing_acts_before_its_delay",
)
class TruncatesArrivals(SmallBrain):
    def post(self, target: int, weight: float, time_ms: float, receptor: str) -> None:
        tick = max(self.live.tick, int(time_ms / STEP_MS))
        self.live.in_flight[tick].append((target, weight, receptor))


@found_by(
    "a_cell_does_not_fire_in_its_refractory_period",
)
class TruncatesRefractoryTimes(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.live.free_at[neuron] = self.live.tick + int(self.p["tau_refrac"][neuron] / STEP_MS)


@found_by(
    "each_cell_has_its_own_parameters",
)
class TakesTheFirstThresholdForAll(SmallBrain):
    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        thresholds = self.p["v_thresh"][self.alive]
        self.p["v_thresh"][self.alive] = thresholds[:1]


@found_by(
    "each_cell_has_its_own_parameters",
)
class TakesTheFirstRefractoryTimeForAll(SmallBrain):
    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        times = self.p["tau_refrac"][self.alive]
        self.p["tau_refrac"][self.alive] = times[:1]


@found_by(
    "every_spike_is_reported_in_its_own_window",
    "the_spikes_of_a_brain_with_a_grid_lie_on_it",
)
class TellsTimesInSinglePrecision(SmallBrain):
    def _do_take_spikes(self) -> Spikes:
        taken = super()._do_take_spikes()
        return Spikes(taken.neurons, taken.times_ms.astype(np.float32).astype(float))


@found_by(
    "a_device_acts_within_its_delay_and_a_step",
    "a_spike_arrives_after_its_delay_and_not_before",
)
class ReceivesAfterTheStep(SmallBrain):
    def step(self) -> None:
        late = self.live.in_flight.pop(self.live.tick, ())
        super().step()
        for target, weight, receptor in late:
            self.receive(target, weight, receptor)


@found_by(
    "input_during_a_refractory_period_acts_after_it",
)
class ClipsLargeWeights(SmallBrain):
    def receive(self, target: int, weight: float, receptor: str) -> None:
        super().receive(target, min(max(weight, -20.0), 20.0), receptor)


@found_by(
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
)
class HoldsTheMembraneAboveAFloor(SmallBrain):
    def integrate(self) -> None:
        super().integrate()
        floor = self.p["v_rest"] - 12.0
        self.live.v = np.where(self.alive, np.maximum(self.live.v, floor), self.live.v)


@found_by(
    "synaptic_input_outlasts_the_spikes_that_it_causes",
)
class EndsSynapticInputWithASpike(SmallBrain):
    def fire(self, neuron: int) -> None:
        super().fire(neuron)
        self.live.exc[neuron] = 0.0


@found_by(
    "a_cell_can_act_on_itself",
    "synaptic_input_outlasts_the_spikes_that_it_causes",
)
class StopsSynapsesWhileRefractory(SmallBrain):
    def integrate(self) -> None:
        s = self.live
        before, refractory = s.exc.copy(), self.alive & (s.tick < s.free_at)
        super().integrate()
        s.exc[refractory] = before[refractory]


@found_by(
    "a_cell_starts_from_its_initial_potential_also_after_a_reset",
    "a_current_of_the_network_flows_at_its_times_again_after_a_reset",
    "a_reset_brain_equals_a_fresh_one",
    "a_reset_forgets_spikes_in_transit",
    "a_reset_repeats_the_noise",
    "a_reset_with_another_seed_equals_a_brain_opened_with_it",
    "after_a_reset_of_its_state_a_brain_fires_as_a_fresh_one",
)
class KeepsRefractoryTimesOverAReset(SmallBrain):
    def _do_reset(self, seed: int) -> None:
        free_at = self.live.free_at
        super()._do_reset(seed)
        self.live.free_at = free_at


@found_by(
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
)
class TakesNoNegativeOffset(SmallBrain):
    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.p["i_offset"] = np.maximum(self.p["i_offset"], 0.0)


@found_by(
    "a_current_out_of_a_cell_hyperpolarises_it_by_its_equations",
)
class TakesNoNegativeCurrent(SmallBrain):
    def _do_set_current(self, currents_na: FloatArray) -> None:
        super()._do_set_current(np.maximum(currents_na, 0.0))


@found_by(
    "an_injected_spike_acts_like_a_spike_of_a_source",
)
class LosesInhibitorySpikesOfDevices(SmallBrain):
    def _do_inject(self, events: SynapticEvents) -> None:
        kept = events.weights > 0
        super()._do_inject(
            SynapticEvents(events.neurons[kept], events.times_ms[kept], events.weights[kept], events.receptor)
        )
