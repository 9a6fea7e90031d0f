"""A leaky integrator before other nodes is their synaptic current."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import nir
import numpy as np
import pytest
from nrp_formats import load_nir

from nrp_core.pynn import new_simulator

DT, STEPS = 1e-4, 60
IN = np.random.default_rng(2).uniform(-0.3, 0.8, (4, 2))
OUT = np.random.default_rng(3).uniform(-0.2, 0.5, (3, 4))
TAU_LI, R_LI = 5 * DT, np.array([4.0, 5.0, 6.0, 3.0])
BIAS, DIRECT = np.array([0.1, -0.05, 0.0, 0.2]), np.array([0.02, 0.0, -0.1])


def written(
    tmp_path: Path, last: Any, tau_li: Any = TAU_LI, out: Any = OUT, rest: float = 0.0, first: Any = None
) -> Path:
    into = nir.Linear(IN) if first else nir.Affine(IN, BIAS)
    nodes = {
        "input": nir.Input(np.array([2])), "w": into,
        "li": first or nir.LI(np.full(4, tau_li), R_LI, np.full(4, rest)), "w2": nir.Affine(out, DIRECT),
        "last": last,
        "output": nir.Output(np.array([3])),
    }  # fmt: skip
    graph = nir.NIRGraph(nodes, list(pairwise(nodes)), type_check=False)
    nir.write(tmp_path / "net.nir", graph)
    return tmp_path / "net.nir"


def run(path: Path, inputs: Any, method: str) -> Any:
    """Return the populations after a run."""
    sim = new_simulator()
    sim.setup(timestep=1.0, options={"resolution": "1 ms"})
    cells = load_nir(sim, path, method=method)
    cells["input"].set(spike_times=[np.flatnonzero(train) + 1.0 for train in inputs.T])
    for name in ("li", "last"):
        cells[name].record(["v", "spikes"])
    sim.run(STEPS + 10.0)
    return cells


def spikes(cells: Any) -> Any:
    found = np.zeros((STEPS, cells.size), bool)
    for cell, train in enumerate(cells.get_data().segments[0].spiketrains):
        steps = np.rint(np.asarray(train)).astype(int) - 1 - cells.annotations["lag"]
        found[steps[(steps >= 0) & (steps < STEPS)], cell] = True
    return found


def voltages(cells: Any) -> Any:
    lag = cells.annotations["lag"]
    v = cells.get_data().segments[0].filter(name="v")[0].magnitude
    return v[1 + lag : 1 + lag + STEPS]


def integrated(inputs: Any, tau: Any = TAU_LI) -> Any:
    """Return the voltages of the node LI in steps of ``1 - dt/tau``, from their inputs on."""
    v, found = np.zeros(4), []
    for x in inputs:
        v = v + DT / tau * (R_LI * (IN @ x + BIAS) - v)
        found.append(v)
    return np.array(found)


def noise() -> Any:
    return np.random.default_rng(5).random((STEPS, 2)) < 0.4


def lif() -> Any:
    full = np.ones(3)
    return nir.LIF(full * 10 * DT, full * 12.0, 0 * full, full, 0 * full)


@pytest.mark.parametrize("each", [False, True], ids=["all alike", "each its own"])
def test_cells_behind_an_integrator_emit_the_spikes_of_the_equations(tmp_path: Path, each: bool) -> None:
    inputs = noise()
    tau, out = (np.array([5.0, 8.0, 12.0, 5.0]) * DT, np.eye(3, 4) * 0.3) if each else (TAU_LI, OUT)
    cells = run(written(tmp_path, lif(), tau, out), inputs, "euler")
    v, expected = np.zeros(3), []
    for graded in integrated(inputs, tau):
        v = v + 0.1 * (12.0 * (out @ graded + DIRECT) - v)
        expected.append(v > 1.0)
        v = np.where(v > 1.0, 0.0, v)
    assert np.array_equal(spikes(cells["last"]), expected)
    assert np.sum(expected) > 20
    assert voltages(cells["li"]) == pytest.approx(integrated(inputs, tau), abs=1e-6)  # it is there to be read


def test_an_integrator_of_an_integrator_is_its_output(tmp_path: Path) -> None:
    inputs, full = noise(), np.ones(3)
    cells = run(written(tmp_path, nir.LI(full * 10 * DT, full * 2.0, 0 * full)), inputs, "euler")
    v, expected = np.zeros(3), []
    for graded in integrated(inputs):
        v = v + 0.1 * (2.0 * (OUT @ graded + DIRECT) - v)
        expected.append(v)
    assert voltages(cells["last"]) == pytest.approx(np.array(expected), abs=1e-6)


@pytest.mark.parametrize("method", ["euler", "exact"])
def test_a_threshold_of_an_integrator_fires_while_it_is_above(tmp_path: Path, method: str) -> None:
    inputs, limits = noise(), np.array([0.5, 0.8, 0.2])
    cells = run(written(tmp_path, nir.Threshold(limits)), inputs, method)
    kept = 1 - DT / TAU_LI if method == "euler" else np.exp(-DT / TAU_LI)
    v, expected = np.zeros(4), []
    for x in inputs:
        # the pulse of a spike is short; a constant input rises with the time constant
        constant = (1 - kept) * R_LI * BIAS
        v = kept * v + R_LI * DT / TAU_LI * (IN @ x) + constant
        expected.append(OUT @ v + DIRECT > limits)
    found = spikes(cells["last"])
    assert np.array_equal(found, expected)
    assert 20 < found.sum() < found.size - 20


def test_exact_currents_are_those_of_the_differential_equations(tmp_path: Path) -> None:
    inputs, full = np.zeros((STEPS, 2), bool), np.ones(3)
    inputs[3, 0] = True
    node = nir.LI(full * 10 * DT, full * 2.0, 0 * full)
    cells = run(written(tmp_path, node), inputs, "exact")
    reached = voltages(cells["last"])
    t = np.arange(STEPS)[:, None] * DT
    kick = OUT @ (R_LI * DT / TAU_LI * IN[:, 0])
    since = np.maximum(t - 3 * DT, 0.0)
    tau = 10 * DT
    pulse = 2.0 * kick * TAU_LI / (tau - TAU_LI) * (np.exp(-since / tau) - np.exp(-since / TAU_LI))
    settled, after = OUT @ (R_LI * BIAS), t + DT
    rises = (
        2.0 * settled * (1 + (TAU_LI * np.exp(-after / TAU_LI) - tau * np.exp(-after / tau)) / (tau - TAU_LI))
    )
    constant = 2.0 * DIRECT * (1 - np.exp(-after / tau))
    assert reached == pytest.approx(pulse + rises + constant, abs=1e-6)


@pytest.mark.parametrize("method", ["euler", "exact"])
def test_the_rest_of_an_integrator_equals_a_constant_input(tmp_path: Path, method: str) -> None:
    inputs, full, found = noise(), np.ones(3), []
    node = nir.LI(full * 10 * DT, full * 2.0, 0 * full)
    for rest in (0.0, 0.25):
        cells = run(written(tmp_path, node, rest=rest), inputs, method)
        found.append((voltages(cells["li"]), voltages(cells["last"])))
    steps = np.arange(1, STEPS + 1)[:, None]
    kept = 1 - 0.1 if method == "euler" else np.exp(-0.1)
    assert found[1][0] - found[0][0] == pytest.approx(np.full((STEPS, 4), 0.25), abs=1e-6)
    expected = 2.0 * (OUT @ np.full(4, 0.25)) * (1 - kept**steps)
    assert found[1][1] - found[0][1] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("fires", [True, False])
def test_cells_without_a_leak_integrate_a_current(tmp_path: Path, fires: bool) -> None:
    inputs, rise = noise(), 0.5 if fires else 0.1
    full = np.full(3, rise / DT)
    last = nir.IF(full, np.ones(3), np.zeros(3)) if fires else nir.I(full)
    cells = run(written(tmp_path, last), inputs, "euler")
    v, spiked, reached = np.zeros(3), [], []
    for graded in integrated(inputs):
        v = v + rise * (OUT @ graded + DIRECT)
        spiked.append((v > 1.0) & fires)
        v = np.where(spiked[-1], 0.0, v)
        reached.append(v)
    assert np.array_equal(spikes(cells["last"]), spiked)
    assert not fires or np.sum(spiked) > 20
    assert voltages(cells["last"]) == pytest.approx(np.array(reached), abs=1e-6)


def test_a_current_without_a_leak_integrates_and_rises_in_a_cell_as_its_equation(tmp_path: Path) -> None:
    inputs = np.zeros((STEPS, 2), bool)
    inputs[3, 0] = True
    full = np.full(3, 3.0)
    node = nir.I(full)
    cells = run(written(tmp_path, node, first=nir.I(R_LI)), inputs, "exact")
    since = np.maximum(np.arange(STEPS)[:, None] - 3, 0) * DT
    kick = OUT @ (R_LI * DT * IN[:, 0])
    constant = 3.0 * DIRECT * (np.arange(STEPS)[:, None] + 1) * DT
    assert voltages(cells["last"]) == pytest.approx(3.0 * kick * since + constant, abs=1e-9)


def test_a_layer_follows_a_current_without_a_leak(tmp_path: Path) -> None:
    inputs = noise()
    out = np.random.default_rng(4).uniform(-0.2, 0.25, (3, 4))
    cells = run(written(tmp_path, lif(), out=out, first=nir.I(0.2 / DT * np.ones(4))), inputs, "euler")
    v, graded, expected = np.zeros(3), np.zeros(4), []
    for x in inputs:
        graded = graded + 0.2 * (IN @ x)
        v = v + 0.1 * (12.0 * (out @ graded + DIRECT) - v)
        expected.append(v > 1.0)
        v = np.where(v > 1.0, 0.0, v)
    assert np.array_equal(spikes(cells["last"]), expected)
    assert 20 < np.sum(expected) < np.size(expected) - 20
