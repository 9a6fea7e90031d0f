"""E-prop of the page on learning rules: the weights of NEST, and those of the sums that define it.

The rule is that of Bellec et al. (2020), Nat Commun 11:3625, as NEST 3.10 has it in ``eprop_synapse`` with
gradient descent: an update at each spike of the source, of all that happened since its last one.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from nrp_core._support.arrays import FloatArray

PAGE = Path(__file__).parents[3] / "docs/howto/write-a-learning-rule.md"
ALPHA, KAPPA, V_TH = np.exp(-1.0 / 20.0), 0.9, 0.6
RATE, TARGET = 0.01, 0.5


@pytest.fixture(scope="module")
def eprop() -> SimpleNamespace:
    """The first block of the page."""
    (block,) = re.findall(r"^```python\n(# eprop\.py\n.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(block, "eprop.py", "exec"), names)
    return SimpleNamespace(**names)


def learned(
    eprop: SimpleNamespace, times: list[list[float]], weights: dict[str, FloatArray], feedback: FloatArray,
    n_steps: int,
) -> list[dict[str, FloatArray]]:  # fmt: skip
    """Return the weights after each step, for a readout that should have 0.5 mV."""
    target, rate = np.full(n_steps, TARGET), np.full(n_steps, RATE)
    with eprop.open_brain(eprop.network(times, len(feedback), weights)) as brain:
        return [
            {label: learner.weights.copy() for label, learner in learners.items()}
            for learners, _ in eprop.learning(brain, weights, feedback, target, rate)
        ]


def test_one_synapse_has_the_weights_of_nest(eprop: SimpleNamespace) -> None:
    """Of NEST 3.10.0, from ``eprop_iaf`` and ``eprop_readout`` with delays of a step of 1 ms."""
    weights = {"in": np.array([[0.5]]), "out": np.array([[0.3]])}
    steps = learned(eprop, [[2.0, 12.0, 17.0, 32.0, 52.0]], weights, np.ones((1, 1)), 60)
    for t, expected in (
        (20, (0.597985721190398, 0.308190714919422)),
        (40, (0.666028494264261, 0.32577332292896)),
        (60, (0.754716137649735, 0.347846308889822)),
    ):
        found = steps[t - 1]
        assert (found["in"].item(), found["out"].item()) == pytest.approx(expected, rel=1e-9)


def by_sums(
    ticks: FloatArray, weights: dict[str, FloatArray], feedback: FloatArray
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Return the weights and the spikes of a network whose sources spike at ``ticks``, (steps, sources).

    Each update is a sum over all that has happened, without traces.
    """
    n_steps, n = len(ticks), len(feedback)
    weights = {label: w.copy() for label, w in weights.items()}
    z, psi, error = np.zeros((n_steps, n)), np.zeros((n_steps, n)), np.zeros(n_steps)
    v, y = np.zeros(n), 0.0
    last: dict[tuple[str, int], int] = {}
    for t in range(1, n_steps):
        v = ALPHA * v + weights["in"] @ ticks[t - 1] + weights["between"] @ z[t - 1]
        y = ALPHA * y + (weights["out"] @ z[t - 1]).item()
        psi[t] = 0.5 * np.maximum(0.0, 1.0 - np.abs(v - V_TH))
        z[t], error[t] = v >= V_TH, y - TARGET
        v = v - V_TH * z[t]
        for label, sources in (("in", ticks), ("between", z), ("out", z)):
            for i in np.flatnonzero(sources[t]).tolist():
                received = [
                    sum(ALPHA ** (u - 1 - s) * sources[s, i] for s in range(u)) for u in range(t)
                ]  # fmt: skip
                for u in range(last.get((label, i), 0), t):
                    if label == "out":
                        weights[label][:, i] -= RATE * error[u] * received[u]
                    else:
                        eligible = sum(KAPPA ** (u - k) * psi[k] * received[k] for k in range(u + 1))
                        weights[label][:, i] -= RATE * feedback[:, 0] * error[u + 1] * eligible
                last[label, i] = t
    return weights, z


def test_a_recurrent_network_has_the_weights_of_the_sums(eprop: SimpleNamespace) -> None:
    rng, n_steps = np.random.default_rng(5), 80
    ticks = rng.random((n_steps, 4)) < 0.12
    ticks[0] = False
    weights = {
        "in": rng.uniform(0.1, 0.4, (3, 4)),
        "between": rng.normal(0.0, 0.2, (3, 3)),
        "out": rng.normal(0.0, 0.2, (1, 3)),
    }
    feedback = rng.normal(0.0, 0.5, (3, 1))
    expected, z = by_sums(ticks.astype(float), weights, feedback)
    assert (z.sum(axis=0) > 3).all()
    times = [np.flatnonzero(train).astype(float).tolist() for train in ticks.T]
    found = learned(eprop, times, weights, feedback, n_steps - 1)[-1]
    for label, w in expected.items():
        assert found[label] == pytest.approx(w, rel=1e-9)
        assert np.abs(w - weights[label]).max() > 1e-3


def test_a_snapshot_has_the_weights_and_a_reset_undoes_them(eprop: SimpleNamespace) -> None:
    rng, n = np.random.default_rng(3), 3
    times = [np.flatnonzero(rng.random(90) < 0.2).astype(float).tolist() for _ in range(n)]
    weights = {"in": rng.uniform(0.1, 0.4, (n, n)), "between": rng.normal(0.0, 0.2, (n, n))}
    weights["out"] = rng.normal(0.0, 0.2, (1, n))
    network = eprop.network(times, n, weights)
    with eprop.open_brain(network) as brain:
        list(eprop.learning(brain, weights, np.ones((n, 1)), np.full(50, TARGET), np.full(50, RATE)))
        learned, snapshot = brain.read_weights("between"), brain.snapshot()

        def after(t_ms: int) -> FloatArray:
            brain.run_until(t_ms * 1_000_000)
            return np.concatenate([brain.read_state("v", network.ids_of("cells")), brain.read_weights("in")])

        once = after(80)
        brain.restore(snapshot)
        assert (brain.read_weights("between") == learned).all()
        assert (after(80) == once).all()
        assert (learned < 0.0).any()
        brain.reset()
        assert (brain.read_weights("between") == 0.0).all()
