"""State of synapses in equations, read while they run, and weights that follow dopamine by an equation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import exp
from typing import Any

import pytest
from golden import Golden
from nrp_brain_event.backend import EventBackend

from nrp_core.brain import builder
from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Network

MS = 1_000_000
MODES = pytest.mark.parametrize(
    "options", [{}, {"resolution": "0.1 ms"}, {"resolution": "0.1 ms", "lazy": "always"}],
    ids=["exact", "grid", "lazy"],
)  # fmt: skip
Open = Callable[..., Brain]


@pytest.fixture
def opened() -> Iterator[Open]:
    """Open networks on ``event``."""
    brains: list[Brain] = []

    def open_(network: Network, options: dict[str, Any]) -> Brain:
        backend = EventBackend()
        brains.append(backend.open(network, seed=1, options=backend.options(**options)))
        return brains[-1]

    yield open_
    for brain in brains:
        brain.close()


def cells_that_fire(sim: Any, label: str, times: list[float], n: int = 1) -> Any:
    """Return cells that fire at given times, ms."""
    cell = sim.IF_curr_delta(tau_m=10.0, v_rest=0.0, v_reset=0.0, v_thresh=100.0, tau_refrac=0.0)
    cells = sim.Population(n, cell, label=label)
    drive = sim.Population(1, sim.SpikeSourceArray(spike_times=[t - 1.0 for t in times]))
    sim.Projection(drive, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=1000.0, delay=1.0))
    return cells


def pair_law(sim: Any, text: str = "", on_pre: str = "", on_post: str = "", **settings: Any) -> Any:
    traces = "dpre/dt = -pre/tau : 1\ndpost/dt = -post/tau : 1\n"
    parameters = {"tau": "20 ms"} | settings.pop("parameters", {})
    return sim.EquationSynapse(
        traces + text,
        on_pre=f"{on_pre}pre += 1",
        on_post=f"{on_post}post += 1",
        parameters=parameters,
        **settings,
    )


@MODES
def test_variables_of_plastic_synapses_are_read_at_any_time(
    opened: Open, options: dict[str, str], golden: Golden
) -> None:
    """The trace of the target begins after the delay of 3 ms; reading changes nothing."""
    sim = builder()
    law = pair_law(sim, on_post="weight += 0.1*pre; ")(weight=1.0, delay=3.0)
    pre, post = [10.0, 26.0], [15.0, 40.0]
    ends = cells_that_fire(sim, "a", pre), cells_that_fire(sim, "b", post)
    sim.Projection(*ends, sim.AllToAllConnector(), law, label="learned")
    brain, again = (opened(sim.network(), options) for _ in range(2))
    for until in (9, 16, 18, 30, 42, 43, 60):
        brain.run_until(until * MS)
        found = [brain.read_synapse_state("learned", name)[0] for name in ("pre", "post")]
        trains = pre, [t + 3.0 for t in post]
        expected = [sum(exp((t - until) / 20) for t in train if t <= until) for train in trains]
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-300)
    again.run_until(60 * MS)
    assert brain.read_weights("learned") == again.read_weights("learned") > 1.05
    with golden.raises(NetworkError, match="'prae'"):
        brain.read_synapse_state("learned", "prae")


@MODES
def test_variables_of_a_share_are_read_at_any_time(opened: Open, options: dict[str, str]) -> None:
    """They change when spikes are emitted, also if these are still on their way."""
    sim = builder()
    law = sim.EquationSynapse(
        "dD/dt = (g - D)/tau : nA", on_pre="share = D/g; D *= 0.5", parameters={"tau": "50 ms", "g": "2 nA"},
        initial={"D": "2 nA"},
    )  # fmt: skip
    spikes = [10.0, 30.0]
    source = sim.Population(2, sim.SpikeSourceArray(spike_times=[spikes, []]), label="a")
    target = sim.Population(3, sim.IF_curr_exp(), label="b")
    tm = sim.TsodyksMarkramSynapse(weight=0.1, delay=2.0)
    sim.Projection(source, target, sim.AllToAllConnector(), tm, label="other")
    synapse = law(weight=0.1, delay=4.0)
    projection = sim.Projection(source, target, sim.AllToAllConnector(), synapse, label="tired")
    assert projection.get("D", format="list", with_address=False) == [2.0] * 6
    brain = opened(sim.network(), options)
    for until in (5, 12, 20, 31, 60):
        brain.run_until(until * MS)
        level, last = 2.0, 0.0
        for t in [t for t in spikes if t <= until]:
            level, last = 0.5 * (2.0 + (level - 2.0) * exp((last - t) / 50)), t
        expected = 2.0 + (level - 2.0) * exp((last - until) / 50)
        found = brain.read_synapse_state("tired", "D")
        sources = sim.network().projections[-1].pre_index
        assert found == pytest.approx([2.0 if source else expected for source in sources], rel=1e-12)


SHORT = [10.0], [20.0], [50.9]
LONG = [10.0, 35.0, 60.0, 110.0, 300.5], [20.0, 30.0, 62.0, 105.0, 299.0], [50.9, 55.9, 250.9, 400.9]
"""When source, target and critic fire, ms; rewards come 0.1 ms later. Spikes do not meet at the synapse."""


def learner(
    sim: Any, *, own: bool, trains: Any = LONG, tau_c: float = 1000.0, brings: bool = True, w0: float = 10.0,
    **changed: Any,
) -> Network:  # fmt: skip
    """Return a network whose synapses learn by NEST's rule, as a class of PyNN's or in equations."""
    before, after = (cells_that_fire(sim, *of, 2) for of in zip("ab", trains[:2], strict=True))
    critic = cells_that_fire(sim, "critic", trains[2])
    if own:
        law = pair_law(
            sim, "dc/dt = -c/tau_c : mV\ndweight/dt = c*dopamine : mV", "c -= 1.5*change*post; ",
            "c += change*pre; ", weight_unit="mV", parameters={"tau_c": f"{tau_c} ms", "change": "1 mV"},
        )(weight=w0, delay=1.0)  # fmt: skip
    else:
        timing = sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=1.0, A_minus=1.5)
        weights = sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0)
        law = sim.STDPMechanism(timing, weights, weight=w0, delay=1.0)
    sim.Projection(before, after, sim.AllToAllConnector(), law, label="learned")
    nest = {"w_max": 200.0, "shared": True, "eligibility_limits": False}
    if brings:
        reward = sim.Neuromodulation(1 / 200, **nest | changed)
        sim.Projection(critic, after, sim.AllToAllConnector(), reward, receptor_type="reward")
    return sim.network()


@MODES
def test_weights_that_follow_dopamine_are_those_of_nest(opened: Open, options: dict[str, str]) -> None:
    """The numbers are of NEST 3.10.0."""
    brain = opened(learner(builder(), own=True, trains=SHORT, w0=1.0), options)
    brain.run_until(1000 * MS)
    assert brain.read_weights("learned") == pytest.approx([1.46501140981572] * 4, rel=1e-9)
    for name, value in (("c", 0.216752311287261), ("dopamine", 4.34753100289775e-5)):
        assert brain.read_synapse_state("learned", name) == pytest.approx([value] * 4, rel=1e-9)


@MODES
@pytest.mark.parametrize("w_max", [200.0, 10.3])
def test_they_are_those_of_the_built_in_rule(opened: Open, options: dict[str, str], w_max: float) -> None:
    """With rewards from outside, limits, a snapshot, and without learning for a time."""
    changed = {"w_max": w_max, "baseline": 0.002}
    brain, twin = (opened(learner(builder(), own=own, **changed), options) for own in (True, False))
    weights = []
    for one in (brain, twin):
        one.run_until(500 * MS)
        one.reward("learned", 0.01)
        one.hold_reward("learned", -0.004)
        one.run_until(520 * MS)
        weights.append(one.read_weights("learned").tolist())
        saved = one.snapshot()
        one.reset()
        one.run_until(70 * MS)
        weights.append(one.read_weights("learned").tolist())
        one.restore(saved)
        one.run_until(600 * MS)
        one.set_plastic("learned", False)
        one.run_until(700 * MS)
        one.set_plastic("learned", True)
        one.run_until(900 * MS)
        weights.append(one.read_weights("learned").tolist())
    assert weights[:3] == [pytest.approx(one, rel=1e-9) for one in weights[3:]]
    assert len({one[0] for one in weights[:3]}) == 3


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"tau_c": 500.0}, "'c'.*500.*tau_c.*'b'.*1000"),
        ({"brings": False}, "'b'.*shared=True"),
        ({"shared": False}, "'b'.*shared=True"),
    ],
)
def test_dopamine_that_does_not_fit_is_refused(
    opened: Open, settings: dict[str, Any], message: str, golden: Golden
) -> None:
    with golden.raises(CapabilityError, match=message):
        opened(learner(builder(), own=True, **settings), {})


@pytest.mark.parametrize(
    ("equations", "message"),
    [
        ("dweight/dt = 2*dopamine : 1", "'dopamine'"),
        ("dweight/dt = pre/dopamine : 1", "'dopamine'"),
        ("dweight/dt = pre*post : 1", "'dopamine'"),
        ("dweight/dt = pre*dopamine*dopamine : 1", "'dopamine'"),
        ("dx/dt = (1 - x)/tau : 1\ndweight/dt = x*dopamine : 1", "'x'"),
        ("dx/dt = 0/second : 1\ndweight/dt = x*dopamine : 1", "'x'"),
        ("dweight/dt = pre*dopamine : 1\ndweight/dt = post*dopamine : 1", "'weight'"),
        ("dweight/dt = pre*dopamine : nA", "'weight'"),
    ],
)
def test_other_equations_of_the_weight_are_refused(equations: str, message: str, golden: Golden) -> None:
    with golden.raises(NetworkError, match=message):
        pair_law(builder(), equations)


@MODES
def test_parameters_of_plastic_synapses_change_while_they_run(
    opened: Open, options: dict[str, str], golden: Golden
) -> None:
    """Traces have decayed with the old time constant until then; snapshots and resets restore the values."""
    sim = builder()
    law = pair_law(sim, on_post="weight += change*pre; ", parameters={"change": 0.1})(weight=1.0, delay=2.0)
    ends = cells_that_fire(sim, "a", [10.0, 50.0], 2), cells_that_fire(sim, "b", [20.0, 60.0])
    sim.Projection(*ends, sim.AllToAllConnector(), law, label="learned")
    brain = opened(sim.network(), options)

    def learned() -> list[float]:
        brain.run_until(40 * MS)
        brain.set_synapse_parameters("learned", {"tau": 5.0, "change": [-0.2, -0.2]})
        saved = brain.snapshot()
        weights = []
        for _ in range(2):
            brain.run_until(55 * MS)
            weights.append(float(brain.read_synapse_state("learned", "pre")[0]))
            brain.set_synapse_parameters("learned", {"change": 0.3})
            brain.run_until(80 * MS)
            weights.append(float(brain.read_weights("learned")[1]))
            brain.restore(saved)
        assert weights[:2] == weights[2:]
        return weights[:2]

    found = learned()
    left = exp(-30 / 20) * exp(-10 / 5)
    trace = (left + 1.0) * exp(-5 / 5)
    assert found[0] == pytest.approx(trace, rel=1e-12)
    expected = 1.0 + 0.1 * exp(-12 / 20) + 0.3 * trace * exp(-7 / 5)
    assert found[1] == pytest.approx(expected, rel=1e-12)
    brain.set_plastic("learned", False)
    brain.reset()
    assert learned() == found
    brain.reset()
    brain.run_until(80 * MS)
    old = 0.1 * (exp(-12 / 20) + exp(-12 / 20) + exp(-52 / 20))
    assert brain.read_weights("learned") == pytest.approx([1.0 + old] * 2, rel=1e-12)
    brain.reset()
    with golden.raises(CapabilityError):
        brain.set_synapse_parameters("learned", {"change": [0.1, 0.2]})


@MODES
def test_parameters_of_a_share_change_while_it_runs(opened: Open, options: dict[str, str]) -> None:
    """A spike that is on its way at 11 ms is released with the old parameters."""
    sim = builder()
    law = sim.EquationSynapse(
        "dD/dt = (1 - D)/tau : 1", on_pre="share = D; D *= kept", initial={"D": 1},
        parameters={"tau": "50 ms", "kept": 0.5},
    )  # fmt: skip
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0, 20.0]), label="a")
    cells = sim.Population(2, sim.IF_curr_delta(tau_m=1e9, v_rest=0.0, v_reset=0.0, v_thresh=9.0), label="b")
    sim.Projection(source, cells, sim.AllToAllConnector(), law(weight=1.0, delay=4.0), label="tired")
    brain = opened(sim.network(), options)
    brain.run_until(11 * MS)
    brain.set_synapse_parameters("tired", {"tau": [20.0, 50.0], "kept": 0.25})
    first = 1.0 - 0.5 * exp(-1 / 50)
    levels = [1.0 + (first - 1.0) * exp(-9 / tau) for tau in (20, 50)]
    brain.run_until(30 * MS)
    v = brain.read_state("v", brain.network.ids_of("b"))
    assert v + 65.0 == pytest.approx([1.0 + one for one in levels], abs=1e-5)
    expected = [1.0 + (0.25 * one - 1.0) * exp(-10 / tau) for one, tau in zip(levels, (20, 50), strict=True)]
    assert brain.read_synapse_state("tired", "D") == pytest.approx(expected, rel=1e-12)


def test_an_eligibility_keeps_the_time_constant_of_rewards(opened: Open, golden: Golden) -> None:
    brain = opened(learner(builder(), own=True), {})
    brain.set_synapse_parameters("learned", {"tau": 10.0})
    with golden.raises(CapabilityError, match="'c'.*400"):
        brain.set_synapse_parameters("learned", {"tau_c": 400.0})


@pytest.mark.parametrize(
    ("label", "values"),
    [
        ("learned", {"tau_e": 1.0}),
        ("learned", {"tau": 0.0}),
        ("learned", {"tau": [1.0, 2.0, 3.0]}),
        ("learned", {"tau": "long"}),
        ("lerned", {"tau": 1.0}),
        ("fixed", {"weight": 1.0}),
    ],
)
def test_impossible_parameters_are_refused(opened: Open, label: str, values: Any, golden: Golden) -> None:
    sim = builder()
    learner(sim, own=True)
    a, b = (one for one in sim.state.populations if one.label in ("a", "b"))
    sim.Projection(a, b, sim.AllToAllConnector(), sim.StaticSynapse(weight=1.0, delay=1.0), label="fixed")
    with golden.raises(NetworkError):
        opened(sim.network(), {}).set_synapse_parameters(label, values)
