"""Networks written as files of NIR have the spikes of the script, here and by the equations of the file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import nir
import numpy as np
import pytest
from nrp_formats import load_nir, save_nir
from nrp_formats.nir import save

from nrp_core import Network
from nrp_core.errors import NetworkError
from nrp_core.network.rewiring import Neuromodulation, Rewiring
from nrp_core.pynn import new_simulator

STEPS = 120
CELL = {"v_rest": -65.0, "v_reset": -67.0, "v_thresh": -50.0, "tau_refrac": 2.0}
SIZES = {"eyes": 4, "a": 6, "b": 3}
INPUTS = np.random.default_rng(3).random((STEPS, SIZES["eyes"])) < 0.25
TRAINS = [(np.flatnonzero(train) + 1.0).tolist() for train in INPUTS.T]


def network(sim: Any) -> dict[str, Any]:
    """Build two layers with feedback within and between them; delays are from 1 to 5 steps."""
    rng = np.random.default_rng(1)
    sim.setup(timestep=1.0, options={"resolution": "1 ms"})
    own = {"tau_m": rng.uniform(8.0, 20.0, 6).tolist(), "i_offset": rng.uniform(0.0, 0.5, 6).tolist()}
    types = {
        "eyes": sim.SpikeSourceArray(spike_times=TRAINS), "a": sim.IF_curr_delta(**own, **CELL),
        "b": sim.IF_curr_exp(tau_m=12.0, cm=0.5, tau_syn_E=3.0, tau_syn_I=3.0, **CELL),
    }  # fmt: skip
    cells = {name: sim.Population(SIZES[name], each, label=name) for name, each in types.items()}
    for name in "ab":
        cells[name].initialize(v=-65.0)
    ways = (("eyes", "a", 1), ("a", "b", 2), ("eyes", "b", 3), ("a", "a", 1), ("b", "a", 4))
    for pre, post, delay in ways:
        most = 8.0 if post == "a" else 2.5
        weights = rng.uniform(-0.4 * most, most, (SIZES[pre], SIZES[post]))
        for receptor, chosen in (("excitatory", weights > 0), ("inhibitory", weights < 0)):
            rows = [(i, j, weights[i, j], delay + i % 2) for i, j in np.argwhere(chosen)]
            sim.Projection(
                cells[pre],
                cells[post],
                sim.FromListConnector(rows),
                sim.StaticSynapse(),
                receptor_type=receptor,
            )
    return cells


def emitted(sim: Any, cells: dict[str, Any]) -> dict[str, Any]:
    """Return the spikes of each population by step and cell, in the time of the file."""
    for each in cells.values():
        each.record("spikes")
    sim.run(STEPS + 10.0)
    found = {name: np.zeros((STEPS, each.size), bool) for name, each in cells.items()}
    for name, each in cells.items():
        for cell, train in enumerate(each.get_data().segments[0].spiketrains):
            steps = np.rint(np.asarray(train)).astype(int) - 1 - each.annotations.get("lag", 0)
            found[name][steps[steps < STEPS], cell] = True
    return found


def read_back(path: Path) -> dict[str, Any]:
    sim = new_simulator()
    sim.setup(timestep=1.0, options={"resolution": "1 ms"})
    cells = load_nir(sim, path)
    cells["eyes"].set(spike_times=TRAINS)
    return emitted(sim, cells)


def stepped(path: Path) -> dict[str, Any]:
    """Return the spikes of a framework whose states decay by ``1 - dt/tau``; feedback takes a step."""
    graph = nir.read(path, type_check=False)
    dt = float(graph.metadata["dt"])
    refractory = int(graph.metadata["refractory"])
    after: dict[str, list[str]] = {}
    for start, end in graph.edges:
        after.setdefault(start, []).append(end)
    ways = []
    for pre in SIZES:
        for matrix in (
            name for name in after[pre] if name not in SIZES and hasattr(graph.nodes[name], "weight")
        ):
            (post,), delay = after[matrix], 0
            if isinstance(graph.nodes[post], nir.Delay):
                delay = round(float(graph.nodes[post].delay[0]) / dt)
                (post,) = after[post]
            ways.append((pre, post, graph.nodes[matrix], delay + (pre >= post and pre != "eyes")))
    spikes = {name: np.zeros((STEPS, size), bool) for name, size in SIZES.items()}
    spikes["eyes"][:] = INPUTS
    v, current = {n: np.zeros(SIZES[n]) for n in "ab"}, np.zeros(SIZES["b"])
    until = {name: np.zeros(SIZES[name]) for name in "ab"}
    for step in range(STEPS):
        for name in "ab":
            node, x = graph.nodes[name], np.zeros(SIZES[name])
            for pre, post, matrix, delay in ways:
                if post == name:
                    x += getattr(matrix, "bias", 0.0)
                    x += matrix.weight @ spikes[pre][step - delay] if step >= delay else 0.0
            if name == "b":
                current = (1 - dt / node.tau_syn) * current + node.w_in * dt / node.tau_syn * x
                x, tau = current, node.tau_mem
            else:
                tau = node.tau
            moved = v[name] + dt / tau * (node.v_leak - v[name] + node.r * x)
            v[name] = np.where(step >= until[name], moved, v[name])
            fired = v[name] > node.v_threshold
            spikes[name][step] = fired
            v[name][fired], until[name][fired] = node.v_reset[fired], step + 1 + refractory
    return spikes


@pytest.mark.parametrize("method", ["exact", "euler"])
def test_a_written_network_has_the_spikes_of_the_script(
    method: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = new_simulator()
    cells = network(sim)
    save_nir(sim.network(), tmp_path / "net.nir", method=method)
    monkeypatch.setattr(save, "returning", lambda *_: set())
    save_nir(sim.network(), tmp_path / "wrong.nir", method=method)
    expected = emitted(sim, cells)
    assert min(expected[name].sum() for name in "ab") > 50
    found = read_back(tmp_path / "net.nir")
    assert all(np.array_equal(found[name], expected[name]) for name in SIZES)
    if method == "euler":
        found = stepped(tmp_path / "net.nir")
        assert all(np.array_equal(found[name], expected[name]) for name in SIZES)
        wrong = stepped(tmp_path / "wrong.nir")  # without the step that feedback takes
        assert not np.array_equal(wrong["a"], expected["a"])


def refused(sim: Any, cell: Any, synapse: Any = None, at: float = 0.0, label: str = "cells") -> Network:
    sources = sim.Population(2, sim.SpikeSourcePoisson(rate=5.0), label="sources")
    cells = sim.Population(2, cell, label=label, initial_values={"v": at})
    synapse = synapse or sim.StaticSynapse(weight=0.1, delay=1.0)
    sim.Projection(sources, cells, sim.OneToOneConnector(), synapse, label="way")
    return sim.network()


def changed(network: Network, **parts: Any) -> Network:
    (way,) = network.projections
    return replace(network, projections=(replace(way, **parts),))


FITS = {"v_rest": 0.0, "tau_refrac": 0.0}
WRONG: dict[str, tuple[Any, str]] = {
    "conductances": (
        lambda sim: refused(sim, sim.IF_cond_exp(**FITS)),
        r"'cells' \(IF_cond_exp\): NIR has no node for its cell type; it has those of IF_curr_delta",
    ),
    "receptors": (
        lambda sim: refused(sim, sim.IF_curr_exp(tau_syn_E=2.0, tau_syn_I=3.0, **FITS)),
        r"'cells' \(IF_curr_exp\): a node CubaLIF has one tau_syn",
    ),
    "current": (
        lambda sim: refused(sim, sim.IF_curr_exp(i_offset=0.3, **FITS)),
        r"i_offset is 0.3 nA, and all inputs of a node CubaLIF pass through its tau_syn",
    ),
    "refractory": (
        lambda sim: refused(sim, sim.IF_curr_delta(v_rest=0.0)),
        r"tau_refrac is 0.1 ms, which is not a multiple of the step, 1 ms",
    ),
    "start": (
        lambda sim: refused(sim, sim.IF_curr_delta(**FITS), at=3.0),
        r"NIR has no initial values, and v of cell 0 starts at 3; .* initialize\(v=...\)",
    ),
    "plastic": (
        lambda sim: refused(sim, sim.IF_curr_delta(**FITS), sim.TsodyksMarkramSynapse(weight=0.1)),
        r"projection 'way': its synapses change \(tsodyks_markram\), and those of NIR do not",
    ),
    "rewired": (
        lambda sim: changed(refused(sim, sim.IF_curr_delta(**FITS)), rewiring=Rewiring()),
        r"projection 'way': its synapses change \(they form and vanish\), and those of NIR do not",
    ),
    "rewards": (
        lambda sim: changed(
            refused(sim, sim.IF_curr_delta(**FITS)), receptor="reward", neuromodulation=Neuromodulation()
        ),
        r"projection 'way': its spikes are a reward, and those of NIR are inputs",
    ),
    "delay": (
        lambda sim: refused(sim, sim.IF_curr_delta(**FITS), sim.StaticSynapse(weight=0.1, delay=1.5)),
        r"projection 'way': a delay of 1.5 ms is not a multiple of the step, 1 ms",
    ),
    "name": (
        lambda sim: refused(sim, sim.IF_curr_delta(**FITS), label="a/b"),
        r"population 'a/b': the name of a node cannot be empty or contain '/'",
    ),
    "sources": (lambda sim: sim.network(), "a network without sources has no input"),
}  # fmt: skip


@pytest.mark.parametrize(("build", "message"), WRONG.values(), ids=WRONG)
def test_a_network_that_does_not_fit_is_refused_by_name(build: Any, message: str, tmp_path: Path) -> None:
    sim = new_simulator()
    sim.setup(timestep=1.0)
    with pytest.raises(NetworkError, match=message):
        save_nir(build(sim), tmp_path / "net.nir")
    assert not (tmp_path / "net.nir").exists()
