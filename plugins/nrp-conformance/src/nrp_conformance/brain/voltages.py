"""Synapses that transmit voltages, against closed forms of the voltages of leaky cells."""

from __future__ import annotations

from math import exp

import pytest

from nrp_conformance.base import skip_undeclared
from nrp_conformance.brain.kit import SAMPLES, BrainKit, Sample, cells, connect
from nrp_core.clock import milliseconds
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import ELECTRICAL, GRADED, RECTIFIED
from nrp_core.world import FloatArray

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

    @pytest.mark.parametrize("kind", [GRADED, RECTIFIED])
    @pytest.mark.parametrize("receptor", ["excitatory", "inhibitory"])
    def test_graded_release_follows_the_voltage_of_its_source(self, kind: str, receptor: str) -> None:
        """The source rests, so a constant current or conductance acts on the target."""
        sample = self._leaky_sample(kind)
        if sample.cell_type == "IF_curr_delta":
            skip_undeclared("leaky cells with currents or conductances")
        values = sample.all_parameters
        tau_ms, leak, rest = values["tau_m"], values["cm"] / values["tau_m"], values["v_rest"]
        share = {GRADED: 1.0 / (1.0 + exp(-2.0)), RECTIFIED: 2.0}[kind]
        v_th, slope = rest - 6.0, 3.0
        if sample.inhibitory_sign == 1:
            weight, reversal = 0.1 * leak, values["e_rev_E" if receptor == "excitatory" else "e_rev_I"] - rest
            faster = 1.0 + share * weight / leak
            settled = share * weight / leak * reversal / faster
        else:
            weight, faster = (0.2 if receptor == "excitatory" else -0.2) * DEPOLARISATION_MV * leak, 1.0
            settled = share * weight / leak
        release = connect(
            "n", "n", weight, 0.0, pairs=[(0, 1)], receptor=receptor, kind=kind, v_th=v_th, slope=slope,
            tau_s=0.0,
        )  # fmt: skip
        for t_ms, (first, second) in self._above_rest(cells(sample, "n", 2), release).items():
            expected = settled * (1.0 - exp(-t_ms * faster / tau_ms))
            slack = abs(settled) * (
                PRECISION + 2.0 * self.tolerance_ms * faster / tau_ms * exp(-t_ms / tau_ms)
            )
            assert first == pytest.approx(0.0, abs=slack)
            assert second == pytest.approx(expected, abs=slack)

    def _leaky_sample(self, kind: str) -> Sample:
        self.require_declared(synapses=kind)
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
