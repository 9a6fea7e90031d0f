"""Rewards that decide on STDP: the numbers of NEST and sPyNNaker, and a walk from event to event."""

from collections.abc import Callable
from dataclasses import replace
from math import exp, log

import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from nrp_core.brain.interface import Brain
from nrp_core.brain.together import BrainBatch
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Population, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import STDP

MS = 1_000_000
Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]
TAU_D = 200.0
NEST = Neuromodulation(w_max=200.0, shared=True, eligibility_limits=False)
"""The defaults of NEST 3.10."""
ADDITIVE = {"timing_dependence": "SpikePairRule", "weight_dependence": "AdditiveWeightDependence"}
PAIRS = {"tau_plus": 20.0, "tau_minus": 20.0, "A_plus": 1.0, "A_minus": 1.5, "w_min": 0.0, "w_max": 1.0}
MODES = [{}, {"resolution": "0.1 ms"}, {"resolution": "0.1 ms", "lazy": "always"}]
IDS = ["exact", "grid", "lazy"]
CASES = {
    "A": {"w": 1.46501140981572, "c": 0.216752311287261, "n": 4.34753100289775e-5},
    "B": {
        "pre": [10, 35, 60, 110, 300], "post": [20, 30, 62, 105, 299], "dopamine": [50, 55, 250, 400],
        "w0": 10.0, "baseline": 0.002, "w": 7.47861518390315, "c": -0.687427216185382,
        "n": 4.56412483442499e-4,
    },
    "C": {
        "pre": [10, 21, 100, 400], "post": [20, 50, 101, 150], "dopamine": [20, 100, 101, 300],
        "w_max": 1.35, "A_minus": 0.5, "baseline": 0.001, "w": 1.26824490728503, "c": 0.745741061424969,
        "n": 3.01089910426136e-4,
    },
    "D": {"delay": 5.0, "w": 1.38224506813347, "c": 0.178173051772904, "n": 4.34753100289775e-5},
    "M": {"sources": 3, "w": 2.39503422944717, "c": 0.216752311287261, "n": 1.30425930086933e-4},
}  # fmt: skip
"""Weight, eligibility and dopamine at 1 s in NEST 3.10.0. In C, NEST clips at the ends of its intervals; the
weight is the one that it approaches with shorter ones."""


@pytest.fixture
def learning(cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open) -> Callable[..., Brain]:
    """Open a brain whose cell fires at given times (ms), with one synapse, and rewards after 1 ms."""

    def make(
        pre: list[float], post: list[float], rewards: list[float], modulation: Neuromodulation, *,
        w0: float = 1.0, weight: float = 1.0, delay: float = 1.0, sources: int = 1,
        punishments: list[float] = (), rule: dict[str, float] | None = None, **options: object,
    ) -> Brain:  # fmt: skip
        jumps = {"tau_m": 10.0, "v_rest": 0.0, "v_reset": 0.0, "v_thresh": 100.0, "tau_refrac": 0.0}
        wires = connect("pre", "cell", w0, delay, kind=STDP, plasticity=ADDITIVE, **(rule or PAIRS))
        ways = [
            connect(label, "cell", weight, 1.0, label=label, pairs=[(k, 0) for k in range(n)])
            for label, n in (("reward", sources), ("punishment", 1))
        ]
        return open_brain(
            spike_source("pre", pre), spike_source("drive", [t - 1.0 for t in post]),
            spike_source("reward", *[rewards] * sources), spike_source("punishment", punishments),
            cells("cell", "IF_curr_delta", **jumps), connect("drive", "cell", 1000.0, 1.0), wires,
            *(replace(one, receptor=one.label, neuromodulation=modulation) for one in ways), **options,
        )  # fmt: skip

    return make


def state_of(brain: Brain) -> list[float]:
    wires = "pre-cell-excitatory"
    return [
        brain.read_weights(wires)[0],
        *(brain.read_synapse_state(wires, name)[0] for name in ("eligibility", "dopamine")),
    ]


def test_a_brain_with_rewards_learns_as_alone_beside_brains_of_other_kinds(
    cells: Maker, connect: Connect, open_brain: Open
) -> None:
    driven = [cells(label, "IF_curr_exp", i_offset=5.0) for label in "ab"]
    wires = connect(
        "a", "b", 1.0, kind=STDP, plasticity=ADDITIVE, **PAIRS | {"A_plus": 0.01, "A_minus": 0.01}
    )
    critic = replace(connect("a", "b", 1.0, label="critic"), receptor="reward", neuromodulation=NEST)
    others = open_brain(*driven, wires), open_brain(*driven, wires, resolution="1 ms")
    learning, alone = (open_brain(*driven, wires, critic) for _ in range(2))
    batch = BrainBatch()
    for brain in (*others, learning):
        assert not batch.run_until([brain], [200 * MS])
    alone.run_until(200 * MS)
    weights = [brain.read_weights("a-b-excitatory")[0] for brain in (alone, learning, *others)]
    assert weights[0] == weights[1]
    assert 0.0 < weights[0] != weights[2] > 0.0


@pytest.mark.parametrize("options", MODES, ids=IDS)
@pytest.mark.parametrize("name", CASES)
def test_it_agrees_with_nest(name: str, options: dict[str, str], learning: Callable[..., Brain]) -> None:
    case = {"pre": [10], "post": [20], "dopamine": [50], "w0": 1.0, "delay": 1.0, "sources": 1} | CASES[name]
    modulation = replace(NEST, baseline=case.get("baseline", 0.0), w_max=case.get("w_max", 200.0))
    brain = learning(
        case["pre"], case["post"], case["dopamine"], modulation, w0=case["w0"], delay=case["delay"],
        weight=1 / TAU_D, sources=case["sources"],
        rule=PAIRS | {"A_minus": case.get("A_minus", 1.5)}, **options,
    )  # fmt: skip
    brain.run_until(1000 * MS)
    assert state_of(brain) == pytest.approx([case["w"], case["c"], case["n"]], rel=1e-9)


def walked(
    pre: list[float], post: list[float], rewards: list[tuple[float, float]], modulation: Neuromodulation, *,
    w0: float, delay: float, until: float, rule: dict[str, float],
) -> list[float]:  # fmt: skip
    """Return weight, eligibility and dopamine of the cell, one event of the synapse after another.

    All quantities decay to each event by their closed form; in between the weight is clipped only where
    dopamine passes the baseline, since it is monotonic otherwise.
    """
    late = 0.0 if modulation.shared else delay
    events = sorted(
        [(t, 1, 0.0) for t in pre if t <= until]
        + [(t + delay, 0, 0.0) for t in post]
        + [(t + late, 2, amount) for t, amount in rewards]
    )
    w, c, n, now = w0, 0.0, 0.0, 0.0
    seen: dict[int, list[float]] = {0: [], 1: []}
    low, high = (rule["w_min"], rule["w_max"]) if modulation.eligibility_limits else (-1e9, 1e9)

    def piece(w: float, c: float, n: float, span: float) -> float:
        tau = 1 / (1 / modulation.tau_c + 1 / modulation.tau_d)
        change = n * tau * (1 - exp(-span / tau))
        change -= modulation.baseline * modulation.tau_c * (1 - exp(-span / modulation.tau_c))
        return min(max(w + c * change, modulation.w_min), modulation.w_max)

    def pass_time(span: float) -> None:
        nonlocal w, c, n
        b = modulation.baseline
        cuts = [span]
        if b and n / b > 1 and (turn := modulation.tau_d * log(n / b)) < span:
            cuts = [turn, span - turn]
        for cut in cuts:
            w = piece(w, c, n, cut) if c else w
            c, n = c * exp(-cut / modulation.tau_c), n * exp(-cut / modulation.tau_d)

    def trace(side: int, t: float, tau: float) -> float:
        return sum(exp((s - t) / tau) for s in seen[side] if s < t - 1e-9)

    for t, kind, amount in (one for one in events if one[0] <= until):
        pass_time(t - now)
        now = t
        if kind == 2:
            n += amount
            continue
        if kind == 0:
            c = min(c + rule["w_max"] * rule["A_plus"] * trace(1, t, rule["tau_plus"]), high)
        else:
            c = max(c - rule["w_max"] * rule["A_minus"] * trace(0, t, rule["tau_minus"]), low)
        seen[kind].append(t)
    pass_time(until - now)
    dopamine = sum(amount * exp((t - until) / modulation.tau_d) for t, amount in rewards if t <= until)
    return [w, c, dopamine]


TRAIN = st.lists(st.integers(2, 3000), unique=True, max_size=12).map(lambda t: [x / 10 for x in sorted(t)])


@pytest.mark.one_of(6)
@pytest.mark.parametrize("options", MODES, ids=IDS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pre=TRAIN, post=TRAIN, rewards=TRAIN, punishments=TRAIN, delay=st.sampled_from([0.5, 1.0, 7.0]),
    shared=st.booleans(), limits=st.booleans(), baseline=st.sampled_from([0.0, 0.05, -0.03]),
)  # fmt: skip
@example(  # dopamine passes the baseline while the weight is at a limit
    pre=[10.0], post=[15.0], rewards=[20.0], punishments=[], delay=1.0, shared=False, limits=True,
    baseline=0.05,
)  # fmt: skip
@example(
    pre=[10.0], post=[15.0], rewards=[], punishments=[20.0], delay=7.0, shared=True, limits=True,
    baseline=-0.03,
)  # fmt: skip
def test_weights_are_those_of_a_walk_from_event_to_event(
    options: dict[str, str], pre: list[float], post: list[float], rewards: list[float],
    punishments: list[float], delay: float, shared: bool, limits: bool, baseline: float,
    learning: Callable[..., Brain],
) -> None:  # fmt: skip
    post = [t + 1.0 for t in post]
    modulation = Neuromodulation(90.0, 40.0, 0.2, 1.5, baseline, shared, limits)
    brain = learning(
        pre, post, rewards, modulation, delay=delay, weight=0.1, punishments=punishments, **options
    )
    brain.run_until(350 * MS)
    jumps = [(t + 1.0, 0.1) for t in rewards] + [(t + 1.0, -0.1) for t in punishments]
    expected = walked(pre, post, jumps, modulation, w0=1.0, delay=delay, until=350.0, rule=PAIRS)
    assert state_of(brain) == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.fixture
def busy(learning: Callable[..., Brain]) -> Callable[..., Brain]:
    """Open a brain with hundreds of rewards, more than are kept in mind."""
    rng = np.random.default_rng(4)
    pre, post, rewards, punishments = (
        np.unique(np.round(np.sort(rng.uniform(5.0, 4900.0, n)), 1)).tolist() for n in (60, 50, 400, 300)
    )
    post = [t + 1.0 for t in post]

    def make(shared: bool = False, **options: object) -> tuple[Brain, Callable[[float], list[float]]]:
        modulation = Neuromodulation(300.0, 40.0, 0.2, 5.0, 0.02, shared, eligibility_limits=False)
        brain = learning(
            pre, post, rewards, modulation, delay=3.0, weight=0.1, punishments=punishments, **options
        )
        jumps = [(t + 1.0, 0.1) for t in rewards] + [(t + 1.0, -0.1) for t in punishments]
        return brain, lambda until: walked(
            pre, post, jumps, modulation, w0=1.0, delay=3.0, until=until, rule=PAIRS
        )

    return make


@pytest.mark.parametrize("options", [*MODES, {"shared": True}], ids=[*IDS, "shared"])
def test_old_rewards_are_forgotten_and_runs_may_be_split(
    options: dict[str, object], busy: Callable[..., tuple[Brain, Callable]]
) -> None:
    brain, walk = busy(**options)
    brain.run_until(5000 * MS)
    whole = state_of(brain)
    assert whole == pytest.approx(walk(5000.0), rel=1e-9)
    assert brain._rewards._shelf.arrays.modulators["n"][0] < 300
    brain.reset()
    for t_ms in [7, 307, 2000, 2007, 2307, 4000, 4900]:
        brain.run_until(t_ms * MS)
        if t_ms == 2007:
            middle = state_of(brain)
            assert middle == pytest.approx(walk(2007.0), rel=1e-9)
            saved = brain.snapshot()
    brain.run_until(5000 * MS)
    assert state_of(brain) == whole
    brain.restore(saved)
    assert state_of(brain) == middle
    brain.run_until(5000 * MS)
    assert state_of(brain) == whole


@pytest.mark.parametrize("options", MODES, ids=IDS)
def test_neurons_reward_and_a_loop_rewards(
    options: dict[str, str], cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    jumps = {"tau_m": 10.0, "v_rest": 0.0, "v_reset": 0.0, "v_thresh": 100.0, "tau_refrac": 0.0}
    modulation = Neuromodulation(90.0, 40.0, 0.0, 5.0)
    pre, post, rewards = [10.0, 50.0, 160.0], [20.0, 70.0, 150.0], [30.0, 31.5, 90.0]
    reward = connect("critic", "cell", 0.1, 2.0, label="reward")
    brain = open_brain(
        spike_source("pre", pre), spike_source("drive", [t - 1.0 for t in post]),
        spike_source("success", [t - 1.0 for t in rewards]),
        cells("critic", "IF_curr_delta", **jumps), cells("cell", "IF_curr_delta", **jumps),
        connect("drive", "cell", 1000.0, 1.0), connect("success", "critic", 1000.0, 1.0),
        connect("pre", "cell", 1.0, 1.0, kind=STDP, plasticity=ADDITIVE, **PAIRS),
        replace(reward, receptor="reward", neuromodulation=modulation), **options,
    )  # fmt: skip
    wires = "pre-cell-excitatory"
    brain.run_until(100 * MS)
    brain.reward(wires, 0.25)
    brain.run_until(120 * MS)
    brain.reward(wires, -0.05)
    brain.run_until(200 * MS)
    dopamine = [(t + 2.0, 0.1) for t in rewards] + [(100.0, 0.25), (120.0, -0.05)]
    expected = walked(pre, post, dopamine, modulation, w0=1.0, delay=1.0, until=200.0, rule=PAIRS)
    assert state_of(brain) == pytest.approx(expected, rel=1e-9)
    brain.set_weights(wires, 2.0)
    assert brain.read_weights(wires)[0] == 2.0
    brain.run_until(210 * MS)
    w = brain.read_weights(wires)[0] - 2.0
    later = walked(pre, post, dopamine, modulation, w0=1.0, delay=1.0, until=210.0, rule=PAIRS)
    assert w == pytest.approx(later[0] - expected[0], rel=1e-6)


@pytest.mark.parametrize("options", MODES, ids=IDS)
@pytest.mark.parametrize("shared", [True, False])
def test_a_held_reward_is_that_of_mstdpet(
    shared: bool, options: dict[str, str], learning: Callable[..., Brain]
) -> None:
    """While r is held, the weight changes by ``r z tau_z (1 - exp(-D / tau_z))`` (Florian 2007)."""
    tau_z, wires = 25.0, "pre-cell-excitatory"
    late = 0.0 if shared else 1.0  # dopamine of a cell reaches its synapses after the dendritic delay
    modulation = Neuromodulation(tau_c=tau_z, w_max=200.0, shared=shared, eligibility_limits=False)
    brain = learning([10.0], [20.0], [], modulation, w0=5.0, **options)
    held = [(15.0, 0.75), (40.0, 0.75), (40.0, -0.5), (70.0, 0.0), (100.0, 0.25)]
    for t, value in held:
        brain.run_until(round(t * MS))
        brain.hold_reward(wires, value)
    brain.run_until(150 * MS)
    pair, z = 21.0, exp(-11 / 20)
    expected = 5.0
    for (since, value), (until, _) in zip(held, [*held[1:], (150.0 - late, 0.0)], strict=True):
        since, until = max(since + late, pair), max(until + late, pair)
        left = z * exp(-(since - pair) / tau_z)
        expected += value * left * tau_z * (1 - exp(-(until - since) / tau_z))
    assert state_of(brain) == pytest.approx([expected, z * exp(-129 / tau_z), 0.25], rel=1e-12)
    brain.reset()
    brain.run_until(150 * MS)
    assert state_of(brain) == pytest.approx([5.0, z * exp(-129 / tau_z), 0.0], rel=1e-12)


@pytest.mark.parametrize("options", MODES, ids=IDS)
def test_a_held_reward_is_a_lower_baseline(options: dict[str, str], learning: Callable[..., Brain]) -> None:
    """Also where dopamine passes it and the weight is clipped, and after a snapshot."""
    case = CASES["C"]
    found = []
    for baseline, held in ((2.0**-10, 0.0), (2.0**-8, 2.0**-8 - 2.0**-10)):
        modulation = replace(NEST, baseline=baseline, w_max=1.35)
        brain = learning(
            case["pre"], case["post"], case["dopamine"], modulation, weight=1 / TAU_D,
            rule=PAIRS | {"A_minus": 0.5}, **options,
        )  # fmt: skip
        if held:
            brain.hold_reward("pre-cell-excitatory", held)
        brain.run_until(150 * MS)
        saved = brain.snapshot()
        brain.hold_reward("pre-cell-excitatory", 1.0)
        brain.run_until(170 * MS)
        brain.restore(saved)
        brain.run_until(1000 * MS)
        found.append(np.subtract(state_of(brain), [0.0, 0.0, held]))
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert found[0][0] != pytest.approx(1.0, rel=0.1)


def test_a_reward_long_after_a_pair_brings_what_the_test_of_spynnaker_expects(
    learning: Callable[..., Brain],
) -> None:
    """The scenario and the formula of sPyNNaker's own test of neuromodulation, in exact times."""
    rule = PAIRS | {"tau_plus": 10.0, "tau_minus": 12.0, "w_max": 20.0, "A_plus": 1 / 20, "A_minus": 1 / 20}
    brain = learning(
        [1500.0, 2400.0], [1503.0], [1600.0], Neuromodulation(w_max=20.0), w0=0.0, weight=0.1, rule=rule
    )
    brain.run_until(2400 * MS)
    fade = 1 / 1000 + 1 / 200
    pair = exp(-4 / 10) * exp(-98 / 1000)
    assert state_of(brain)[0] == pytest.approx(pair * 0.1 * (1 - exp(-798 * fade)) / fade, rel=1e-9)


def test_weights_stay_while_learning_is_stopped(learning: Callable[..., Brain]) -> None:
    brain = learning([10.0], [20.0], [30.0], Neuromodulation(w_max=9.0), weight=0.1)
    wires, weights = "pre-cell-excitatory", []
    for plastic in (True, False, True):
        brain.set_plastic(wires, plastic)
        brain.run_until(brain.now_ns + 60 * MS)
        weights.append(brain.read_weights(wires)[0])
    first, second, third = weights
    assert first > 1.0
    assert second == first
    left = [exp(-(t - 32.0) * (1 / 1000 + 1 / 200)) for t in (60.0, 120.0, 180.0)]
    assert (third - second) / (first - 1.0) == pytest.approx((left[1] - left[2]) / (1 - left[0]), rel=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"modulation": Neuromodulation(tau_d=1.0)}, "'cell'.*tau_c"),
        ({"kind": "static", "plasticity": {}, "rule": {}}, "'cell'"),
        (
            {
                "plasticity": {**ADDITIVE, "timing_dependence": "Vogels2011Rule"},
                "rule": {"tau": 20.0, "eta": 1.0, "rho": 3.0, "w_min": 0.0, "w_max": 1.0},
            },
            "SpikePairRule.*Vogels2011Rule",
        ),
        (
            {
                "plasticity": {**ADDITIVE, "weight_dependence": "MultiplicativeWeightDependence"},
                "modulation": NEST, "other": NEST,
            },
            "AdditiveWeightDependence",
        ),
    ],
)  # fmt: skip
def test_rewards_that_nothing_can_learn_from_are_refused(
    change: dict,
    message: str,
    cells: Maker,
    spike_source: Maker,
    connect: Connect,
    open_brain: Open,
    golden: Golden,
) -> None:
    usual = Neuromodulation()
    ways = [
        replace(connect(one, "cell", 0.1, label=one), receptor=one, neuromodulation=modulation)
        for one, modulation in (
            ("reward", change.get("modulation", usual)), ("punishment", change.get("other", usual)),
        )
    ]  # fmt: skip
    rule = {"kind": STDP, "plasticity": ADDITIVE, **change.get("rule", PAIRS)}
    rule |= {name: change[name] for name in ("kind", "plasticity") if name in change}
    with golden.raises(CapabilityError, match=message):
        open_brain(
            *(spike_source(label, []) for label in ("pre", "reward", "punishment")),
            cells("cell", "IF_curr_exp"), connect("pre", "cell", 1.0, **rule), *ways,
        )  # fmt: skip


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("nothing", "no projection 'nothing'"),
        ("reward", "'reward' brings rewards"),
        ("drive-cell-excitatory", "static.*STDP"),
        ("drive-other-excitatory", "'other'"),
    ],
)
def test_only_synapses_that_learn_from_rewards_get_them(
    label: str,
    message: str,
    cells: Maker,
    spike_source: Maker,
    connect: Connect,
    open_brain: Open,
    golden: Golden,
) -> None:
    rule = {"kind": STDP, "plasticity": ADDITIVE, **PAIRS}
    brain = open_brain(
        spike_source("drive", []), cells("cell", "IF_curr_exp"), cells("other", "IF_curr_exp"),
        connect("drive", "cell", 1.0), connect("drive", "other", 1.0, **rule),
        connect("drive", "cell", 1.0, label="learning", **rule),
        replace(connect("drive", "cell", 1.0, label="reward"), receptor="reward",
                neuromodulation=Neuromodulation()),
    )  # fmt: skip
    with golden.raises(NetworkError, match=message):
        brain.reward(label, 1.0)
    with golden.raises(NetworkError):
        brain.reward("learning", float("nan"))
    brain.reward("learning", 1.0)
    assert brain.read_synapse_state("learning", "dopamine")[0] == 1.0
