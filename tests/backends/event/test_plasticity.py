"""Plasticity by the times of spikes against the rules written down spike by spike, exact and on a grid."""

import pickle
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import exp

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_brain_event import EventBackend, EventOptions
from pyNN.standardmodels import cells as standard

from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS, from_milliseconds, milliseconds
from nrp_core.errors import CapabilityError, NetworkError, SnapshotError
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.pynn import builder
from nrp_core.network.synapses import STDP

ADDITIVE = {"timing": "SpikePairRule", "weight": "AdditiveWeightDependence"}
COMPOSED = [
    ADDITIVE,
    {"timing": "SpikePairRule", "weight": "MultiplicativeWeightDependence"},
    {"timing": "SpikePairRule", "weight": "AdditivePotentiationMultiplicativeDepression"},
    {"timing": "SpikePairRule", "weight": "GutigWeightDependence"},
    {"timing": "Vogels2011Rule", "weight": "AdditiveWeightDependence"},
    {"timing": "PfisterSpikeTripletRule", "weight": "AdditiveWeightDependence"},
]
RULE = {"A_plus": 0.1, "A_minus": 0.12, "tau_plus": 20.0, "tau_minus": 15.0, "w_min": 0.1, "w_max": 1.0}
RULE |= {"mu_plus": 0.3, "mu_minus": 0.7, "tau": 25.0, "eta": 0.05, "rho": 10.0}
RULE |= {"tau_x": 90.0, "tau_y": 110.0, "A3_plus": 0.07, "A3_minus": 0.04}
FORCE_MV, START = 100.0, 0.5


@dataclass
class Pairing:
    """One plastic synapse on a cell that fires whenever it is forced to, at those very times."""

    pre_ms: list[float]
    post_ms: list[float]
    delay_ms: float = 1.0
    dendritic: float = 1.0
    rule: dict[str, float] = field(default_factory=lambda: RULE)
    plasticity: dict[str, str] = field(default_factory=lambda: ADDITIVE)
    receptor: str = "excitatory"
    step_ms: float = 0.0
    """Of a grid; 0 for the exact mode."""

    def open(self) -> Brain:
        names = standard.IF_curr_delta.default_parameters
        given = {name: np.full(1, value) for name, value in {**names, "tau_refrac": 0.0}.items()}
        sources = [
            Population(label, 1, "SpikeSourceArray", {}, {}, (np.array(times, float) - early_ms,))
            # on a grid a spike travels for a step at least
            for label, times, early_ms in (("pre", self.pre_ms, 0.0), ("force", self.post_ms, self.step_ms))
        ]
        cell = Population("cell", 1, "IF_curr_delta", given)
        sign = 1 if self.receptor == "excitatory" else -1
        plastic = self._synapse("pre", sign * START, self.delay_ms, self.receptor, STDP, self.plasticity)
        populations = {part.label: part for part in (*sources, cell)}
        network = Network(populations, (plastic, self._synapse("force", FORCE_MV, 0.0, "excitatory")))
        options = EventOptions.model_validate({"resolution": f"{self.step_ms} ms"} if self.step_ms else {})
        return EventBackend().open(network, seed=1, options=options)

    def _synapse(
        self, pre: str, weight: float, delay_ms: float, receptor: str, kind: str = "static",
        plasticity: dict[str, str] | None = None,
    ) -> Projection:  # fmt: skip
        index = np.zeros(1, np.int32)
        values = {**self.rule, "dendritic_delay_fraction": self.dendritic} if kind == STDP else {}
        arrays = {name: np.full(1, value) for name, value in values.items()}
        return Projection(
            pre, pre, "cell", receptor, index, index, np.full(1, weight), np.full(1, delay_ms), kind, arrays,
            plasticity or {},
        )  # fmt: skip

    def expected(self, until_ms: float, gates_ms: list[float] = []) -> float:  # noqa: B006
        """Return the weight after all spikes that the synapse has seen, one by one.

        At the first gate learning stops, at the next one it continues, and so on.
        """
        rule, weight, changed = self.rule, START, _CHANGES[self.plasticity["timing"]]
        mu_plus, mu_minus = _POWERS[self.plasticity["weight"]]
        back = self.dendritic * self.delay_ms
        forth = self.delay_ms - back
        # at one time the target comes first, unless it fires only after the spike has arrived there
        posts = [(t + back, 0 if back else 2, "post") for t in self.post_ms]
        seen = sorted([*posts, *((t + forth, 1, "pre") for t in self.pre_ms)])
        past: dict[str, list[float]] = {"pre": [], "post": []}
        for t, _, side in seen:
            if t > until_ms:
                break
            change = changed(rule, t, past, side)
            distance, mu = (
                (rule["w_max"] - weight, mu_plus) if side == "post" else (weight - rule["w_min"], mu_minus)
            )
            if sum(gate < t for gate in gates_ms) % 2 == 0:
                weight += change * rule["w_max"] * (distance / rule["w_max"]) ** mu
                weight = min(max(weight, rule["w_min"]), rule["w_max"])
            past[side].append(t)
        return weight


def _sum(past: list[float], t: float, tau_ms: float, *, at_t: bool = False) -> float:
    """Return the trace of a train, spike by spike."""
    return sum(exp((other - t) / tau_ms) for other in past if at_t or t - other > 1e-9)


def _pairs(rule: dict[str, float], t: float, past: dict[str, list[float]], side: str) -> float:
    if side == "post":
        return rule["A_plus"] * _sum(past["pre"], t, rule["tau_plus"])
    return -rule["A_minus"] * _sum(past["post"], t, rule["tau_minus"])


def _vogels(rule: dict[str, float], t: float, past: dict[str, list[float]], side: str) -> float:
    near = _sum(past["pre" if side == "post" else "post"], t, rule["tau"], at_t=True)
    target = 2.0 * rule["rho"] * rule["tau"] / 1000.0 if side == "pre" else 0.0
    return rule["eta"] * (near - target) / rule["w_max"]  # eta is a weight, not a share of one


def _triplets(rule: dict[str, float], t: float, past: dict[str, list[float]], side: str) -> float:
    if side == "post":
        before = rule["A3_plus"] * _sum(past["post"], t, rule["tau_y"])
        return _sum(past["pre"], t, rule["tau_plus"]) * (rule["A_plus"] + before)
    before = rule["A3_minus"] * _sum(past["pre"], t, rule["tau_x"])
    return -_sum(past["post"], t, rule["tau_minus"]) * (rule["A_minus"] + before)


_CHANGES = {"SpikePairRule": _pairs, "Vogels2011Rule": _vogels, "PfisterSpikeTripletRule": _triplets}
_POWERS = {
    "AdditiveWeightDependence": (0.0, 0.0),
    "MultiplicativeWeightDependence": (1.0, 1.0),
    "AdditivePotentiationMultiplicativeDepression": (0.0, 1.0),
    "GutigWeightDependence": (RULE["mu_plus"], RULE["mu_minus"]),
}


BOTH = pytest.mark.parametrize("step_ms", [0.0, 0.25], ids=["exact", "grid"])


@pytest.mark.parametrize(
    ("gap_ms", "change"), [(5.0, 0.1 * exp(-0.25)), (-6.0, -0.12 * exp(-0.4)), (0.0, 0.0)]
)
@BOTH
def test_a_pair_changes_the_weight_by_the_time_between_its_spikes(
    gap_ms: float, change: float, step_ms: float
) -> None:
    brain = Pairing([20.0], [19.0 + gap_ms], step_ms=step_ms).open()
    brain.run_until(from_milliseconds(60.0))
    assert brain.read_weights("pre")[0] == pytest.approx(START + change, abs=1e-12)


times = st.lists(st.integers(1, 400).map(lambda tenths: tenths / 4), max_size=12, unique=True).map(sorted)


@given(
    pre_ms=times, post_ms=times, delay_ms=st.sampled_from([0.25, 1.0, 7.5, 30.0]),
    dendritic=st.sampled_from([0.0, 0.25, 1.0]), plasticity=st.sampled_from(COMPOSED),
    stops=st.lists(st.integers(1, 150 * NS_PER_MS), max_size=4).map(sorted),
    step_ms=st.sampled_from([0.0, 0.25]), sign=st.sampled_from([1.0, -1.0]),
)  # fmt: skip
@settings(max_examples=120)
def test_weights_are_those_of_all_spikes_whatever_the_delay_and_whenever_one_looks(
    pre_ms: list[float], post_ms: list[float], delay_ms: float, dendritic: float,
    plasticity: dict[str, str], stops: list[int], step_ms: float, sign: float,
) -> None:  # fmt: skip
    rule = (
        RULE
        | {"w_max": 1.25}
        | {name: sign * RULE[name] for name in ("A_plus", "A_minus", "A3_plus", "A3_minus", "eta")}
    )
    pairing = Pairing(pre_ms, post_ms, delay_ms, dendritic, rule, plasticity, step_ms=step_ms)
    if step_ms:
        stops = [stop - stop % from_milliseconds(step_ms) for stop in stops]
    brain = pairing.open()
    for stop_ns in [*stops, 150 * NS_PER_MS]:
        brain.run_until(stop_ns)
        assert brain.read_weights("pre")[0] == pytest.approx(
            pairing.expected(milliseconds(stop_ns)), abs=1e-9
        )


@given(
    pre_ms=times, post_ms=times, delay_ms=st.sampled_from([0.25, 7.5]),
    dendritic=st.sampled_from([0.0, 0.25, 1.0]), plasticity=st.sampled_from(COMPOSED),
    gates=st.lists(st.integers(1, 500), max_size=4, unique=True).map(sorted),
    step_ms=st.sampled_from([0.0, 0.25]),
)  # fmt: skip
@settings(max_examples=60)
def test_learning_that_is_stopped_leaves_traces_and_no_change(
    pre_ms: list[float], post_ms: list[float], delay_ms: float, dendritic: float,
    plasticity: dict[str, str], gates: list[int], step_ms: float,
) -> None:  # fmt: skip
    pairing = Pairing(pre_ms, post_ms, delay_ms, dendritic, RULE, plasticity, step_ms=step_ms)
    gates_ms = [gate / 4 + (0.0 if step_ms else 0.1) for gate in gates]
    brain = pairing.open()
    for k, gate_ms in enumerate(gates_ms):
        brain.run_until(from_milliseconds(gate_ms))
        brain.set_plastic("pre", k % 2 == 1)
        assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(gate_ms, gates_ms), abs=1e-9)
    brain.run_until(from_milliseconds(150.0))
    assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(150.0, gates_ms), abs=1e-9)


@BOTH
def test_a_reset_and_a_snapshot_restore_whether_synapses_learn(step_ms: float) -> None:
    pairing = Pairing([20.0, 40.0, 60.0], [25.0, 45.0, 65.0], 4.0, 0.5, step_ms=step_ms)
    brain = pairing.open()
    brain.run_until(from_milliseconds(30.0))
    brain.set_plastic("pre", False)
    brain.run_until(from_milliseconds(46.0))
    frozen = brain.snapshot()
    brain.set_plastic("pre", True)
    brain.run_until(from_milliseconds(100.0))
    assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(100.0, [30.0, 46.0]))
    brain.restore(frozen)
    assert not brain.is_plastic("pre")
    brain.run_until(from_milliseconds(100.0))
    assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(100.0, [30.0]))
    brain.reset()
    assert brain.is_plastic("pre")
    brain.run_until(from_milliseconds(100.0))
    assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(100.0))


@BOTH
def test_only_projections_that_learn_can_stop_learning(step_ms: float, golden: Golden) -> None:
    brain = Pairing([20.0], [25.0], step_ms=step_ms).open()
    with golden.raises(NetworkError, match="'force'"):
        brain.set_plastic("force", False)
    assert brain.is_plastic("pre")
    assert not brain.is_plastic("force")


@BOTH
def test_a_spike_arrives_with_the_weight_that_it_found_at_the_synapse(step_ms: float) -> None:
    pairing = Pairing([20.0, 40.0], [24.0], delay_ms=2.0, step_ms=step_ms)
    brain = pairing.open()
    gap_ms = step_ms or 1e-6
    brain.run_until(from_milliseconds(42.0 - gap_ms))
    before = brain.read_state("v", [2])[0]
    brain.run_until(from_milliseconds(42.0))
    after = brain.read_state("v", [2])[0]
    faded = -65.0 + (before + 65.0) * exp(-gap_ms / 20.0)
    assert after - faded == pytest.approx(pairing.expected(45.0), abs=1e-9)


@BOTH
def test_a_long_train_is_not_stored_for_ever_and_nothing_is_lost(step_ms: float) -> None:
    """Many spikes of the target between two of the synapse, with a long delay in the dendrite."""
    post_ms = [10.0 + 0.5 * i for i in range(2000)]
    small = RULE | {"A_plus": 1e-5, "A_minus": 2e-5}
    pairing = Pairing([5.0, 300.0, 1009.0], post_ms, delay_ms=40.0, rule=small, step_ms=step_ms)
    brain = pairing.open()
    brain.run_until(from_milliseconds(1100.0))
    assert brain.read_weights("pre")[0] == pytest.approx(pairing.expected(1100.0), abs=1e-10)
    memories = brain._grid.memories if step_ms else brain._engine.cells
    assert 0 < memories["n_stored"][0] < 300


@BOTH
def test_inhibitory_weights_keep_their_sign_and_their_limits(step_ms: float) -> None:
    pairing = Pairing([20.0], [24.0], receptor="inhibitory", step_ms=step_ms)
    brain = pairing.open()
    brain.run_until(from_milliseconds(60.0))
    assert brain.read_weights("pre")[0] == pytest.approx(-pairing.expected(60.0))


@BOTH
def test_a_snapshot_keeps_weights_traces_and_spikes_in_transit(step_ms: float) -> None:
    pairing = Pairing([20.0, 31.0, 33.0, 60.0], [24.0, 31.5, 58.0], 4.0, 0.5, step_ms=step_ms)
    brain = pairing.open()
    brain.run_until(from_milliseconds(33.5))
    snapshot = brain.snapshot()
    brain.run_until(from_milliseconds(90.0))
    expected = brain.read_weights("pre")
    brain.restore(snapshot)
    brain.run_until(from_milliseconds(90.0))
    assert brain.read_weights("pre") == expected
    brain.reset()
    assert brain.read_weights("pre") == START


@BOTH
def test_changed_weights_go_on_from_where_they_were_set(step_ms: float) -> None:
    """A spike on its way keeps the weight with which it passed; older pairs are done."""
    brain = Pairing([20.0, 50.0], [30.0, 52.0], delay_ms=5.0, step_ms=step_ms).open()
    brain.run_until(from_milliseconds(52.0))
    height = brain.read_weights("pre")[0]
    brain.set_weights("pre", 0.7)
    before = brain.read_state("v", [2])[0]
    brain.run_until(from_milliseconds(55.0))
    settled = -65.0 + (before + 65.0) * exp(-3.0 / 20.0)
    assert brain.read_state("v", [2])[0] - settled == pytest.approx(height, abs=1e-9)
    assert brain.read_weights("pre")[0] == 0.7
    brain.run_until(from_milliseconds(90.0))
    traces = exp(-7.0 / 20.0) + exp(-37.0 / 20.0)
    assert brain.read_weights("pre")[0] == pytest.approx(0.7 + 0.1 * traces)


def test_rules_that_are_not_known_and_limits_that_cannot_be_are_refused(golden: Golden) -> None:
    with golden.raises(
        CapabilityError,
        match="'pre'.*ClopathRule.*SpikePairRule",
    ):
        Pairing([], [], plasticity=ADDITIVE | {"timing": "ClopathRule"}).open()
    with golden.raises(NetworkError, match=r"w_min.*0 \(0 -> 0\)"):
        Pairing([], [], rule=RULE | {"w_min": 2.0}).open()
    with golden.raises(NetworkError, match="'tau_plus'"):
        Pairing([], [], rule={name: v for name, v in RULE.items() if name != "tau_plus"}).open()


def test_two_neurons_can_be_plastic_on_each_other(
    cells: Callable[..., Population], connect: Callable[..., Projection], open_brain: Callable[..., Brain],
) -> None:  # fmt: skip
    """Spikes of neurons, not of sources: each finds the weights as its own window leaves them."""
    both = connect(
        "cells", "cells", 0.2, [1.5, 0.5], pairs=[(0, 1), (1, 0)], kind=STDP, plasticity=ADDITIVE,
        label="both", **RULE,
    )  # fmt: skip
    whole, split = (
        open_brain(cells("cells", "IF_curr_exp", 2, i_offset=[1.7, 1.9], tau_m=10.0), both) for _ in range(2)
    )
    whole.run_until(from_milliseconds(300.0))
    for t_ms in np.arange(0.37, 300.0, 0.37):
        split.run_until(from_milliseconds(t_ms))
    split.run_until(from_milliseconds(300.0))
    weights = whole.read_weights("both")
    assert (weights != 0.2).all()
    assert (weights == split.read_weights("both")).all()


def test_a_snapshot_of_a_version_with_longer_records_is_refused() -> None:
    with Pairing([20.0], [25.0]).open() as brain:
        saved = brain.snapshot()
        *rest, state, began, frozen, changed = pickle.loads(saved.payload)
        del state["slow"]
        with pytest.raises(SnapshotError):
            brain.restore(replace(saved, payload=pickle.dumps((*rest, state, began, frozen, changed))))


@BOTH
def test_all_synapses_share_one_record_of_slow_traces_that_they_do_not_use(step_ms: float) -> None:
    pairs, triplets = ADDITIVE, COMPOSED[-1]
    for plasticity, n in ((pairs, 1), (triplets, 2)):
        sim = builder()
        sources = sim.Population(2, sim.SpikeSourceArray(spike_times=[5.0, 9.0]))
        cells = sim.Population(1, sim.IF_curr_exp(i_offset=1.0))
        rule = getattr(sim, plasticity["timing"])()
        law = sim.STDPMechanism(timing_dependence=rule, weight_dependence=sim.AdditiveWeightDependence())
        sim.Projection(sources, cells, sim.AllToAllConnector(), law)
        options = EventOptions.model_validate({"resolution": f"{step_ms} ms"} if step_ms else {})
        with EventBackend().open(sim.network(), seed=1, options=options) as brain:
            arrays = brain._grid if step_ms else brain._engine  # type: ignore[attr-defined]
            assert len(arrays.slow) == n
            assert arrays.plastic.itemsize == 56
