"""Synapses that NESTML ships become laws in equations: weights as its statements change them."""

from __future__ import annotations

import sys
from collections.abc import Callable
from math import exp
from pathlib import Path

import numpy as np
import pytest
from nrp_core.pynn import new_simulator

from nrp_nestml.cell import model_of
from nrp_nestml.errors import NestmlError

MODELS = Path(sys.prefix) / "models/synapses"
DELAY_MS = 1.0
PRE_MS = [5.0, 9.0, 20.0, 31.0, 33.0, 60.0, 61.5]
POST_MS = [7.0, 8.2, 26.0, 40.0, 59.0]
Traces = dict[str, float]
Rule = Callable[[Traces], None]


def potentiated(s: Traces) -> None:
    s["w"] = min(100.0, 100.0 * (s["w"] / 100.0 + 0.01 * (1 - s["w"] / 100.0) * s["pre"]))


def depressed(s: Traces) -> None:
    s["w"] = max(0.0, 100.0 * (s["w"] / 100.0 - 0.01 * s["w"] / 100.0 * s["post"]))


def set_to(name: str, value: float, *, added: bool = False) -> Rule:
    def rule(s: Traces) -> None:
        s[name] = value + (s[name] if added else 0.0)

    return rule


def when(name: str, value: float, rule: Rule) -> Rule:
    return lambda s: rule(s) if s[name] == value else None


def triplet_post(s: Traces) -> None:
    s["w"] = min(100.0, s["w"] + s["pre"] * (7.5e-10 + 9.3e-3 * s["post2"]))


def triplet_pre(s: Traces) -> None:
    s["w"] = max(0.0, s["w"] - s["post"] * (7e-3 + 2.3e-4 * s["pre2"]))


PRE, POST = set_to("pre", 1.0, added=True), set_to("post", 1.0, added=True)
NEAREST_PRE, NEAREST_POST = set_to("pre", 1.0), set_to("post", 1.0)
EQUAL = {"pre": 20.0, "post": 20.0}
LAWS: dict[str, tuple[dict[str, float], list[Rule], list[Rule]]] = {
    "stdp": (EQUAL, [PRE, depressed], [POST, potentiated]),
    "stdp_nn_symm": (EQUAL, [NEAREST_PRE, depressed], [NEAREST_POST, potentiated]),
    "stdp_nn_pre_centered": (
        EQUAL, [PRE, depressed], [NEAREST_POST, potentiated, set_to("pre", 0.0)],
    ),
    "stdp_nn_restr_symm": (
        EQUAL,
        [NEAREST_PRE, when("open", 0.0, depressed), set_to("open", 1.0)],
        [NEAREST_POST, when("open", 1.0, potentiated), set_to("open", 0.0)],
    ),
    "stdp_triplet": (
        {"pre": 16.8, "pre2": 101.0, "post": 33.7, "post2": 125.0},
        [triplet_pre, PRE, set_to("pre2", 1.0, added=True)],
        [triplet_post, POST, set_to("post2", 1.0, added=True)],
    ),
}  # fmt: skip


def expected(name: str, until_ms: float, posts_ms: list[float]) -> float:
    """Return the weight after all spikes; one of the target reaches the synapse after the delay."""
    times_ms, on_pre, on_post = LAWS[name]
    s = {"w": 50.0, "open": 0.0, **dict.fromkeys(times_ms, 0.0)}
    events = sorted([(t, 1, on_pre) for t in PRE_MS] + [(t + DELAY_MS, 0, on_post) for t in posts_ms])
    now = 0.0
    for time_ms, _, rules in events:
        if time_ms > until_ms:
            break
        s |= {one: s[one] * exp((now - time_ms) / tau) for one, tau in times_ms.items()}
        now = time_ms
        for rule in rules:
            rule(s)
    return s["w"]


def test_weights_change_as_the_statements_say() -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    pre = sim.Population(1, sim.SpikeSourceArray(spike_times=PRE_MS))
    drive = sim.Population(1, sim.SpikeSourceArray(spike_times=[t - DELAY_MS for t in POST_MS]))
    cells = sim.Population(1, sim.IF_curr_delta(tau_refrac=0.1, v_thresh=1000.0))  # only `drive` reaches it
    sim.Projection(drive, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=5000.0, delay=DELAY_MS))
    cells.record("spikes")
    learned = {}
    for name in LAWS:
        law = sim.EquationSynapse(**model_of(MODELS / f"{name}_synapse.nestml"))
        learned[name] = sim.Projection(pre, cells, sim.OneToOneConnector(), law(weight=50.0, delay=DELAY_MS))
    sim.run(80.0)
    (train,) = cells.get_data().segments[0].spiketrains
    assert len(train) == len(POST_MS)
    for name, projection in learned.items():
        (weight,) = projection.get("weight", format="list", with_address=False)
        assert weight == pytest.approx(expected(name, 80.0, np.asarray(train).tolist()), rel=1e-9), name


def test_a_synapse_that_only_transmits_has_a_share_of_1() -> None:
    assert model_of(MODELS / "static_synapse.nestml")["on_pre"] == "share = 1.0"


@pytest.mark.parametrize(
    ("name", "told"),
    [("noisy", "random_normal"), ("tsodyks", "'dt' depends on"), ("neuromodulated_stdp", "mod_spikes")],
)
def test_other_synapses_are_refused_by_name(name: str, told: str) -> None:
    with pytest.raises(NestmlError, match=told):
        model_of(MODELS / f"{name}_synapse.nestml")
