"""The rules of plasticity that only the machine has: each against a plain reading of the released code."""

from collections.abc import Callable

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from machine_rules import (
    ADDITIVE,
    MS,
    MULTIPLICATIVE,
    OBEDIENT,
    PAIRS,
    RAW,
    SHIFT,
    bits,
    fire,
    floor_mul,
    named,
    table,
)

from nrp_core.brain.interface import Brain
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import STDP

TRIPLETS = PAIRS | {"tau_x": 101.0, "tau_y": 125.0, "A3_plus": 0.02, "A3_minus": 0.03}
TRAINS = st.lists(st.integers(0, 150), unique=True, max_size=14).map(sorted)
Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]


def nearest_pairs(pre: list[int], post: list[int], delay: int, weight: str) -> int:
    plus, minus = table(PAIRS["tau_plus"]), table(PAIRS["tau_minus"])
    low, high = bits(PAIRS, 1.0, "w_min", "w_max")
    up, down = bits(PAIRS, PAIRS["w_max"] if weight == ADDITIVE else 1.0, "A_plus", "A_minus")
    raw, before = RAW, 0
    for t in pre:
        w = raw << SHIFT
        for k, p in enumerate(post):
            if not max(before - delay, 0) < p <= t - delay:
                continue
            since_pre, since_post = p + delay - before, p + delay - (post[k - 1] if k else 0)
            pair = (plus(since_pre) if since_pre <= since_post else 0) << 4
            if weight == ADDITIVE:
                w = min(w + floor_mul(up, pair), high)
            else:
                w += floor_mul(floor_mul(high - w, up), pair)
        earlier = [p for p in post if p <= max(t - delay, 0)]
        if earlier:
            pair = minus(t - delay - earlier[-1]) << 4
            if weight == ADDITIVE:
                w = max(w - floor_mul(down, pair), low)
            else:
                w -= floor_mul(floor_mul(w - low, down), pair)
        raw, before = (w >> SHIFT) & 0xFFFF, t
    return raw


def traces(train: list[int], fast: Callable[[int], int], slow: Callable[[int], int]) -> list[tuple[int, int]]:
    """Return the fast and the slow trace at each spike; the slow one does not include the spike."""
    found, last, own, earlier = [], 0, 0, 0
    for t in train:
        earlier = (earlier + 2048) * slow(t - last) // 2**11 if last else 0
        own, last = own * fast(t - last) // 2**11 + 2048, t
        found.append((own, earlier))
    return found


def triplets(pre: list[int], post: list[int], delay: int) -> int:
    plus, minus = table(TRIPLETS["tau_plus"]), table(TRIPLETS["tau_minus"])
    slow_x, slow_y = table(TRIPLETS["tau_x"], 2), table(TRIPLETS["tau_y"], 2)
    low, high = bits(TRIPLETS, 1.0, "w_min", "w_max")
    up, down, up3, down3 = bits(TRIPLETS, TRIPLETS["w_max"], "A_plus", "A_minus", "A3_plus", "A3_minus")
    of_post = dict(zip(post, traces(post, minus, slow_y), strict=True))
    raw, before, r1 = RAW, 0, 0
    for t, (new, r2) in zip(pre, traces(pre, plus, slow_x), strict=True):
        w = raw << SHIFT
        for p in (p for p in post if max(before - delay, 0) < p <= t - delay):
            pair = r1 * plus(p + delay - before) // 2**11
            three = pair * of_post[p][1] // 2**11
            w = min(w + floor_mul(up, pair << 4) + floor_mul(up3, three << 4), high)
        earlier = [p for p in post if p <= max(t - delay, 0)]
        if earlier:
            pair = of_post[earlier[-1]][0] * minus(t - delay - earlier[-1]) // 2**11
            three = pair * r2 // 2**11
            w = max(w - floor_mul(down, pair << 4) - floor_mul(down3, three << 4), low)
        raw, before, r1 = w >> SHIFT, t, new
    return raw


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(pre=TRAINS, post=TRAINS, delay=st.integers(1, 7), weight=st.sampled_from([ADDITIVE, MULTIPLICATIVE]))
def test_weights_follow_the_rule_of_nearest_pairs_in_every_bit(
    pre: list[int], post: list[int], delay: int, weight: str,
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    rule = {"kind": STDP, "plasticity": named(weight, "SpikeNearestPairRule"), **PAIRS}
    brain = open_brain(
        spike_source("pre", [float(t) for t in pre]), cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 1.0, float(delay), **rule), semantics="released",
    )  # fmt: skip
    fire(brain, post)
    brain.run_until(170 * MS)
    assert int(brain._engine.machine.stores.stdp.weight[0]) == nearest_pairs(pre, post, delay, weight)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(pre=TRAINS, post=TRAINS, delay=st.integers(1, 7), semantics=st.sampled_from(["pynn", "released"]))
def test_weights_follow_the_rule_of_triplets_in_every_bit(
    pre: list[int], post: list[int], delay: int, semantics: str,
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    rule = {"kind": STDP, "plasticity": named(ADDITIVE, "PfisterSpikeTripletRule"), **TRIPLETS}
    brain = open_brain(
        spike_source("pre", [float(t) for t in pre]), cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 1.0, float(delay), **rule), semantics=semantics,
    )  # fmt: skip
    fire(brain, post)
    brain.run_until(170 * MS)
    assert int(brain._engine.machine.stores.stdp.weight[0]) == triplets(pre, post, delay)
