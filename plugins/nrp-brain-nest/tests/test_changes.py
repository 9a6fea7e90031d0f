"""Parameters and weights change in NEST while it runs, whatever order NEST keeps its synapses in."""

import numpy as np
import pytest
from golden import Golden
from nrp_core.brain import DCSource
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError


def voltage(brain, ms, neurons):
    brain.run_until(ms * NS_PER_MS)
    return brain.read_state("v", neurons)


def entangled(sim):
    """Build projections with several synapses between two cells, in an order that NEST does not keep."""
    cells = sim.Population(6, sim.IF_curr_exp(), label="cells")
    trains = [[5.0 + i / 2, 25.0] for i in range(6)]
    source = sim.Population(6, sim.SpikeSourceArray(spike_times=trains), label="source")
    rng = np.random.default_rng(3)
    for label, kind in (("first", sim.StaticSynapse), ("second", sim.StaticSynapse), ("tired", tired(sim))):
        ends, weights, delays = (
            rng.integers(0, 6, (2, 40)),
            rng.uniform(1e-3, 1e-2, 40),
            rng.integers(1, 4, 40),
        )
        rows = list(zip(*ends.tolist(), weights.tolist(), delays.tolist(), strict=True))
        sim.Projection(source, cells, sim.FromListConnector(rows), kind(), label=label)
    sim.Projection(source, cells, sim.AllToAllConnector(), plastic(sim), label="plastic")


def tired(sim):
    return lambda: sim.TsodyksMarkramSynapse(U=0.5, tau_rec=100.0, tau_facil=0.0)


def plastic(sim):
    return sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(A_plus=0.1, A_minus=0.1),
        weight_dependence=sim.AdditiveWeightDependence(w_max=3.0), weight=1e-3, delay=1.0,
    )  # fmt: skip


@pytest.mark.parametrize("label", ["first", "second", "tired", "plastic"])
def test_weights_are_those_of_the_network_before_and_after_a_change(label, network, opened):
    made = network(entangled)
    brain = opened(made)
    given = {p.label: p.weight for p in made.projections}
    for name, weights in given.items():
        np.testing.assert_allclose(brain.read_weights(name), weights, rtol=1e-12)
    brain.run_until(10 * NS_PER_MS)
    new = np.random.default_rng(5).uniform(0.1, 2.0, given[label].size)
    brain.set_weights(label, new)
    for name, weights in given.items():
        if name != "plastic" or label == "plastic":
            np.testing.assert_allclose(
                brain.read_weights(name), new if name == label else weights, rtol=1e-12
            )
    brain.reset()
    np.testing.assert_allclose(brain.read_weights(label), given[label], rtol=1e-12)


@pytest.mark.parametrize("label", ["first", "second", "tired"])
def test_each_synapse_gets_the_weight_that_is_meant_for_it(label, network, opened):
    made, values = network(entangled), []
    for backend in ("event", "nest"):
        brain = opened(made, backend)
        brain.set_weights("plastic", 0.0)  # their spikes are a step late in NEST
        unchanged = brain.read_weights(label)
        brain.run_until(20 * NS_PER_MS)
        brain.set_weights(label, unchanged[::-1])
        values.append(voltage(brain, 35, range(6)))
        brain.close()
    assert np.ptp(values[0]) > 0.01
    np.testing.assert_allclose(values[1], values[0], rtol=0, atol=1e-6)


def test_parameters_change_beside_a_current(network, opened):
    made = network(lambda sim: sim.Population(3, sim.IF_cond_exp(i_offset=0.1), label="cells"))
    values = []
    for backend in ("event", "nest"):
        brain = opened(made, backend)
        electrode = brain.add_source(DCSource(amplitude=0.2), [0, 1], name="electrode")
        brain.run_until(10 * NS_PER_MS)
        brain.set_parameters([1, 2], {"i_offset": [0.15, 0.05], "tau_m": 10.0})
        brain.set_parameters([0], {"cm": 2.0})
        values.append(voltage(brain, 20, [0, 1, 2]))
        brain.remove(electrode)
        values.append(voltage(brain, 40, [0, 1, 2]))
        brain.close()
    np.testing.assert_allclose(values[2:], values[:2], atol=1e-3)


def test_a_change_that_nest_refuses_changes_nothing(network, opened, golden: Golden):
    brain = opened(network(lambda sim: sim.Population(1, sim.IF_curr_exp(i_offset=0.5), label="cells")))
    with golden.raises(NetworkError, match="'cells'"):
        brain.set_parameters([0], {"v_reset": -40.0})
    brain.set_parameters([0], {"i_offset": 0.0})
    assert voltage(brain, 50, [0])[0] == -65.0


def test_receptors_stay_as_different_as_they_were(network, opened):
    brain = opened(network(lambda sim: sim.Population(2, sim.IF_curr_exp(), label="cells")))
    with pytest.raises(CapabilityError, match=r"'cells': NEST.*sign"):
        brain.set_parameters([1], {"tau_syn_E": 3.0})
    brain.set_parameters([1], {"tau_syn_E": 3.0, "tau_syn_I": 3.0})
