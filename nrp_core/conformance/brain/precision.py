"""Accuracy: a brain without a time grid uses each weight and each delay as precisely as they are given.

Three cells have almost equal synapses. The differences of their potentials are in proportion to those of the
synapses, whatever the cell is, so that no reference is needed.
"""

from __future__ import annotations

import pytest

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.synapses import LAWS, STATIC, STDP, TSODYKS_MARKRAM
from nrp_core.conformance.brain.capability import SYNAPSES
from nrp_core.conformance.brain.kit import BrainKit
from nrp_core.conformance.brain.parts import connect, spikes
from nrp_core.conformance.guard import undeclared

WEIGHT_STEP = 2.0**-26
"""A relative difference of weights: a fourth of what numbers of 32 bit distinguish."""
DELAY_STEP_MS = 2.0**-14
"""A difference of delays: 61 ns."""
RATIO = 128.0
"""The larger difference in units of the smaller one."""
PROPORTION = 0.5
"""The allowed relative error of the ratio of their effects; rounding makes it 0 or much larger."""
DELAY_MS = 2.3
DETERMINISTIC = pytest.mark.parametrize("kind", [STATIC, TSODYKS_MARKRAM, STDP])


class PrecisionTests(BrainKit):
    """Small differences of synapses are differences of potentials."""

    level = "accuracy"

    @DETERMINISTIC
    def test_weights_are_used_as_precisely_as_they_are_given(self, kind: str) -> None:
        shares = [1.0, 1.0 + WEIGHT_STEP, 1.0 + RATIO * WEIGHT_STEP]
        weight = 1.5 * self.sample.weak
        self._check(kind, [weight * share for share in shares], [DELAY_MS] * 3)

    @DETERMINISTIC
    def test_delays_are_used_as_precisely_as_they_are_given(self, kind: str) -> None:
        delays = [DELAY_MS, DELAY_MS + DELAY_STEP_MS, DELAY_MS + RATIO * DELAY_STEP_MS]
        self._check(kind, [1.5 * self.sample.weak] * 3, delays)

    def _check(self, kind: str, weights: list[float], delays: list[float]) -> None:
        base, small, large = self._potentials(kind, weights, delays).tolist()
        assert large != base, f"weights {weights} and delays {delays} ms have the same effect"
        found = (large - base) / (small - base) if small != base else 0.0
        message = (
            f"weights {weights} and delays {delays} ms give {[base, small, large]} mV: the second difference "
            f"has {found:.5g} times the effect of the first, not {RATIO:g} times"
        )
        assert found == pytest.approx(RATIO, rel=PROPORTION), message

    def _potentials(self, kind: str, weights: list[float], delays: list[float]) -> FloatArray:
        """Return the potentials of three cells a while after one spike, mV."""
        if self.capabilities.resolution_ns is not None:
            undeclared("exact times")
        if kind not in self.capabilities.synapses or "v" not in self.capabilities.state_variables:
            undeclared(f"{kind} synapses and state variable v")
        n = len(weights)
        synapses = connect(
            "s", "n", weights, delays, pairs=[(0, i) for i in range(n)], kind=kind,
            rule=LAWS[kind].first_parts or None, **SYNAPSES[kind],
        )  # fmt: skip
        brain = self.open(spikes("s", [5.0]), self.cells("n", n), synapses)
        self.run(brain, 11)
        return brain.read_state("v", [1 + i for i in range(n)])
