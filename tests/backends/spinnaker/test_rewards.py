"""Rewards and punishments that decide on STDP: bit for bit as the released functions, and what is refused."""

from collections.abc import Callable
from dataclasses import replace
from math import exp

import numpy as np
import pytest
from golden import Golden
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
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Population, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import STDP

MODULATION = Neuromodulation(tau_c=90.0, tau_d=40.0, w_min=0.2, w_max=1.5)
TRAINS = st.lists(st.integers(1, 150), unique=True, max_size=12).map(sorted)
Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]
Event = tuple[int, int, int, bool]
"""Tick, trace, dopamine, and whether it is a reward."""


def history(post: list[int], rewards: dict[int, int]) -> list[list[Event]]:
    """Return the history of a target after each tick, at most 15 events; spikes stand before rewards.

    Within a tick all of these come before a spike of a source that is defined later.
    """
    minus, fade = table(PAIRS["tau_minus"]), table(MODULATION.tau_d, 2)
    events: list[Event] = []
    seen = []
    for tick in range(170):
        for is_reward in (False, True):
            if tick not in (rewards if is_reward else post):
                continue
            last, trace, dopamine, _ = events[-1] if events else (0, 0, 0, False)
            trace, dopamine = trace * minus(tick - last) // 2**11, dopamine * fade(tick - last) // 2**11
            new = (tick, trace, dopamine + rewards[tick]) if is_reward else (tick, trace + 2048, dopamine)
            events.append((*new, is_reward))
        seen.append(events[-15:])
    return seen


def expected(
    pre: list[int], post: list[int], rewards: dict[int, int], delay: int, weight: str
) -> tuple[int, int]:
    """Return raw weight and eligibility, one pre-synaptic spike after another."""
    plus, minus = table(PAIRS["tau_plus"]), table(PAIRS["tau_minus"])
    of_c, of_d = table(MODULATION.tau_c, 4), table(MODULATION.tau_d, 2)
    constant = round(-1 / (1 / MODULATION.tau_c + 1 / MODULATION.tau_d) * 2**15)
    low, high = bits(PAIRS, 1.0, "w_min", "w_max")
    up, down = bits(PAIRS, PAIRS["w_max"] if weight == ADDITIVE else 1.0, "A_plus", "A_minus")
    least, most = round(MODULATION.w_min * 2**15), round(MODULATION.w_max * 2**15)
    raw, raw_eligibility, before, r1 = RAW, 0, 0, 0
    seen = history(post, rewards)

    def credit(eligibility: int, dopamine: int, ticks: int) -> int:
        both = of_c(ticks) * of_d(ticks) // 2**11 - 2048
        return floor_mul(floor_mul(floor_mul(eligibility, constant), dopamine << 4), both << 4)

    for t in pre:
        w, c = raw << SHIFT, raw_eligibility << SHIFT
        events = seen[t]
        until = [event for event in events if event[0] <= max(t - delay, 0)]
        old = [event for event in until if event[0] <= max(before - delay, 0)]
        window = until[len(old) :]
        # the released functions count marks from the end of the history, whose last events may be too late
        marks = [event[3] for event in events][len(events) - len(window) :]
        at, dopamine = before, old[-1][2] * of_d(before - old[-1][0]) // 2**11 if old else 0
        for (tick, _, new, _), is_reward in zip(window, marks, strict=True):
            passed = tick + delay - at
            w += credit(c, dopamine, passed)
            c = floor_mul(c, of_c(passed) << 4)
            if not is_reward and tick + delay > before:
                pair = (r1 * plus(tick + delay - before) // 2**11) << 4
                if weight == ADDITIVE:
                    c = min(c + floor_mul(up, pair), high)
                else:
                    c += floor_mul(floor_mul(high - c, up), pair)
            at, dopamine = tick + delay, new
        if until:
            w += credit(c, dopamine, t - at)
            c = floor_mul(c, of_c(t - at) << 4)
            pair = (until[-1][1] * minus(t - delay - until[-1][0]) // 2**11) << 4
            if weight == ADDITIVE:
                c = max(c - floor_mul(down, pair), low)
            else:
                c -= floor_mul(floor_mul(c - low, down), pair)
        raw, raw_eligibility = min(max(w, least), most) >> SHIFT, (c >> SHIFT) & 0xFFFF
        r1, before = r1 * plus(t - before) // 2**11 + 2048, t
    return raw, raw_eligibility


@pytest.fixture
def rewarded(connect: Connect) -> Callable[..., Projection]:
    def make(pre: str, weight: float, receptor: str = "reward", **given: object) -> Projection:
        delay = given.pop("delay", 1.0)
        modulation = given.pop("modulation", MODULATION)
        made = connect(pre, "cell", weight, delay, receptor="excitatory", label=f"{pre} {receptor}", **given)
        return replace(made, receptor=receptor, neuromodulation=modulation)

    return make


@pytest.mark.heavy
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pre=TRAINS, post=TRAINS, rewards=TRAINS, punishments=TRAINS, delay=st.integers(1, 7),
    weight=st.sampled_from([ADDITIVE, MULTIPLICATIVE]),
)  # fmt: skip
def test_weights_follow_rewards_and_punishments_in_every_bit(
    pre: list[int], post: list[int], rewards: list[int], punishments: list[int], delay: int, weight: str,
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect, open_brain: Open,
) -> None:  # fmt: skip
    punishments = [t for t in punishments if t not in rewards]
    rule = {"kind": STDP, "plasticity": named(weight), **PAIRS}
    brain = open_brain(
        *(spike_source(label, [float(t) for t in train])
          for label, train in (("good", rewards), ("bad", punishments), ("pre", pre))),
        cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 1.0, float(delay), **rule),
        rewarded("good", 0.7), rewarded("bad", 0.3, "punishment"), semantics="released",
    )  # fmt: skip
    fire(brain, post)
    brain.run_until(170 * MS)
    dopamine = dict.fromkeys(rewards, round(0.7 * 2048)) | dict.fromkeys(punishments, -round(0.3 * 2048))
    plastic = brain._engine.machine.stores.stdp
    assert (int(plastic.weight[0]), int(plastic.eligibility[0])) == expected(
        pre, post, dopamine, delay, weight
    )


def test_a_reward_long_after_a_pair_of_spikes_strengthens_by_the_integral_of_both_decays(
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect, open_brain: Open
) -> None:
    """The scenario and the formula of sPyNNaker's own test of neuromodulation."""
    tau_c, tau_d, dopamine = 1000.0, 200.0, 0.1
    slow = Neuromodulation(tau_c, tau_d, w_max=20.0)
    rule = {"tau_plus": 10.0, "tau_minus": 12.0, "w_min": 0.0, "w_max": 20.0}
    rule |= {"A_plus": 1.0 / rule["w_max"], "A_minus": 1.0 / rule["w_max"]}
    brain = open_brain(
        spike_source("pre", [1500.0, 2400.0]), spike_source("good", [1600.0]),
        cells("cell", "IF_curr_exp", **OBEDIENT),
        connect("pre", "cell", 0.0, 1.0, kind=STDP, plasticity=named(ADDITIVE), **rule),
        rewarded("good", dopamine, modulation=slow), semantics="released",
    )  # fmt: skip
    fire(brain, [1503])
    brain.run_until(2500 * MS)
    pair, kept = exp(-4 / 10), exp(-97 / tau_c)
    integral = (1 - exp(-799 / tau_c) * exp(-799 / tau_d)) / (1 / tau_c + 1 / tau_d)
    (found,) = brain.read_weights("pre-cell-excitatory")
    assert found == pytest.approx(pair * kept * dopamine * integral, rel=0.05)


def test_rewards_survive_a_snapshot(
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect, open_brain: Open
) -> None:
    rule = {"kind": STDP, "plasticity": named(ADDITIVE), **PAIRS}
    brain = open_brain(
        spike_source("pre", np.arange(5.0, 100.0, 7.0).tolist()), spike_source("good", [20.0, 50.0]),
        cells("cell", "IF_curr_exp", i_offset=3.0),
        connect("pre", "cell", 1.0, 2.0, **rule), rewarded("good", 0.9),
    )  # fmt: skip
    brain.run_until(40 * MS)
    saved = brain.snapshot()
    ends = []
    for _ in range(2):
        brain.run_until(100 * MS)
        plastic = brain._engine.machine.stores.stdp
        ends.append([plastic.weight[0], plastic.eligibility[0], *plastic.history_dopamine[0]])
        brain.restore(saved)
    assert ends[0] == ends[1]
    assert any(ends[0][2:])


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            {"weight": 16.0},
            NetworkError,
            "16",
        ),
        ({"delay": 2.0}, NetworkError, ""),
        ({"receptor": "excitatory"}, NetworkError, "'excitatory'"),
        ({"pre": "pre"}, CapabilityError, "'pre'.*'cell'"),
        ({"modulation": Neuromodulation(tau_d=1.0)}, CapabilityError, "tau_c, tau_d, w_min"),
    ],
)
def test_rewards_that_the_machine_lacks_are_refused(
    change: dict, error: type, message: str,
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect, open_brain: Open, golden: Golden,
) -> None:  # fmt: skip
    rule = {"kind": STDP, "plasticity": named(ADDITIVE), **PAIRS}
    with golden.raises(error, match=message):
        open_brain(
            *(spike_source(label, []) for label in ("pre", "good", "bad")), cells("cell", "IF_curr_exp"),
            connect("pre", "cell", 1.0, **rule), rewarded("good", 0.1),
            rewarded(**({"pre": "bad", "weight": 0.1, "receptor": "punishment"} | change)),
        )  # fmt: skip


def test_rewards_without_stdp_are_refused(
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect, open_brain: Open, golden: Golden
) -> None:
    parts = [spike_source("s", []), spike_source("good", []), cells("cell", "IF_curr_exp")]
    with golden.raises(CapabilityError, match="'good reward'"):
        open_brain(*parts, connect("s", "cell", 1.0), rewarded("good", 0.1))


def test_a_population_with_rewards_has_a_core_for_its_synapses(
    cells: Maker, spike_source: Maker, connect: Connect, rewarded: Connect
) -> None:
    from nrp_brain_spinnaker import SpinnakerOptions
    from nrp_brain_spinnaker.loader import lay_out
    from nrp_brain_spinnaker.mapping.plan import map_network

    from nrp_core.network.data import Network

    parts = [spike_source("pre", []), spike_source("good", []), cells("cell", "IF_curr_exp")]
    rule = {"kind": STDP, "plasticity": named(ADDITIVE), **PAIRS}
    wires = (connect("pre", "cell", 1.0, **rule), rewarded("good", 0.1))
    network = Network({part.label: part for part in parts}, wires)
    options = SpinnakerOptions()
    found, own, _ = lay_out(network, options)
    of = {one.label: one for one in map_network(network, found, own, options).vertices}
    assert [core.has_synapses_alone for core in of["cell"].cores] == [True, False]
    assert of["good"].cores[0].key is not None
