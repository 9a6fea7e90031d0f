"""Capability: declared features and changes work, and others are refused rather than silently ignored."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from nrp_conformance.base import skip_undeclared
from nrp_conformance.brain.kit import (
    EXACT_MS,
    SAMPLES,
    BrainKit,
    cells,
    connect,
    network,
    poisson,
    record,
    spikes,
    times,
    train,
)
from nrp_core.brain import PARAMETERS, PLASTICITY, WEIGHTS, Brain, PoissonSource, SpikeRecorderPort
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, NetworkError, TimestepError
from nrp_core.network.data import Population, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import LAWS, STDP, TSODYKS_MARKRAM
from nrp_core.simulation import Determinism

SYNAPSES: dict[str, dict[str, Any]] = {name: law.defaults for name, law in LAWS.items()}
SYNAPSES[STDP]["w_max"] = 9.0  # larger than the weights of all samples
RULE = LAWS[STDP].first_parts
PRECISION = 0.01
"""The allowed relative error of a stored weight."""
USE = 0.98
"""The share that the first spike releases; with the strong synapse it makes a cell fire."""


class CapabilityTests(BrainKit):
    """The declaration of capabilities is correct, in both directions."""

    level = "capability"

    def test_capabilities_are_the_same_at_every_call(self) -> None:
        declared = self.capabilities
        assert self.backend.capabilities(self.chosen) == declared
        assert self.open(self.cells("n")).capabilities == declared
        assert declared.extensions <= declared.cells | declared.synapses
        assert declared.resolution_ns is None or declared.resolution_ns > 0

    def test_every_declared_cell_can_be_opened_and_run(self) -> None:
        for name in sorted(self.capabilities.cells & SAMPLES.keys()):
            with self.open(cells(SAMPLES[name], "n", 2)) as brain:
                self.run(brain, 3)

    def test_undeclared_cells_are_refused(self) -> None:
        for name in sorted({*SAMPLES, "NoSuchCell"} - self.capabilities.cells):
            unknown = replace(cells(self.sample, "n"), cell_type="NoSuchCell")
            with pytest.raises(CapabilityError):
                self.open(cells(SAMPLES[name], "n") if name in SAMPLES else unknown)

    def test_unknown_source_cells_are_refused(self) -> None:
        with pytest.raises(CapabilityError):
            self.open(Population("s", 1, "SpikeSourceNobodyKnows", {}))

    @pytest.mark.parametrize("kind", sorted(SYNAPSES))
    def test_a_synapse_type_works_if_declared_and_is_refused_if_not(self, kind: str) -> None:
        rule = LAWS[kind].first_parts or None
        delay_ms, source = 1.0, spikes("s", [2.0, 30.0])
        if LAWS[kind].continuous:
            delay_ms, source = 0.0, self.cells("s")
        synapse = connect("s", "n", self.sample.strong, delay_ms, kind=kind, rule=rule, **SYNAPSES[kind])
        parts = source, self.cells("n"), synapse
        try:
            network(*parts)
        except NetworkError:  # of weights in mV, no current follows a voltage
            skip_undeclared(f"cells that {kind} synapses reach")
        if kind in self.capabilities.synapses:
            self.run(self.open(*parts), 40)
        else:
            with pytest.raises(CapabilityError):
                self.open(*parts)

    def test_an_unknown_synapse_type_is_refused(self) -> None:
        with pytest.raises(CapabilityError):
            self.open(spikes("s", [2.0]), self.cells("n"), connect("s", "n", 1.0, 1.0, kind="nobody_knows"))

    def test_declared_state_variables_can_be_read(self) -> None:
        for name in sorted(self.capabilities.cells & SAMPLES.keys()):
            brain = self.open(cells(SAMPLES[name], "n", 3))
            self.run(brain, 2)
            readable = 0
            for variable in sorted(self.capabilities.state_variables):
                try:
                    values = brain.read_state(variable, [0, 2])
                except CapabilityError:
                    continue  # a variable that only other cells have
                readable += 1
                assert values.shape == (2,)
                assert all(map(math.isfinite, values))
            assert readable or not self.capabilities.state_variables, name
            brain.close()

    def test_undeclared_state_variables_are_refused(self) -> None:
        brain = self.open(self.cells("n"))
        for variable in ({"v", "gsyn_exc"} - self.capabilities.state_variables) | {"no_such_variable"}:
            with pytest.raises(CapabilityError):
                brain.read_state(variable, [0])

    def test_state_is_returned_in_the_requested_order(self) -> None:
        self.require_declared()
        brain = self.open(self.cells("a", 3, i_offset=[0.0, 0.1, 0.2]), spikes("s", [1.0]), self.cells("b"))
        self.run(brain, 6)
        first, *_, last = brain.read_state("v", [0, 1, 2])
        assert first < last
        assert list(brain.read_state("v", [2, 4, 0])) == [last, first, first]

    def test_undeclared_snapshots_are_refused(self) -> None:
        brain = self.open(*self.busy())
        self.run(brain, 5)
        if self.capabilities.snapshot:
            assert brain.snapshot().t_ns == brain.now_ns
        else:
            with pytest.raises(CapabilityError):
                brain.snapshot()

    def test_a_brain_with_a_grid_stops_only_on_it_and_one_without_stops_anywhere(self) -> None:
        brain = self.open(self.cells("n"))
        step_ns = self.capabilities.resolution_ns
        if step_ns is None:
            brain.run_until(1_234_567)
            assert brain.now_ns == 1_234_567
        else:
            with pytest.raises(TimestepError):
                brain.run_until(step_ns + step_ns // 2 + 1)

    def test_the_spikes_of_a_brain_with_a_grid_lie_on_it(self) -> None:
        step_ns = self.capabilities.resolution_ns
        if step_ns is None:
            skip_undeclared("a resolution")
        brain = self.open(
            self.cells("n", 5, i_offset=[self.sample.current_na * f for f in (1, 1.1, 2, 3, 4)])
        )
        recorded = record(brain)
        self.run(brain, 50)
        steps = recorded.spikes().times_ms / milliseconds(step_ns)
        assert len(steps), "no cell fired"
        assert steps == pytest.approx(steps.round(), abs=1e-6)

    def test_runs_repeat_as_declared(self) -> None:
        if self.capabilities.determinism is Determinism.STATISTICAL:
            skip_undeclared("repeatable runs")
        trains = []
        for _ in range(2):
            with self.open(*self.busy()) as brain:
                recorded = record(brain)
                brain.add_source(PoissonSource(rate=200.0, weight=self.sample.strong), [5, 6], name="noise")
                self.run(brain, 60)
                trains.append(train(recorded))
        assert trains[0] == trains[1]

    def test_unknown_options_are_refused(self) -> None:
        with pytest.raises(ValidationError):
            self.backend.options.model_validate({**self.options, "no_such_option": 1})


class ChangeTests(BrainKit):
    """Changes of cell parameters and synaptic weights at run time."""

    level = "capability"

    def test_parameters_change_from_now_on_or_are_refused(self) -> None:
        driven = self.open(self.cells("n", 3))
        recorded = record(driven)
        self.run(driven, 20)
        since_ms = milliseconds(driven.now_ns)
        if PARAMETERS not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                driven.set_parameters([1], {"i_offset": self.sample.current_na})
            return
        driven.set_parameters([1], {"i_offset": self.sample.current_na})
        self.run(driven, 80)
        from_the_start = self.open(self.cells("n", i_offset=self.sample.current_na))
        expected = record(from_the_start)
        self.run(from_the_start, 60)
        found = [time - since_ms for time in times(recorded, 1)]
        assert len(found) >= 1
        for n, (a, b) in enumerate(zip(found, times(expected, 0), strict=False)):
            assert a == pytest.approx(b, abs=(n + 1) * self.tolerance_ms + EXACT_MS)
        assert not times(recorded, 0) + times(recorded, 2)

    def test_a_reset_undoes_changes_and_a_snapshot_keeps_them(self) -> None:
        self._require(PARAMETERS)
        brain = self.open(self.cells("n"))
        recorded = record(brain)
        brain.set_parameters([0], {"i_offset": self.sample.current_na})
        self.run(brain, 10)
        snapshot = brain.snapshot() if self.capabilities.snapshot else None
        self.run(brain, 70)
        driven = times(recorded, 0)
        brain.reset()
        self.run(brain, 70)
        assert driven, "the changed parameter had no effect"
        assert not times(recorded, 0)
        if snapshot is not None:
            brain.restore(snapshot)
            self.run(brain, 70)
            assert times(recorded, 0) == driven

    def test_weights_change_from_now_on_or_are_refused(self) -> None:
        brain = self._with_synapse([10.0, 50.0, 90.0])
        recorded = record(brain, [1])
        self.run(brain, 30)
        if WEIGHTS not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                brain.set_weights("s to n, excitatory", 0.0)
            return
        brain.set_weights("s to n, excitatory", 0.0)
        self.run(brain, 70)
        brain.set_weights("s to n, excitatory", self.sample.strong)
        self.run(brain, 120)
        first, second = times(recorded, 1)
        assert first < 50
        assert second > 90

    def test_each_weight_gets_its_own_new_value(self) -> None:
        """The order is that of the synapses, which differs from that of the sources and of the targets."""
        self._require(WEIGHTS)
        strong = self.sample.strong
        fan = connect("s", "n", strong, 2.0, pairs=[(2, 1), (0, 2), (1, 0)])
        brain = self.open(spikes("s", [15.0], [15.0], [15.0]), self.cells("n", 3), fan)
        recorded = record(brain, [3, 4, 5])
        self.run(brain, 10)
        weights = [0.0, strong, 0.25 * strong]
        brain.set_weights("s to n, excitatory", weights)
        assert brain.read_weights("s to n, excitatory") == pytest.approx(weights, rel=PRECISION)
        self.run(brain, 40)
        assert times(recorded, 5), "the second synapse is that of the third cell"
        assert not times(recorded, 4), "the first synapse is that of the second cell"

    def test_a_spike_in_transit_keeps_the_weight_at_which_it_was_sent(self) -> None:
        self._require(WEIGHTS)
        brain = self._with_synapse([5.0], delay=14.0)
        recorded = record(brain, [1])
        self.run(brain, 12)
        brain.set_weights("s to n, excitatory", 0.0)
        self.run(brain, 40)
        assert len(times(recorded, 1)) == 1

    def test_current_weights_can_be_read(self) -> None:
        brain = self._with_synapse([10.0])
        name, weight = "s to n, excitatory", self.sample.strong
        assert brain.read_weights(name) == pytest.approx([weight], rel=PRECISION)
        if WEIGHTS in self.capabilities.changes:
            self.run(brain, 5)
            brain.set_weights(name, weight / 2)
            assert brain.read_weights(name) == pytest.approx([weight / 2], rel=PRECISION)
            brain.reset()
            assert brain.read_weights(name) == pytest.approx([weight], rel=PRECISION)

    def test_plastic_weights_can_be_read_or_are_refused(self) -> None:
        sample, brain, name = self.sample, *self._with_plastic([20.0, 200.0], [26.0])
        if WEIGHTS not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                brain.read_weights(name)
            return
        assert brain.read_weights(name) == pytest.approx([sample.weak], rel=PRECISION)
        self.run(brain, 220)
        assert brain.read_weights(name)[0] > 1.3 * sample.weak

    def test_learning_stops_and_continues_or_is_refused(self) -> None:
        """Pairs with a forced spike; the third spike of the source reports the weight, long after."""
        sample, brain, name = self.sample, *self._with_plastic([20.0, 220.0, 420.0], [26.0, 226.0])
        if PLASTICITY not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                brain.set_plastic(name, False)
            return
        with pytest.raises(NetworkError):
            brain.set_plastic("force to n, excitatory", False)
        brain.set_plastic(name, False)
        self.run(brain, 100)
        assert brain.read_weights(name) == pytest.approx([sample.weak], rel=PRECISION)
        brain.set_plastic(name, True)
        self.run(brain, 330)
        learned = brain.read_weights(name)
        assert learned[0] > 1.3 * sample.weak
        brain.set_plastic(name, False)
        brain.reset()
        assert brain.is_plastic(name)
        self.run(brain, 100)
        assert brain.read_weights(name) == pytest.approx(learned, rel=0.05)

    def test_rewards_from_outside_change_weights_or_are_refused(self) -> None:
        """A pair of spikes, then a reward: the weight follows the product of two decaying quantities."""
        if STDP not in self.capabilities.synapses:
            skip_undeclared("stdp synapses")
        sample, modulation = self.sample, Neuromodulation(w_max=50 * self.sample.weak)
        limits = {"w_min": 0.0, "w_max": 2 * sample.weak, "A_plus": 0.5, "A_minus": 0.5}
        plastic = connect("pre", "n", 5 * sample.weak, 1.0, kind=STDP, rule=RULE, **SYNAPSES[STDP] | limits)
        reward = replace(connect("good", "n", 0.1), receptor="reward", neuromodulation=modulation)
        parts: list[Population | Projection] = [
            spikes("pre", [20.0]), spikes("force", [26.0]), spikes("good", [9000.0]), self.cells("n"),
            plastic, connect("force", "n", sample.strong, 1.0),
        ]  # fmt: skip
        if not self.capabilities.neuromodulation:
            with pytest.raises(CapabilityError):
                self.open(*parts, reward)
            return
        try:
            brain = self.open(*parts, reward)
        except CapabilityError:  # it has the other definition
            modulation = replace(modulation, shared=True, eligibility_limits=False)
            brain = self.open(*parts, replace(reward, neuromodulation=modulation))
        name, weights = plastic.label, []
        if not self.capabilities.rewards:
            with pytest.raises(CapabilityError):
                brain.reward(name, 0.01)
            return
        for until, amount in ((100, 0.01), (300, 0.0), (500, -0.01)):
            self.run(brain, until)
            weights.append(float(brain.read_weights(name)[0]))
            brain.reward(name, amount)
        self.run(brain, 700)
        first, second, third, fourth = *weights, float(brain.read_weights(name)[0])
        assert first == pytest.approx(5 * sample.weak, rel=PRECISION)
        left = math.exp(-200 * (1 / modulation.tau_c + 1 / modulation.tau_d))
        assert (third - second) / (second - first) == pytest.approx(left, rel=0.05)
        later = math.exp(-400 / modulation.tau_c) - math.exp(-400 / modulation.tau_c - 400 / modulation.tau_d)
        assert (third - fourth) / (second - first) == pytest.approx(later, rel=0.05)
        brain.hold_reward(name, 0.01)
        self.run(brain, 900)
        fade, left = 1 / modulation.tau_c + 1 / modulation.tau_d, math.exp(-600 / modulation.tau_c)
        dopamine = math.exp(-600 / modulation.tau_d) - math.exp(-200 / modulation.tau_d)
        decaying = left * dopamine * -math.expm1(-200 * fade) / fade
        held = left * -math.expm1(-200 / modulation.tau_c) * modulation.tau_c
        expected = (decaying + held) / (-math.expm1(-200 * fade) / fade)
        change = float(brain.read_weights(name)[0]) - fourth
        assert change / (second - first) == pytest.approx(expected, rel=0.05)
        with pytest.raises(NetworkError):
            brain.reward("force to n, excitatory", 1.0)

    def _with_plastic(self, pre_ms: list[float], force_ms: list[float]) -> tuple[Brain, str]:
        """Return a brain with a plastic synapse onto a cell that fires when it is forced to, and its name."""
        if STDP not in self.capabilities.synapses:
            skip_undeclared("stdp synapses")
        sample = self.sample
        limits = {"w_min": 0.0, "w_max": 2 * sample.weak, "A_plus": 0.5, "A_minus": 0.5}
        plastic = connect("pre", "n", sample.weak, 1.0, kind=STDP, rule=RULE, **{**SYNAPSES[STDP], **limits})
        force = connect("force", "n", sample.strong, 1.0)
        brain = self.open(spikes("pre", pre_ms), spikes("force", force_ms), self.cells("n"), plastic, force)
        return brain, "pre to n, excitatory"

    def test_the_rate_of_source_cells_changes_from_now_on(self) -> None:
        brain = self.open(poisson("noise", 4, 0.0), self.cells("n"))
        recorded = record(brain, range(4))
        self.run(brain, 50)
        try:
            brain.set_parameters([1, 2], {"rate": [0.0, 500.0]})
        except CapabilityError:
            assert PARAMETERS not in self.capabilities.changes
            return
        self.run(brain, 250)
        found = recorded.spikes()
        assert set(found.neurons.tolist()) == {2}
        assert found.times_ms.min() > 50 - self.tolerance_ms
        assert 50 < len(found) < 160

    def test_the_spikes_of_source_cells_can_be_replaced(self) -> None:
        brain = self.open(spikes("s", [10.0, 60.0], [12.0, 61.0]), self.cells("n"))
        recorded = record(brain, [0, 1])
        self.run(brain, 30)
        try:
            brain.set_spike_times("s", [[10.0, 40.0, 55.0]], cells=[0])
        except CapabilityError:
            assert PARAMETERS not in self.capabilities.changes
            return
        self.run(brain, 80)
        assert times(recorded, 0) == pytest.approx([10.0, 40.0, 55.0], abs=self.tolerance_ms)
        assert times(recorded, 1) == pytest.approx([12.0, 61.0], abs=self.tolerance_ms)

    def test_impossible_changes_are_refused(self) -> None:
        brain = self._with_synapse([10.0])
        wrong: list[dict[str, Any]] = [
            {"no_such_parameter": 1.0},
            {"i_offset": np.nan},
            {"i_offset": [1.0, 2.0]},
        ]
        wrong += [{name: -1.0} for name in ("tau_m", "cm") if name in self.sample.all_parameters]
        for values in wrong:
            with pytest.raises(NetworkError):
                brain.set_parameters([1], values)
        for label, weights in (
            ("nobody", 1.0),
            ("s to n, excitatory", np.nan),
            ("s to n, excitatory", [1.0, 2.0]),
        ):
            with pytest.raises(NetworkError):
                brain.set_weights(label, weights)
        with pytest.raises(NetworkError):
            brain.set_spike_times("s", [[5.0, 3.0]])

    def _with_synapse(self, emitted: list[float], delay: float = 1.0) -> Brain:
        synapse = connect("s", "n", self.sample.strong, delay)
        return self.open(spikes("s", emitted), self.cells("n"), synapse)

    def _require(self, what: str) -> None:
        if what not in self.capabilities.changes:
            skip_undeclared(f"changes of {what}")


class ShortTermTests(BrainKit):
    """A first spike makes a cell fire; a second one soon after does not."""

    level = "capability"

    def test_each_synapse_depresses_by_its_own_constants(self) -> None:
        recorded, brain = self._depressing([USE, 0.02, USE], [5000.0, 5000.0, 2.0])
        self.run(brain, 70)
        assert len(times(recorded, 1)) == 1, "the first synapse is empty when the second spike comes"
        assert not times(recorded, 2), "the second synapse hardly releases anything"
        assert len(times(recorded, 3)) == 2, "the third synapse is full again when the second spike comes"

    def test_a_reset_restores_depressed_synapses(self) -> None:
        self.require_repeatable()
        recorded, brain = self._depressing(USE, 5000.0)
        self.run(brain, 30)
        expected = train(recorded)
        assert expected
        brain.reset()
        self.run(brain, 30)
        assert train(recorded) == expected

    def test_a_snapshot_keeps_the_depression_of_synapses(self) -> None:
        self.require_snapshot()
        recorded, brain = self._depressing(USE, 5000.0)
        self.run(brain, 30)
        snapshot = brain.snapshot()
        there, fresh = self._depressing(USE, 5000.0)
        for again, found in ((brain, recorded), (fresh, there)):
            again.restore(snapshot)
            self.run(again, 70)
            assert not train(found, 30.0), "the synapses are still empty when the second spike comes"

    def _depressing(
        self, use: float | list[float], recovery_ms: float | list[float]
    ) -> tuple[SpikeRecorderPort, Brain]:
        """Open three cells that a source with two spikes makes fire, and record them."""
        if TSODYKS_MARKRAM not in self.capabilities.synapses:
            skip_undeclared("tsodyks_markram synapses")
        plastic = connect(
            "s", "n", self.sample.strong / USE, 1.0, pairs=[(0, 0), (0, 1), (0, 2)],
            kind=TSODYKS_MARKRAM, U=use, tau_rec=recovery_ms, tau_facil=0.0,
        )  # fmt: skip
        brain = self.open(spikes("s", [4.0, 40.0]), self.cells("n", 3), plastic)
        return record(brain, [1, 2, 3]), brain
