"""STDP with PyNN's meaning, read from the jump that a synapse makes in the voltage."""

from math import exp

import numpy as np
import pytest
from golden import Golden
from nrp_core.brain import FixedFrequencySource
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

DELAY_MS, TAU_PLUS, TAU_MINUS, W_MAX = 1.0, 15.0, 25.0, 4.0


def pair(sim, weight_dependence="Additive", depression=0.1, **rule):
    """Build a cell that drives another; each fires once for each event of 100 mV."""
    cells = sim.Population(2, sim.IF_curr_delta(tau_m=1e9, cm=1.0, tau_refrac=0.1), label="cells")
    timing = sim.SpikePairRule(tau_plus=TAU_PLUS, tau_minus=TAU_MINUS, A_plus=0.1, A_minus=depression)
    dependence = getattr(sim, f"{weight_dependence}WeightDependence")(**{"w_min": 0.0, "w_max": W_MAX} | rule)
    stdp = sim.STDPMechanism(
        timing_dependence=timing, weight_dependence=dependence, weight=1.0, delay=DELAY_MS
    )
    sim.Projection(cells[0:1], cells[1:2], sim.AllToAllConnector(), stdp, label="plastic")


def weight_after(brain, pre_ms, post_ms):
    """Return the weight with which the second presynaptic spike arrives, at 30 ms or a little later."""
    for cell, t_ms in ((0, pre_ms), (1, post_ms), (0, 30.0)):
        source = FixedFrequencySource(
            rate=1000.0, weight=100.0, delay=0.1, start=t_ms - 1.1, duration=1.0 + 1e-6
        )
        brain.add_source(source, [cell], name=f"at {t_ms}")
    brain.run_until(round(30.5 * NS_PER_MS))
    before = brain.read_state("v", [1])[0]
    brain.run_until(32 * NS_PER_MS)
    return brain.read_state("v", [1])[0] - before


@pytest.mark.parametrize("weight_dependence", ["Additive", "Multiplicative"])
@pytest.mark.parametrize("lag_ms", [6.0, -6.0])
def test_a_pair_of_spikes_changes_the_weight_by_the_rule(weight_dependence, lag_ms, network, opened):
    pre_ms, post_ms = 15.0, 15.0 + lag_ms
    found = weight_after(opened(network(lambda sim: pair(sim, weight_dependence))), pre_ms, post_ms)
    free = weight_dependence == "Additive"
    weight = 1.0
    for presynaptic in (pre_ms, 30.0):
        lag = post_ms + DELAY_MS - presynaptic  # the delay is dendritic: the spike that goes back takes it
        if lag > 0:
            weight += 0.1 * (W_MAX if free else W_MAX - weight) * exp(-lag / TAU_PLUS)
    for presynaptic in (pre_ms, 30.0):
        lag = post_ms + DELAY_MS - presynaptic
        if lag < 0:
            weight -= 0.1 * (W_MAX if free else weight) * exp(lag / TAU_MINUS)
    assert found == pytest.approx(weight, abs=1e-6)


def test_a_lower_limit_is_refused(network, opened, golden: Golden):
    with golden.raises(CapabilityError, match="'plastic'"):
        opened(network(lambda sim: pair(sim, w_min=0.5)))


def test_a_rule_that_is_turned_round_is_refused(network, opened):
    with pytest.raises(CapabilityError, match=r"'plastic': A_minus.*NEST"):
        opened(network(lambda sim: pair(sim, depression=-0.1)))


def test_two_time_constants_on_one_cell_are_refused(network, opened):
    def build(sim):
        cells = sim.Population(2, sim.IF_curr_delta(), label="cells")
        for tau_minus in (20.0, 30.0):
            timing = sim.SpikePairRule(tau_minus=tau_minus)
            stdp = sim.STDPMechanism(
                timing_dependence=timing,
                weight_dependence=sim.AdditiveWeightDependence(),
                weight=1.0,
                delay=1.0,
            )
            sim.Projection(cells, cells, sim.OneToOneConnector(), stdp, label=f"tau {tau_minus:g}")

    with pytest.raises(CapabilityError, match=r"'tau 30': NEST.*tau_minus"):
        opened(network(build))


def test_a_source_cell_drives_a_plastic_synapse_one_step_late(network, opened):
    def build(sim):
        cells = sim.Population(1, sim.IF_curr_delta(tau_m=1e9), label="cells")
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0]))
        stdp = sim.STDPMechanism(
            timing_dependence=sim.SpikePairRule(), weight_dependence=sim.AdditiveWeightDependence(w_max=2.0),
            weight=1.0, delay=1.0,
        )  # fmt: skip
        sim.Projection(source, cells, sim.OneToOneConnector(), stdp)

    brain, values = opened(network(build)), []
    for t_ns in (6_000_000, 6_100_000):
        brain.run_until(t_ns)
        values.append(brain.read_state("v", [0])[0])
    assert np.diff(values) == pytest.approx(1.0)
