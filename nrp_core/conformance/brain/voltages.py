"""Synapses that transmit voltages, against closed forms of the voltages of leaky cells."""

from __future__ import annotations

from math import exp

import pytest

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Population, Projection
from nrp_core.brain.network.synapses import ELECTRICAL
from nrp_core.clock import milliseconds
from nrp_core.conformance.base import skip_undeclared
from nrp_core.conformance.brain.kit import SAMPLES, BrainKit, Sample, cells, connect

LEAKY = ("IF_cond_exp", "IF_cond_alpha", "IF_curr_exp", "IF_curr_alpha", "IF_curr_delta")
"""Cells that are linear below their threshold."""
DEPOLARISATION_MV = 8.0
"""By a current into a cell alone; it stays below the threshold."""
PRECISION = 0.005
"""The allowed error of a voltage, as a share of the depolarisation, besides that of the time grid."""


class VoltageTests(BrainKit):
    """Cells act on each other by their voltages."""

    level = "accuracy"

    @pytest.mark.parametrize("driven", [0, 1])
    def test_a_gap_junction_carries_current_both_ways(self, driven: int) -> None:
        """The sum of the voltages does not depend on the junction; their difference decays faster by it."""
        sample = self._leaky_sample(ELECTRICAL)
        tau_ms, cm = sample.all_parameters["tau_m"], sample.all_parameters["cm"]
        weight = 0.5 * cm / tau_ms  # the difference is half of that without a junction
        current = DEPOLARISATION_MV * cm / tau_ms
        pair = cells(sample, "n", 2, i_offset=[current * (driven == 0), current * (driven == 1)])
        junction = connect("n", "n", weight, 0.0, pairs=[(0, 1)], kind=ELECTRICAL)
        for t_ms, (first, second) in self._above_rest(pair, junction).items():
            total = DEPOLARISATION_MV * (1.0 - exp(-t_ms / tau_ms))
            difference = DEPOLARISATION_MV / 2.0 * (1.0 - exp(-2.0 * t_ms / tau_ms))
            slack = DEPOLARISATION_MV * (PRECISION + 2.0 * self.tolerance_ms / tau_ms * exp(-t_ms / tau_ms))
            assert first + second == pytest.approx(total, abs=slack)
            assert (second - first if driven else first - second) == pytest.approx(difference, abs=slack)

    def _leaky_sample(self, kind: str) -> Sample:
        if kind not in self.capabilities.synapses or "v" not in self.capabilities.state_variables:
            skip_undeclared(f"{kind} synapses and state variable v")
        declared = [SAMPLES[name] for name in LEAKY if name in self.capabilities.cells]
        return declared[0] if declared else skip_undeclared("leaky cells")

    def _above_rest(self, pair: Population, synapse: Projection) -> dict[float, FloatArray]:
        """Return the voltages of two cells above rest, mV, by the time in ms."""
        brain = self.open(pair, synapse)
        rest = brain.read_state("v", [0, 1])
        found = {}
        for t_ms in (2, 5, 10, 20, 40):
            self.run(brain, t_ms)
            found[milliseconds(brain.now_ns)] = brain.read_state("v", [0, 1]) - rest
        return found
