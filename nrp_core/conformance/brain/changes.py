"""Capability: changes to a running brain act from then on; unsupported changes are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nrp_core.brain.changes import PARAMETERS, WEIGHTS
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.synapses import STDP
from nrp_core.clock import milliseconds
from nrp_core.conformance.brain.capability import RULE, SYNAPSES
from nrp_core.conformance.brain.kit import EXACT_MS, BrainKit, record, times
from nrp_core.conformance.brain.parts import connect, poisson, spikes
from nrp_core.conformance.guard import undeclared
from nrp_core.errors import CapabilityError, NetworkError

PRECISION = 0.01
"""The allowed relative error of a stored weight."""


class ChangeTests(BrainKit):
    """Changes of cell parameters and synaptic weights at run time."""

    level = "capability"

    def test_parameters_change_from_now_on_or_are_refused(self) -> None:
        driven = self.open(self.cells("n", 3))
        heard = record(driven)
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
        found = [time - since_ms for time in times(heard, 1)]
        assert len(found) >= 1
        for n, (a, b) in enumerate(zip(found, times(expected, 0), strict=False)):
            assert a == pytest.approx(b, abs=(n + 1) * self.tolerance_ms + EXACT_MS)
        assert not times(heard, 0) + times(heard, 2)

    def test_a_reset_undoes_changes_and_a_snapshot_keeps_them(self) -> None:
        self._require(PARAMETERS)
        brain = self.open(self.cells("n"))
        heard = record(brain)
        brain.set_parameters([0], {"i_offset": self.sample.current_na})
        self.run(brain, 10)
        snapshot = brain.snapshot() if self.capabilities.snapshot else None
        self.run(brain, 70)
        driven = times(heard, 0)
        brain.reset()
        self.run(brain, 70)
        assert driven, "the changed parameter had no effect"
        assert not times(heard, 0)
        if snapshot is not None:
            brain.restore(snapshot)
            self.run(brain, 70)
            assert times(heard, 0) == driven

    def test_weights_change_from_now_on_or_are_refused(self) -> None:
        brain = self._with_synapse([10.0, 50.0, 90.0])
        heard = record(brain, [1])
        self.run(brain, 30)
        if WEIGHTS not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                brain.set_weights("s to n, excitatory", 0.0)
            return
        brain.set_weights("s to n, excitatory", 0.0)
        self.run(brain, 70)
        brain.set_weights("s to n, excitatory", self.sample.strong)
        self.run(brain, 120)
        first, second = times(heard, 1)
        assert first < 50
        assert second > 90

    def test_each_weight_gets_its_own_new_value(self) -> None:
        """The order is that of the synapses, which differs from that of the sources and of the targets."""
        self._require(WEIGHTS)
        strong = self.sample.strong
        fan = connect("s", "n", strong, 2.0, pairs=[(2, 1), (0, 2), (1, 0)])
        brain = self.open(spikes("s", [15.0], [15.0], [15.0]), self.cells("n", 3), fan)
        heard = record(brain, [3, 4, 5])
        self.run(brain, 10)
        weights = [0.0, strong, 0.25 * strong]
        brain.set_weights("s to n, excitatory", weights)
        assert brain.read_weights("s to n, excitatory") == pytest.approx(weights, rel=PRECISION)
        self.run(brain, 40)
        assert times(heard, 5), "the second synapse is that of the third cell"
        assert not times(heard, 4), "the first synapse is that of the second cell"

    def test_a_spike_in_transit_keeps_the_weight_at_which_it_was_sent(self) -> None:
        self._require(WEIGHTS)
        brain = self._with_synapse([5.0], delay=14.0)
        heard = record(brain, [1])
        self.run(brain, 12)
        brain.set_weights("s to n, excitatory", 0.0)
        self.run(brain, 40)
        assert len(times(heard, 1)) == 1

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
        if STDP not in self.capabilities.synapses:
            undeclared("stdp synapses")
        sample = self.sample
        limits = {"w_min": 0.0, "w_max": 2 * sample.weak, "A_plus": 0.5, "A_minus": 0.5}
        plastic = connect("pre", "n", sample.weak, 1.0, kind=STDP, rule=RULE, **{**SYNAPSES[STDP], **limits})
        force = connect("force", "n", sample.strong, 1.0)
        brain = self.open(
            spikes("pre", [20.0, 200.0]), spikes("force", [26.0]), self.cells("n"), plastic, force
        )
        name = "pre to n, excitatory"
        if WEIGHTS not in self.capabilities.changes:
            with pytest.raises(CapabilityError):
                brain.read_weights(name)
            return
        assert brain.read_weights(name) == pytest.approx([sample.weak], rel=PRECISION)
        self.run(brain, 220)
        assert brain.read_weights(name)[0] > 1.3 * sample.weak

    def test_the_rate_of_source_cells_changes_from_now_on(self) -> None:
        brain = self.open(poisson("noise", 4, 0.0), self.cells("n"))
        heard = record(brain, range(4))
        self.run(brain, 50)
        try:
            brain.set_parameters([1, 2], {"rate": [0.0, 500.0]})
        except CapabilityError:
            assert PARAMETERS not in self.capabilities.changes
            return
        self.run(brain, 250)
        found = heard.spikes()
        assert set(found.neurons.tolist()) == {2}
        assert found.times_ms.min() > 50 - self.tolerance_ms
        assert 50 < len(found) < 160

    def test_the_spikes_of_source_cells_can_be_replaced(self) -> None:
        brain = self.open(spikes("s", [10.0, 60.0], [12.0, 61.0]), self.cells("n"))
        heard = record(brain, [0, 1])
        self.run(brain, 30)
        try:
            brain.set_spike_times("s", [[10.0, 40.0, 55.0]], cells=[0])
        except CapabilityError:
            assert PARAMETERS not in self.capabilities.changes
            return
        self.run(brain, 80)
        assert times(heard, 0) == pytest.approx([10.0, 40.0, 55.0], abs=self.tolerance_ms)
        assert times(heard, 1) == pytest.approx([12.0, 61.0], abs=self.tolerance_ms)

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
            undeclared(f"changes of {what}")
