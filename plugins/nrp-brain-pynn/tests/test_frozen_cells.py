"""The event brain emits the spikes of Brian2, which runs the published equations of the fly brain."""

from dataclasses import replace

import numpy as np
import pytest
from nrp_brain_event import EventBackend
from nrp_core import Network, Population, Projection
from nrp_core.brain import SpikeRecorder
from nrp_experiments.fly.twin import twin

from nrp_brain_pynn.loading import quietly

N, N_SYNAPSES = 4000, 240_000
DURATION_MS, DELAY_MS, STEP_MS = 1000.0, 1.8, 0.1
UNIT_MV = 0.275
KICK_MV = 20_000.0
"""An input from which a cell fires in the next step."""
LIF = {
    "v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_m": 20.0, "cm": 0.02, "tau_refrac": 2.2,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "i_offset": 0.0,
}  # fmt: skip
EQUATIONS = """
dv/dt = (g - (v - v_0))/t_mbr : volt (unless refractory)
dg/dt = -g/tau : volt (unless refractory)
rfc : second
"""


def graph(rng):
    """Return source, target and weight (mV) of synapses; some cells have many, and a third are inhibitory."""
    share = rng.lognormal(0.0, 1.0, N)
    pre = rng.choice(N, N_SYNAPSES, p=share / share.sum())
    post = rng.choice(N, N_SYNAPSES, p=share / share.sum())
    sign = np.where(rng.random(N) < 0.35, -1.0, 1.0)
    weight = sign[pre] * UNIT_MV * (1 + rng.geometric(0.16, N_SYNAPSES))
    return pre, post, weight.astype(np.float32).astype(float)  # the precision of the grid's tables


def fly():
    """Return the same of the synthetic brain of the fly; its first cells taste sugar."""
    parts = [(one.pre_index, one.post_index, one.weight) for one in twin(N, 783).projections]
    return tuple(map(np.concatenate, zip(*parts, strict=True)))


def kicks(rng, n_driven, rate_hz):
    """Return steps and cells of the input, sorted."""
    steps = [np.sort(rng.choice(9900, rng.poisson(rate_hz), replace=False)) + 1 for _ in range(n_driven)]
    cells = np.repeat(np.arange(n_driven), [len(own) for own in steps])
    return np.concatenate(steps), cells


def network(pre, post, weight, steps, cells):
    n_driven, refractory = cells.max() + 1, np.full(N, LIF["tau_refrac"])
    refractory[:n_driven] = 0.0  # as published
    full = {name: np.full(N, value) for name, value in LIF.items()} | {"tau_refrac": refractory}
    trains = tuple(steps[cells == cell] * STEP_MS for cell in range(n_driven))
    populations = {
        "brain": Population("brain", N, "IF_curr_exp_frozen", full, {"v": full["v_rest"]}),
        "kicks": Population("kicks", n_driven, "SpikeSourceArray", {}, spike_times_ms=trains),
    }
    own = np.arange(n_driven)
    kick, at_once = np.full(n_driven, KICK_MV), np.full(n_driven, STEP_MS)
    projections = [Projection("kick", "kicks", "brain", "excitatory", own, own, kick, at_once)]
    for receptor, mine in (("excitatory", weight > 0), ("inhibitory", weight < 0)):
        delay = np.full(mine.sum(), DELAY_MS)
        projections.append(
            Projection(receptor, "brain", "brain", receptor, pre[mine], post[mine], weight[mine], delay)
        )
    return Network(populations, tuple(projections))


def spikes_of_brian2(pre, post, weight, steps, cells):
    """Return steps and cells of all spikes; a step of Brian2 begins at the time that it has."""
    import brian2 as b2

    b2.prefs.codegen.target = "numpy"  # nothing to compile
    b2.defaultclock.dt = STEP_MS * b2.ms
    n_driven = cells.max() + 1
    names = {
        "v_0": -52 * b2.mV,
        "v_rst": -52 * b2.mV,
        "v_th": -45 * b2.mV,
        "t_mbr": 20 * b2.ms,
        "tau": 5 * b2.ms,
    }
    neurons = b2.NeuronGroup(
        N, EQUATIONS, method="linear", threshold="v > v_th", reset="v = v_rst; g = 0*mV",
        refractory="rfc", namespace=names,
    )  # fmt: skip
    neurons.v = -52 * b2.mV
    neurons.rfc = LIF["tau_refrac"] * b2.ms
    neurons.rfc[:n_driven] = 0 * b2.ms
    synapses = b2.Synapses(neurons, neurons, "w : volt", on_pre="g += w", delay=DELAY_MS * b2.ms)
    synapses.connect(i=pre, j=post)
    synapses.w = weight * b2.mV
    source = b2.SpikeGeneratorGroup(n_driven, cells, steps * STEP_MS * b2.ms)
    kick = b2.Synapses(source, neurons, on_pre="g += 20000*mV")
    kick.connect(i=np.arange(n_driven), j=np.arange(n_driven))
    monitor = b2.SpikeMonitor(neurons)
    b2.Network(neurons, synapses, source, kick, monitor).run(DURATION_MS * b2.ms)
    return np.rint(monitor.t / b2.ms / STEP_MS).astype(int), np.asarray(monitor.i)


def spikes_of_event(made, **options):
    backend = EventBackend()
    with backend.open(made, seed=1, options=backend.options(**options)) as brain:
        recorder = brain.add_sink(SpikeRecorder(), made.neurons("brain"), name="all")
        brain.run_until(round(DURATION_MS * 1e6))
        found = recorder.spikes()
    return found.times_ms, found.neurons


def ordered(steps, cells):
    order = np.lexsort((cells, steps))
    return np.stack([steps[order], cells[order]])


def on_grid(made, **options):
    """Return the spikes of the event brain by the beginning of the step, as in Brian2."""
    times, cells = spikes_of_event(made, resolution="0.1 ms", **options)
    return ordered(np.rint(times / STEP_MS).astype(int) - 1, cells)


@pytest.mark.simulator("brian2")
@pytest.mark.parametrize(
    ("wiring", "n_driven", "rate_hz", "least", "others"),
    [("random", 200, 100, 24_000, 4000), ("fly", 40, 150, 17_000, 11_000)],
)
def test_spikes_of_the_whole_brain_model_are_those_of_brian2(wiring, n_driven, rate_hz, least, others):
    rng = np.random.default_rng(783)
    synapses = graph(rng) if wiring == "random" else fly()
    given = kicks(rng, n_driven, rate_hz)
    with quietly():
        expected = ordered(*spikes_of_brian2(*synapses, *given))
    assert expected.shape[1] > least
    assert (expected[1] >= n_driven).sum() > others
    made = network(*synapses, *given)
    np.testing.assert_array_equal(on_grid(made), expected)
    _, exact = spikes_of_event(made)  # kicks in the step of a spike are lost on the grid only
    assert len(exact) == pytest.approx(expected.shape[1], rel=0.05)
    assert len(exact) > expected.shape[1]
    brain = made.populations["brain"]
    late = dict(brain.parameters) | {"tau_refrac": np.where(np.arange(N) < n_driven, 0.0, 2.3)}
    changed = {**made.populations, "brain": replace(brain, parameters=late)}
    assert on_grid(replace(made, populations=changed)).shape != expected.shape
