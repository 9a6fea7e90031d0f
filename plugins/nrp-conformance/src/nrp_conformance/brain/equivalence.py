"""Accuracy: two equivalent networks behave equally in one brain, so that the errors of its grid cancel.

The potentials of both may differ by a thousandth of the largest change, for limited numerical precision.
"""

from __future__ import annotations

from dataclasses import replace
from math import e, exp

import pytest

from nrp_conformance.base import skip_undeclared
from nrp_conformance.brain.accuracy import EXACT_MV, GRID_PRECISION, released
from nrp_conformance.brain.kit import SAMPLES, BrainKit, cells, connect, spikes, truncated_ms
from nrp_conformance.brain.reference import simulate
from nrp_core.brain import Brain, SpikeInjector
from nrp_core.clock import milliseconds
from nrp_core.network.synapses import TSODYKS_MARKRAM

TWIN_PRECISION = 1e-3
"""The allowed difference of twins, as a share of their largest change."""
ADAPTING = [
    ("EIF_cond_exp_isfa_ista", "w", 0.3), ("EIF_cond_alpha_isfa_ista", "w", 0.3), ("Izhikevich", "u", 0.002),
]  # fmt: skip
"""Cells with a variable of recovery, and a current at which they do not fire, nA."""


class EquivalenceTests(BrainKit):
    """The same effect in two ways."""

    level = "accuracy"

    @pytest.mark.parametrize("at_least_ms", [1.0, 8.0])
    def test_nothing_acts_before_its_delay(self, at_least_ms: float) -> None:
        """When a spike is due, its cell is still like one without a synapse."""
        self.require_declared()
        delay = round(truncated_ms(max(self.tolerance_ms, 0.1), 10.0 + at_least_ms) - 10.0, 6)
        brain = self.open(
            spikes("s", [10.0]), self.cells("n", 2), connect("s", "n", self.sample.strong, delay)
        )
        jumps = "tau_syn_E" not in self.sample.all_parameters  # and may do so at that very time
        self.run(brain, 10.0 + delay - (self.tolerance_ms if jumps else 0.0))
        assert milliseconds(brain.now_ns) <= 10.0 + delay
        due, free = brain.read_state("v", [1, 2])
        assert due == pytest.approx(free, abs=EXACT_MV)
        self.run(brain, 13.0 + delay)
        due, free = brain.read_state("v", [1, 2])
        assert abs(due - free) > 100 * EXACT_MV, "the synapse had no effect"

    def test_projections_between_the_same_cells_keep_their_delays_and_receptors(self) -> None:
        """The twin gets the same from three sources."""
        self.require_declared()
        weak = self.sample.weak
        kinds = [
            (weak, 2.0, "excitatory"),
            (2 * weak, 9.0, "excitatory"),
            (3 * weak * self.sample.inhibitory_sign, 15.0, "inhibitory"),
        ]
        synapses = [
            replace(
                connect(pre, "n", weight, delay, pairs=[(k, cell)], receptor=receptor), label=f"{pre} {i}"
            )
            for i, (weight, delay, receptor) in enumerate(kinds)
            for pre, k, cell in (("s", 0, 0), ("t", i, 1))
        ]
        brain = self.open(spikes("s", [5.0]), spikes("t", *[[5.0]] * 3), self.cells("n", 2), *synapses)
        self._check_equivalent(brain, [4, 5], 40)

    @pytest.mark.parametrize("facilitation", [0.0, 40.0])
    def test_a_short_term_synapse_acts_like_static_ones_of_its_released_weights(
        self, facilitation: float
    ) -> None:
        """The times between its spikes are like its time constants, so that those matter most."""
        self.require_declared()
        if TSODYKS_MARKRAM not in self.capabilities.synapses:
            skip_undeclared("tsodyks_markram synapses")
        emitted, weight = [5.0, 35.0, 50.0, 80.0, 120.0], 3 * self.sample.weak
        tau_psc = self.sample.all_parameters.get("tau_syn_E", 0.0)
        shares = released(emitted, 0.4, 40.0, facilitation, tau_psc)
        brain = self.open(
            spikes("s", emitted), spikes("t", *[[t] for t in emitted]), self.cells("n", 2),
            connect("s", "n", weight, 1.0, kind=TSODYKS_MARKRAM, U=0.4, tau_rec=40.0, tau_facil=facilitation),
            connect("t", "n", [weight * share for share in shares], 1.0, pairs=[(k, 1) for k in range(5)]),
        )  # fmt: skip
        self._check_equivalent(brain, [6, 7], 140)

    @pytest.mark.parametrize("receptor", ["excitatory", "inhibitory"])
    def test_an_injected_spike_acts_like_a_spike_of_a_source(self, receptor: str) -> None:
        self.require_declared()
        weight = 3 * self.sample.weak * (1 if receptor == "excitatory" else self.sample.inhibitory_sign)
        brain = self.open(
            spikes("s", [10.0]), self.cells("n", 2), connect("s", "n", weight, 2.0, receptor=receptor)
        )
        port = brain.add_source(SpikeInjector(weight, 2.0, receptor), [2], name="injector")
        self.run(brain, 10)
        port.inject_spikes([0])  # type: ignore[attr-defined]
        self._check_equivalent(brain, [1, 2], 30)

    @pytest.mark.parametrize("cell_type", ["IF_cond_exp", "IF_cond_alpha"])
    @pytest.mark.parametrize("receptor", ["excitatory", "inhibitory"])
    def test_a_conductance_has_the_time_course_of_its_synapse(self, cell_type: str, receptor: str) -> None:
        variable = f"gsyn_{receptor[:3]}"
        self.require_declared(state=variable)
        if cell_type not in self.capabilities.cells:
            skip_undeclared(f"cells {cell_type}")
        sample = SAMPLES[cell_type]
        tau = sample.all_parameters[f"tau_syn_{receptor[0].upper()}"]
        brain = self.open(
            spikes("s", [5.0]), cells(sample, "n"), connect("s", "n", sample.weak, 2.0, receptor=receptor)
        )

        def conductance(t_ms: float) -> float:
            since = max(0.0, t_ms - 7.0) / tau
            share = e * since * exp(-since) if "alpha" in cell_type else exp(-since) * (t_ms >= 7.0)
            return sample.weak * share

        for t_ms in range(9, 20):
            self.run(brain, t_ms)
            now, off = milliseconds(brain.now_ns), 2 * self.tolerance_ms
            near = [conductance(now + k * off / 4) for k in range(-4, 5)]
            allowed = GRID_PRECISION * sample.weak + max(near) - min(near)
            assert brain.read_state(variable, [1])[0] == pytest.approx(conductance(now), abs=allowed)

    @pytest.mark.parametrize(("cell_type", "variable", "current"), ADAPTING)
    def test_a_recovery_variable_follows_its_equation(
        self, cell_type: str, variable: str, current: float
    ) -> None:
        self.require_declared(state=variable)
        if cell_type not in self.capabilities.cells:
            skip_undeclared(f"cells {cell_type}")
        if cell_type in self.capabilities.approximate:
            skip_undeclared(f"exact values of {cell_type}")
        sample = SAMPLES[cell_type]
        expected = simulate(sample, until_ms=62, i_offset=current)
        assert not expected.spikes
        course = replace(expected, voltages=expected.recoveries)
        brain = self.open(cells(sample, "n", i_offset=current))
        for t_ms in range(5, 60, 5):
            self.run(brain, t_ms)
            now = milliseconds(brain.now_ns)
            allowed = GRID_PRECISION * course.change(0.0, 60) + course.change(now, 2 * self.tolerance_ms)
            assert brain.read_state(variable, [0])[0] == pytest.approx(course.voltage(now), abs=allowed)

    def _check_equivalent(self, brain: Brain, twins: list[int], until_ms: int) -> None:
        """Check that the potentials of two cells agree at every millisecond from now on."""
        rest, largest, apart = float(brain.read_state("v", twins)[0]), 0.0, 0.0
        for t_ms in range(round(milliseconds(brain.now_ns)) + 1, until_ms):
            self.run(brain, t_ms)
            one, other = brain.read_state("v", twins).tolist()
            largest, apart = max(largest, abs(other - rest)), max(apart, abs(one - other))
        self.note("difference_mv", apart)
        assert largest > 0.0, "the synapses had no effect"
        assert apart <= TWIN_PRECISION * largest
