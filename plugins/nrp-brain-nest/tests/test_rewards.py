"""Rewards in NEST, with ``event`` beside it: the same weights, eligibility and dopamine."""

import numpy as np
import pytest
from golden import Golden
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

TAU_D = 200.0
NEST = {"tau_c": 1000.0, "tau_d": TAU_D, "w_max": 200.0, "shared": True, "eligibility_limits": False}
CASES = {
    "A": {"w": 1.46501140981572, "c": 0.216752311287261, "n": 4.34753100289775e-5},
    "B": {
        "pre": [10, 35, 60, 110, 300], "post": [20, 30, 62, 105, 299], "dopamine": [50, 55, 250, 400],
        "weight": 10.0, "baseline": 0.002, "w": 7.47861518390315, "c": -0.687427216185382,
        "n": 4.56412483442499e-4,
    },
    "D": {"delay": 5.0, "w": 1.38224506813347, "c": 0.178173051772904, "n": 4.34753100289775e-5},
    "M": {"sources": 3, "w": 2.39503422944717, "c": 0.216752311287261, "n": 1.30425930086933e-4},
}  # fmt: skip
"""Trains (ms), and the weight, eligibility and dopamine at 1 s in NEST 3.10.0 when it is driven by itself."""
SPIKING = {"tau_m": 10.0, "v_rest": 0.0, "v_reset": 0.0, "v_thresh": 100.0, "tau_refrac": 0.1}


def learner(
    sim, pre=(10,), post=(20,), dopamine=(50,), weight=1.0, delay=1.0, sources=1, baseline=0.0, a_plus=1.0,
    amount=1 / TAU_D, receptor="reward", stdp="excitatory", wide=1, cell="IF_curr_delta", **changed,
):  # fmt: skip
    """Build a synapse onto cells that fire at given times, and cells whose spikes reward it 1 ms later."""

    def spiking(label, times, n=1, kind="IF_curr_delta"):
        cells = sim.Population(n, getattr(sim, kind)(**SPIKING), label=label)
        drive = sim.Population(1, sim.SpikeSourceArray(spike_times=[float(t) - 1.0 for t in times]))
        kick = sim.StaticSynapse(weight=1000.0 if kind == "IF_curr_delta" else 1e4, delay=1.0)
        sim.Projection(drive, cells, sim.AllToAllConnector(), kick)
        return cells

    before, after = spiking("pre", pre), spiking("post", post, wide, cell)
    timing = sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=a_plus, A_minus=1.5)
    rule = sim.STDPMechanism(
        timing, sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0), weight=weight, delay=delay
    )
    sim.Projection(before, after, sim.AllToAllConnector(), rule, label="learned", receptor_type=stdp)
    times = [t + 1.0 - 0.1 for t in dopamine]  # the delay of synapses that reward is a step
    reward = sim.Neuromodulation(amount, **NEST | {"baseline": baseline} | changed)
    critic = spiking("critic", times, sources)
    sim.Projection(critic, after, sim.AllToAllConnector(), reward, receptor_type=receptor)


def state_of(brain):
    return [
        brain.read_weights("learned")[0],
        *(brain.read_synapse_state("learned", name)[0] for name in ("eligibility", "dopamine")),
    ]


@pytest.mark.parametrize("name", CASES)
def test_event_and_nest_are_equal_in_one_run(name, network, opened):
    case = dict(CASES[name])
    expected = [case.pop(one) for one in "wcn"]
    built = network(lambda sim: learner(sim, **case))
    for backend, options in (("nest", {}), ("event", {"resolution": "0.1 ms"}), ("event", {})):
        brain = opened(built, backend, **options)
        brain.run_until(1000 * NS_PER_MS)
        assert state_of(brain) == pytest.approx(expected, rel=1e-9), backend


def test_other_amounts_of_dopamine_and_units_of_weights(network, opened):
    """Ten cells with currents in nA share the dopamine of spikes that bring 0.03 each."""
    trains = {"pre": [10, 40, 90], "post": [20, 52, 80], "dopamine": [30, 60, 61]}
    built = network(
        lambda sim: learner(
            sim, **trains, amount=0.03, baseline=0.01, wide=10, cell="IF_curr_exp", weight=3.0
        )
    )
    found = []
    for backend in ("nest", "event"):
        brain = opened(built, backend, resolution="0.1 ms")
        for until in (70, 200, 400):
            brain.run_until(until * NS_PER_MS)
            found.append(state_of(brain))
        brain.set_weights("learned", 20.0)
        brain.run_until(500 * NS_PER_MS)
        found.append(state_of(brain))
        brain.reset()
        brain.run_until(400 * NS_PER_MS)
        assert state_of(brain) == found[-2]
    assert found[:4] == [pytest.approx(one, rel=1e-9) for one in found[4:]]
    assert abs(found[2][0] - 3.0) > 0.1


def test_rewards_from_outside_are_those_of_event(network, opened):
    trains = {"pre": [10, 40, 90], "post": [20, 52, 80], "dopamine": [30, 60]}
    built = network(lambda sim: learner(sim, **trains, amount=0.03, baseline=0.01, wide=2))
    found = []
    for backend in ("nest", "event"):
        brain = opened(built, backend, resolution="0.1 ms")
        for until, amount, held in ((45, 0.02, 0.0), (70, -0.05, 0.004), (95, 0.0, -0.01), (120, 0.1, 0.0)):
            brain.run_until(until * NS_PER_MS)
            brain.reward("learned", amount)
            brain.hold_reward("learned", held)
            found.append(state_of(brain)[:2])
        brain.run_until(400 * NS_PER_MS)
        found.append(state_of(brain))
        brain.reset()
        brain.run_until(45 * NS_PER_MS)
        assert state_of(brain)[:2] == found[-5]
    assert found[:5] == [pytest.approx(one, rel=1e-9) for one in found[5:]]


def test_rewards_come_when_all_synapses_are_updated(network, opened, golden: Golden):
    brain = opened(network(learner))
    brain.run_until(10 * NS_PER_MS + 100_000)
    for give in (brain.reward, brain.hold_reward):
        with golden.raises(CapabilityError):
            give("learned", 0.1)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"shared": False}, "shared=True"),
        ({"eligibility_limits": True}, "eligibility_limits=False"),
        ({"receptor": "punishment"}, "only add dopamine"),
        ({"sources": 2, "amount": np.array([[0.1], [0.2]])}, "0.1.*0.2"),
        ({"stdp": "inhibitory", "weight": -1.0}, "only excitatory synapses"),
        ({"a_plus": np.array([[1.0, 2.0]]), "wide": 2}, "one A_plus"),
    ],
)
def test_learning_that_nest_lacks_is_refused(settings, message, network, opened):
    with pytest.raises(CapabilityError, match=message):
        opened(network(lambda sim: learner(sim, **settings)))
