"""Parameters and weights change while a simulator runs, whatever order it keeps synapses in."""

import numpy as np
import pytest
from nrp_brain_event import EventBackend
from nrp_core.brain import DCSource
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

N = 30
KINDS = ("static", "tired")


def entangled(sim):
    """Build projections with several synapses between two cells, in an order that no simulator keeps."""
    cells = sim.Population(4, sim.IF_curr_alpha(), label="cells")
    trains = [[5.0 + 2 * i, 25.0 + 2 * i] for i in range(4)]
    source = sim.Population(4, sim.SpikeSourceArray(spike_times=trains), label="source")
    rng = np.random.default_rng(3)
    tired = sim.TsodyksMarkramSynapse(U=0.5, tau_rec=100.0, tau_facil=0.0)
    for label, kind in zip(KINDS, (sim.StaticSynapse(), tired), strict=True):
        ends, weights, delays = rng.integers(0, 4, (2, N)), rng.uniform(1e-3, 1e-2, N), rng.integers(1, 4, N)
        rows = list(zip(*ends.tolist(), weights.tolist(), delays.tolist(), strict=True))
        sim.Projection(source, cells, sim.FromListConnector(rows), kind, label=label)


@pytest.mark.parametrize("label", KINDS)
def test_each_synapse_gets_the_weight_that_is_meant_for_it(label, simulator, network, opened):
    made, values = network(entangled), []
    (given,) = (projection.weight for projection in made.projections if projection.label == label)
    for backend in (EventBackend(), None):
        brain = opened(made, simulator if backend is None else None, backend)
        np.testing.assert_allclose(brain.read_weights(label), given, rtol=1e-9)
        brain.run_until(20 * NS_PER_MS)
        brain.set_weights(label, given[::-1])
        np.testing.assert_allclose(brain.read_weights(label), given[::-1], rtol=1e-9)
        brain.run_until(35 * NS_PER_MS)
        values.append(brain.read_state("v", range(4)))
        brain.reset()
        np.testing.assert_allclose(brain.read_weights(label), given, rtol=1e-9)
        brain.close()
    change = np.ptp(values[0])
    assert change > 0.01
    np.testing.assert_allclose(values[1], values[0], rtol=0, atol=0.01 * change)


def test_parameters_change_beside_a_current(simulator, network, opened):
    made, values = network(lambda sim: sim.Population(3, sim.IF_cond_exp(i_offset=0.1), label="cells")), []
    for backend in (EventBackend(), None):
        brain = opened(made, simulator if backend is None else None, backend)
        electrode = brain.add_source(DCSource(amplitude=0.2), [0, 1], name="electrode")
        brain.run_until(10 * NS_PER_MS)
        brain.set_parameters([1, 2], {"i_offset": [0.15, 0.05], "tau_m": 10.0})
        brain.set_parameters([0], {"cm": 2.0})
        brain.run_until(20 * NS_PER_MS)
        values.append(brain.read_state("v", [0, 1, 2]))
        brain.remove(electrode)
        brain.run_until(40 * NS_PER_MS)
        values.append(brain.read_state("v", [0, 1, 2]))
        brain.close()
    np.testing.assert_allclose(values[2:], values[:2], rtol=0, atol=0.03)


def test_the_threshold_of_a_cell_changes(simulator, network, opened):
    brain = opened(
        network(lambda sim: sim.Population(2, sim.IF_curr_exp(i_offset=1.0), label="cells")), simulator
    )
    brain.set_parameters([1], {"v_thresh": -40.0})
    brain.run_until(200 * NS_PER_MS)
    assert brain.read_state("v", [0])[0] < -50.0
    assert -50.0 < brain.read_state("v", [1])[0] < -44.0


def test_target_traces_that_synapses_store_cannot_change(simulator, network, opened):
    brain = opened(network(entangled), simulator)
    with pytest.raises(CapabilityError, match=r"tau_syn_E.*'tired'"):
        brain.set_parameters([0], {"tau_syn_E": 3.0})
