"""Synapses that change: STDP against a plain reading of its rule, Tsodyks-Markram against floats."""

from collections.abc import Callable
from math import exp

import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from machine_rules import ADDITIVE, MS, MULTIPLICATIVE, OBEDIENT, PAIRS, fire, floor_mul, named

from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM

TRAINS = st.lists(st.integers(3, 150), unique=True, max_size=14).map(sorted)
Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]


def reference(
    pre: list[int], post: list[int], delay: int, raw: int, shift: int, gains: tuple[int, int], weight: str
) -> int:
    """Apply the pair rule to whole trains (ticks), one pre-synaptic spike after another."""
    plus, minus = (
        [int(2048 * exp(-i / PAIRS[tau])) for i in range(400)] for tau in ("tau_plus", "tau_minus")
    )
    low, high = (round(PAIRS[name] * 2**15) for name in ("w_min", "w_max"))
    post_traces, last = {}, None
    for p in post:
        grown = 0 if last is None else post_traces[last] * minus[p - last] // 2**11
        post_traces[p], last = grown + 2048, p
    before, trace = 0, 0
    for t in pre:
        w = raw << shift
        for p in (p for p in post if max(before - delay, 0) < p <= t - delay):
            pair = (trace * plus[p + delay - before] // 2**11) << 4
            if weight == ADDITIVE:
                w = min(w + floor_mul(gains[0], pair), high)
            else:
                w += floor_mul(floor_mul(high - w, gains[0]), pair)
        earlier = [p for p in post if p <= t - delay]
        if earlier:
            pair = (post_traces[earlier[-1]] * minus[t - delay - earlier[-1]] // 2**11) << 4
            if weight == ADDITIVE:
                w = max(w - floor_mul(gains[1], pair), low)
            else:
                w -= floor_mul(floor_mul(w - low, gains[1]), pair)
        raw = w >> shift
        trace = trace * plus[t - before] // 2**11 + 2048
        before = t
    return raw


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pre=TRAINS, post=TRAINS, delay=st.integers(1, 7), weight=st.sampled_from([ADDITIVE, MULTIPLICATIVE]),
    semantics=st.sampled_from(["pynn", "released"]),
)  # fmt: skip
def test_weights_follow_the_pair_rule_in_every_bit(
    pre: list[int], post: list[int], delay: int, weight: str, semantics: str,
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    brain = open_brain(
        spike_source("pre", [float(t) for t in pre]), cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 1.0, float(delay), kind=STDP, plasticity=named(weight), **PAIRS),
        semantics=semantics,
    )  # fmt: skip
    fire(brain, post)
    brain.run_until(170 * MS)
    plastic, shift = brain._engine.machine.stores.stdp, 2
    scale = PAIRS["w_max"] if weight == ADDITIVE else 1.0
    gains = tuple(round(PAIRS[name] * scale * 2**15) for name in ("A_plus", "A_minus"))
    assert int(plastic.weight[0]) == reference(pre, post, delay, 2**15 >> shift, shift, gains, weight)


VOGELS = {"tau": 16.7, "eta": 0.05, "rho": 6.0, "w_min": 0.1, "w_max": 2.0}


def vogels_reference(pre: list[int], post: list[int], delay: int, raw: int, shift: int, least: int) -> int:
    """Apply the rule of Vogels et al. to whole trains (ticks), one pre-synaptic spike after another."""
    table = [int(2048 * exp(-i / VOGELS["tau"])) for i in range(400)]
    gain, high = round(VOGELS["eta"] * 2**15), round(VOGELS["w_max"] * 2**15)
    alpha = round(2 * VOGELS["rho"] * VOGELS["tau"] / 1000 * 2048)
    post_traces: dict[int, int] = {}
    for p in post:
        last = max(post_traces, default=None)
        post_traces[p] = 2048 + (0 if last is None else post_traces[last] * table[p - last] // 2**11)
    before, trace = 0, 0
    for t in pre:
        w = raw << shift
        for p in (p for p in post if max(before - delay, 0) < p <= t - delay):
            w = min(w + floor_mul(gain, (trace * table[p + delay - before] // 2**11) << 4), high)
        earlier = [p for p in post if p <= t - delay]
        if earlier:
            near = post_traces[earlier[-1]] * table[t - delay - earlier[-1]] // 2**11
            w = max(min(w + floor_mul(gain, (near - alpha) << 4), high), least)
        raw = (w >> shift) & 0xFFFF  # a weight below 0 wraps in the released software
        trace, before = trace * table[t - before] // 2**11 + 2048, t
    return raw


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pre=TRAINS, post=TRAINS, delay=st.integers(1, 7), semantics=st.sampled_from(["pynn", "released"]),
    weight=st.sampled_from([0.12, 1.0]),
)  # fmt: skip
def test_weights_follow_the_rule_of_vogels_in_every_bit(
    pre: list[int], post: list[int], delay: int, semantics: str, weight: float,
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    rule = {"kind": STDP, "plasticity": named(ADDITIVE, "Vogels2011Rule"), **VOGELS}
    brain = open_brain(
        spike_source("pre", [float(t) for t in pre]), cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", -weight, float(delay), receptor="inhibitory", **rule),
        semantics=semantics,
    )  # fmt: skip
    fire(brain, post)
    brain.run_until(170 * MS)
    plastic, shift = brain._engine.machine.stores.stdp, 2
    least = round(VOGELS["w_min"] * 2**15) if semantics == "pynn" else -(2**40)
    start = round(weight * 2**15 / 2**shift)
    assert int(plastic.weight[0]) == vogels_reference(pre, post, delay, start, shift, least)


def test_only_the_last_fifteen_post_synaptic_spikes_are_remembered(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    brain = open_brain(
        spike_source("pre", [10.0]), cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 1.0, kind=STDP, plasticity=named(ADDITIVE), **PAIRS),
    )  # fmt: skip
    post = list(range(20, 100, 4))
    fire(brain, post)
    brain.run_until(105 * MS)
    assert brain._engine.machine.stores.stdp.history_tick[0].tolist() == [0, *post[-15:]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plasticity": named("GutigWeightDependence")}, "SpikePairRule with .*, not GutigWeightDependence"),
        (
            {"plasticity": named(MULTIPLICATIVE, "PfisterSpikeTripletRule")},
            "not MultiplicativeWeightDependence, PfisterSpikeTripletRule",
        ),
        ({"dendritic_delay_fraction": 0.5}, "dendritic_delay_fraction.*0.5"),
        ({"A_minus": -0.1}, "'s-n-excitatory': A_minus.*-0.1"),
    ],
)
def test_a_rule_that_the_machine_lacks_is_refused(
    change: dict,
    message: str,
    cells: Maker,
    spike_source: Maker,
    connect: Connect,
    open_brain: Open,
    golden: Golden,
) -> None:
    given = {"kind": STDP, "plasticity": named(ADDITIVE), **PAIRS} | change
    with golden.raises(CapabilityError, match=message):
        open_brain(spike_source("s", []), cells("n", "IF_curr_exp"), connect("s", "n", 1.0, **given))


def test_two_time_constants_on_one_population_are_refused(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    rules = [{"kind": STDP, "plasticity": named(ADDITIVE), **PAIRS, "tau_minus": tau} for tau in (20.0, 30.0)]
    parts = [connect("s", "n", 1.0, label=f"p{k}", **rule) for k, rule in enumerate(rules)]
    with golden.raises(CapabilityError, match="'p1'.*STDP"):
        open_brain(spike_source("s", []), cells("n", "IF_curr_exp"), *parts)


def released_shares(
    spikes: list[float], use: float, tau_rec: float, tau_facil: float, tau_syn: float
) -> list[float]:
    """Return the share of the weight that each spike releases (Tsodyks, Uziel & Markram 2000)."""
    y = z = u = 0.0
    shares, before = [], None
    for t in spikes:
        dt = 0.0 if before is None else t - before
        ending, recovering = exp(-dt / tau_syn), exp(-dt / tau_rec)
        if abs(tau_syn - tau_rec) > 1e-9:
            inactivated = y * tau_rec / (tau_syn - tau_rec) * (ending - recovering)
        else:
            inactivated = y * dt / tau_rec * recovering
        z = z * recovering + inactivated
        y *= ending
        u *= exp(-dt / tau_facil) if tau_facil else 0.0
        u += use * (1 - u)
        shares.append(u * (1 - y - z))
        y += shares[-1]
        before = t
    return shares


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    gaps=st.lists(st.integers(1, 80), min_size=1, max_size=12),
    use=st.sampled_from([0.1, 0.5, 1.0]), tau_rec=st.sampled_from([1.0, 5.0, 100.0, 800.0]),
    tau_facil=st.sampled_from([0.0, 1.0, 5.0, 530.0]), tau_syn=st.sampled_from([0.5, 2.5, 5.0]),
)  # fmt: skip
def test_released_shares_follow_a_float_reference(
    gaps: list[int], use: float, tau_rec: float, tau_facil: float, tau_syn: float,
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    spikes = np.cumsum([2, *gaps]).astype(float).tolist()
    brain = open_brain(
        spike_source("s", spikes), cells("n", "IF_curr_exp", tau_syn_E=tau_syn, v_thresh=np.inf),
        connect("s", "n", 0.9, 1.0, kind=TSODYKS_MARKRAM, U=use, tau_rec=tau_rec, tau_facil=tau_facil),
    )  # fmt: skip
    rows, ring = brain._engine.machine.stores.tsodyks_markram, brain._engine.machine.ring
    for t, share in zip(spikes, released_shares(spikes, use, tau_rec, tau_facil, tau_syn), strict=True):
        brain.run_until(round((t + 1) * MS))
        slot = (int(t) + 1) & (len(ring.slots) - 1)
        assert int(ring.slots[slot, 0]) / int(rows.weight[0]) == pytest.approx(share, abs=1.5e-3)


def test_a_first_spike_that_uses_everything_arrives_with_the_whole_weight(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    dynamic = {"kind": TSODYKS_MARKRAM, "U": 1.0, "tau_rec": 1.0, "tau_facil": 1.0}
    cell = cells("n", "IF_cond_alpha", tau_syn_E=2.5)
    static, tiring = (
        open_brain(spike_source("s", [2.0]), cell, connect("s", "n", 1.5e-4, 0.1, **kind))
        for kind in ({}, dynamic)
    )
    for brain in (static, tiring):
        brain.run_until(10 * MS)
    assert static.read_state("v", [1]) == tiring.read_state("v", [1]) > -65
