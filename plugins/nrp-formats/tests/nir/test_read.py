"""Trained networks emit the spikes of the framework that wrote them, and those of their equations."""

from __future__ import annotations

from itertools import pairwise
from math import exp
from pathlib import Path
from typing import Any

import h5py
import nir
import numpy as np
import pytest
from golden import Golden
from nrp_formats import load_nir, read_nir

from nrp_core import load_network
from nrp_core.checks.network_units import unlikely_units
from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator

NETWORKS = Path(__file__).parent / "networks"
DT = 1e-4


def emitted(
    path: Path, inputs: Any, extra: int = 20, **options: Any
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the spikes of each population at the steps of the file, and the populations."""
    sim = new_simulator()
    sim.setup(timestep=1.0, options={"resolution": "1 ms"})
    populations = load_nir(sim, path, **options)
    (source,) = [cells for cells in populations.values() if cells.annotations["kind"] == "Input"]
    source.set(spike_times=[np.flatnonzero(train) + 1.0 for train in inputs.T])
    for cells in populations.values():
        cells.record("spikes")
    sim.run(len(inputs) + float(extra))
    found = {}
    for name, cells in populations.items():
        found[name] = np.zeros((len(inputs), cells.size), bool)
        for cell, train in enumerate(cells.get_data().segments[0].spiketrains):
            steps = np.rint(np.asarray(train)).astype(int) - 1 - cells.annotations["lag"]
            found[name][steps[(steps >= 0) & (steps < len(inputs))], cell] = True
    return found, populations


@pytest.mark.parametrize(
    ("name", "refractory", "cells"),
    [("leaky", 0, (12, 3)), ("synaptic", 1, (12, 3)), ("convolutional", 0, (60, 3))],
)
def test_every_spike_is_that_of_snntorch(name: str, refractory: int, cells: tuple[int, int]) -> None:
    """The files and spikes are from ``nir/generate.py``."""
    expected = dict(np.load(NETWORKS / f"{name}.npz"))
    found, _ = emitted(
        NETWORKS / f"{name}.nir", expected.pop("inputs"), method="euler", refractory=refractory
    )
    assert tuple(spikes.shape[1] for spikes in expected.values()) == cells
    for layer, spikes in expected.items():
        assert spikes.sum() > 40
        assert np.array_equal(found[layer], spikes), layer
    if refractory:  # the comparison sees the one step in which snnTorch ignores a cell's input
        wrong, _ = emitted(
            NETWORKS / f"{name}.nir", np.load(NETWORKS / f"{name}.npz")["inputs"], method="euler"
        )
        assert not np.array_equal(wrong["1"], expected["1"])


def written(tmp_path: Path, nodes: dict[str, Any], edges: list[tuple[str, str]], n: int) -> Path:
    nodes = {"input": nir.Input(np.array([n])), **nodes, "output": nir.Output(np.array([1]))}
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, edges, type_check=False))
    return tmp_path / "net.nir"


def noise(n: int, steps: int = 80, seed: int = 5) -> Any:
    return np.random.default_rng(seed).random((steps, n)) < 0.3


def test_skips_delays_and_biases_arrive_in_the_step_of_the_file(tmp_path: Path) -> None:
    """The equations of two layers, a way past the first with a delay, a threshold without memory."""
    rng = np.random.default_rng(1)
    first, second, past = (rng.uniform(-0.5, 1.0, shape) for shape in ((3, 2), (2, 3), (2, 2)))
    bias, scale, delays = np.array([0.05, -0.02, 0.1]), np.array([0.5, 2.0]), np.array([0.0, 3 * DT])
    tau = np.array([10 * DT, 5 * DT, 20 * DT])
    each = np.ones(3)
    nodes = {
        "w1": nir.Affine(first, bias), "a": nir.LIF(tau, tau / DT, 0 * each, 0.6 * each, 0 * each),
        "w2": nir.Linear(second), "b": nir.IF(np.full(2, 1 / DT), np.full(2, 1.3), np.full(2, 0.2)),
        "w3": nir.Linear(past), "scale": nir.Scale(scale), "delay": nir.Delay(delays),
        "last": nir.Threshold(np.full(2, 0.5)),
    }  # fmt: skip
    edges = [
        ("input", "w1"), ("w1", "a"), ("a", "w2"), ("w2", "b"), ("input", "w3"),
        ("w3", "scale"), ("scale", "delay"), ("delay", "b"), ("b", "last"), ("last", "output"),
    ]  # fmt: skip
    inputs = noise(2)
    found, _ = emitted(written(tmp_path, nodes, edges, 2), inputs, method="exact")
    v, u, late = np.zeros(3), np.zeros(2), np.zeros((len(inputs) + 4, 2))
    kept = np.array([exp(-DT / t) for t in tau])
    for step, spikes in enumerate(inputs):
        v = kept * v + (1 - kept) * bias * tau / DT + first @ spikes
        fired = v > 0.6
        v[fired] = 0.0
        assert found["a"][step].tolist() == fired.tolist()
        sent = scale * (past @ spikes)
        late[step, 0] += sent[0]
        late[step + 3, 1] += sent[1]
        u += second @ fired + late[step]
        fired = u > 1.3
        u[fired] = 0.2
        assert found["b"][step].tolist() == fired.tolist()
        assert found["last"][step].tolist() == fired.tolist()
    assert found["b"].sum() > 10


def test_feedback_within_a_layer_takes_one_step(tmp_path: Path) -> None:
    """As in a subgraph that snnTorch and others write for a recurrent layer."""
    back, tau = np.array([[0.0, -0.7], [0.4, 0.0]]), np.full(2, 10 * DT)
    inner = nir.NIRGraph(
        {
            "in": nir.Input(np.array([2])), "lif": nir.LIF(tau, tau / DT, 0 * tau, np.ones(2), 0 * tau),
            "w": nir.Linear(back), "out": nir.Output(np.array([2])),
        },
        [("in", "lif"), ("lif", "w"), ("w", "lif"), ("lif", "out")],
        type_check=False,
    )  # fmt: skip
    nodes = {
        "rnn": inner,
        "sum": nir.Linear(np.array([[0.6, 0.6]])),
        "li": nir.LI(tau[:1], tau[:1] / DT, 0 * tau[:1]),
    }
    edges = [("input", "rnn"), ("rnn", "sum"), ("sum", "li"), ("li", "output")]
    inputs = noise(2)
    path = written(tmp_path, nodes, edges, 2)
    found, populations = emitted(path, inputs, extra=0, method="euler")
    v, before, output = np.zeros(2), np.zeros(2), 0.0
    for step, spikes in enumerate(inputs[:-2]):
        v = 0.9 * v + 1.0 * spikes + back @ before
        before = (v > 1.0).astype(float)
        v[before > 0] = 0.0
        assert found["rnn.lif"][step].tolist() == (before > 0).tolist()
        output = 0.9 * output + 0.6 * before.sum()
    assert populations["li"].annotations["lag"] == 2
    brain: Any = populations["li"]._simulator.state.brain
    assert brain.read_state("v", [int(populations["li"][0])])[0] == pytest.approx(output, rel=1e-5)


@pytest.mark.one_of(3)
@pytest.mark.parametrize("reset", ["value", "subtract"])
@pytest.mark.parametrize("refractory", [0, 1])
def test_feedback_through_a_current_takes_one_step(tmp_path: Path, reset: str, refractory: int) -> None:
    """The equations of NIR's CubaLIF in forward steps, as those of the recurrent networks of its paper."""
    rng, n = np.random.default_rng(3), 6
    inward, back, bias = (
        rng.uniform(-0.3, 1.2, (n, 3)),
        rng.uniform(-0.8, 0.5, (n, n)),
        rng.uniform(0, 0.3, n),
    )
    tau_syn, tau, w_in = rng.uniform(2.0, 9.0, n) * DT, rng.uniform(2.0, 9.0, n) * DT, rng.uniform(1, 3, n)
    rest, floor, top = np.full(n, 0.1), np.full(n, -0.2), np.full(n, 1.0)
    cells = nir.CubaLIF(tau_syn, tau, tau / DT, rest, top, w_in=w_in, v_reset=floor)
    nodes = {
        "w": nir.Affine(inward, bias), "a": cells, "back": nir.Linear(back), "w2": nir.Linear(np.eye(n)),
        "b": nir.Threshold(np.full(n, 0.5)),
    }  # fmt: skip
    edges = [
        ("input", "w"), ("w", "a"), ("a", "back"), ("back", "a"), ("a", "w2"), ("w2", "b"), ("b", "output"),
    ]  # fmt: skip
    inputs = noise(3, 300)
    path = written(tmp_path, nodes, edges, 3)
    found, _ = emitted(path, inputs, method="euler", refractory=refractory, reset=reset)
    i, v, fired, held = np.zeros(n), rest.copy(), np.zeros(n, bool), np.zeros(n, int)
    for step, spikes in enumerate(inputs):
        i += DT / tau_syn * (-i + w_in * (inward @ spikes + bias + back @ fired))
        v = np.where(held > 0, v, v + DT / tau * (rest - v + tau / DT * i))
        fired = (v > top) & (held == 0)
        held = np.where(fired, refractory, np.maximum(held - 1, 0))
        v = np.where(fired, floor if reset == "value" else v - top, v)
        assert found["a"][step].tolist() == fired.tolist(), step
    assert np.array_equal(found["a"], found["b"])
    assert found["a"].sum() > 100


def deep(tmp_path: Path, kinds: list[str], n: int = 3) -> tuple[Path, list[tuple[Any, ...]]]:
    """Write a chain of layers with biases of both signs, and return the parameters of each."""
    rng, layers, nodes, edges, before = np.random.default_rng(8), [], {}, [], "input"
    for k, kind in enumerate(kinds):
        matrix, bias = rng.uniform(-0.6, 1.0, (n, n)), rng.uniform(-1.5, 1.5, n)
        tau, tau_syn, w_in = (
            rng.uniform(1.2, 9.0, n) * DT,
            rng.uniform(1.2, 9.0, n) * DT,
            rng.uniform(0.5, 2, n),
        )
        top, rest, floor = rng.uniform(0.4, 1.0, n), np.full(n, 0.1), np.full(n, -0.1)
        nodes[f"w{k}"] = nir.Affine(matrix, bias)
        nodes[f"{k}"] = {
            "LIF": nir.LIF(tau, tau / DT, rest, top, floor),
            "IF": nir.IF(np.full(n, 1 / DT), top, floor),
            "CubaLIF": nir.CubaLIF(tau_syn, tau, tau / DT, rest, top, w_in=w_in, v_reset=floor),
            "Threshold": nir.Threshold(top),
        }[kind]
        edges += [(before, f"w{k}"), (f"w{k}", f"{k}")]
        before = f"{k}"
        layers.append((kind, matrix, bias, DT / tau, DT / tau_syn, w_in, top, rest, floor))
    return written(tmp_path, nodes, [*edges, (before, "output")], n), layers


@pytest.mark.parametrize(
    "kinds",
    [["LIF"] * 5, ["CubaLIF"] * 4, ["IF", "CubaLIF", "LIF", "CubaLIF", "IF"], ["Threshold"] * 12],
    ids=lambda kinds: "-".join(dict.fromkeys(kinds)),
)
def test_biases_of_later_layers_begin_in_the_step_of_the_file(tmp_path: Path, kinds: list[str]) -> None:
    """A bias that holds a cell down would lift it above its threshold in the steps before its lag."""
    path, layers = deep(tmp_path, kinds)
    inputs = noise(3, 40)
    found, _ = emitted(path, inputs, method="euler")
    v, i = [np.full(3, 0.1 if "LIF" in kind else 0.0) for kind in kinds], np.zeros((len(kinds), 3))
    for step, spikes in enumerate(inputs):
        sent = spikes.astype(float)
        for k, (kind, matrix, bias, leak, fade, w_in, top, rest, floor) in enumerate(layers):
            given = matrix @ sent + bias
            i[k] += fade * (w_in * given - i[k])
            kept = {"Threshold": 0.0 * v[k], "IF": v[k]}.get(kind, v[k] + leak * (rest - v[k]))
            v[k] = kept + (i[k] if kind == "CubaLIF" else given)
            fired = v[k] > top
            v[k] = np.where(fired, floor, v[k])
            sent = fired.astype(float)
            assert found[f"{k}"][step].tolist() == fired.tolist(), (k, step)
    assert sum(found[f"{k}"].sum() for k in range(len(kinds))) > 50


def test_pooling_and_one_dimension(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    kernel = rng.uniform(-1.0, 1.0, (4, 1, 2))
    nodes = {
        "conv": nir.Conv1d(8, kernel, 1, "valid", 2, 2, np.zeros(4)),
        "a": nir.Threshold(np.full((1, 4, 6), 0.3)),  # the pool sees one channel of 4 x 6
        "pool": nir.SumPool2d(np.array([2, 2]), np.array([2, 2]), np.array([0, 1])),
        "b": nir.Threshold(np.full((1, 2, 4), 1.5)),
    }
    edges = [("input", "conv"), ("conv", "a"), ("a", "pool"), ("pool", "b"), ("b", "output")]
    graph = nir.NIRGraph(
        {"input": nir.Input(np.array([2, 8])), **nodes, "output": nir.Output(np.array([8]))},
        edges,
        type_check=False,
    )
    nir.write(tmp_path / "net.nir", graph)
    inputs = noise(16, 30)
    found, _ = emitted(tmp_path / "net.nir", inputs)
    for step, spikes in enumerate(inputs):
        x = spikes.reshape(2, 8).astype(float)
        a = np.array(
            [
                [sum(kernel[o, 0, k] * x[o // 2, i + 2 * k] for k in range(2)) > 0.3 for i in range(6)]
                for o in range(4)
            ]
        )
        wide = np.pad(a.astype(float), ((0, 0), (1, 1)))
        b = [[wide[2 * i : 2 * i + 2, 2 * j : 2 * j + 2].sum() > 1.5 for j in range(4)] for i in range(2)]
        assert found["a"][step].tolist() == a.ravel().tolist()
        assert found["b"][step].tolist() == np.ravel(b).tolist()


def lif(n: int, tau: float = 10 * DT) -> Any:
    return nir.LIF(np.full(n, tau), np.full(n, tau / DT), np.zeros(n), np.ones(n), np.zeros(n))


def li(n: int) -> Any:
    return nir.LI(np.full(n, 10 * DT), np.ones(n), np.zeros(n))


WRONG = {
    "graded": (
        {"li": nir.CubaLI(*np.full((4, 1), 10 * DT)), "w": nir.Linear(np.ones((1, 1))), "lif": lif(1)},
        [("input", "li"), ("li", "w"), ("w", "lif"), ("lif", "output")],
        r"node 'lif' \(LIF\): its input comes from 'li' \(CubaLI\), which does not spike; only nodes LI",
    ),
    "current": (
        {"li": li(1), "lif": nir.CubaLIF(*np.full((3, 1), 10 * DT), np.zeros(1), np.ones(1))},
        [("input", "li"), ("li", "lif"), ("lif", "output")],
        r"node 'lif' \(CubaLIF\): .* 'li' \(LI\), .* such a node may drive I, IF, LI, LIF, Threshold",
    ),
    "both": (
        {"li": li(1), "lif": lif(1)},
        [("input", "li"), ("li", "lif"), ("input", "lif"), ("lif", "output")],
        r"node 'lif' \(LIF\): its input comes from 'li' \(LI\), .* and spikes reach it too",
    ),
    "three": (
        {"a": li(1), "b": li(1), "lif": lif(1)},
        [("input", "a"), ("a", "b"), ("b", "lif"), ("lif", "output")],
        r"node 'lif' \(LIF\): .* and it is itself driven by a node that does not",
    ),
    "rest": (
        {"w": nir.Affine(np.ones((1, 1)), np.ones(1)), "i": nir.I(np.ones(1)), "lif": lif(1)},
        [("input", "w"), ("w", "i"), ("i", "lif"), ("lif", "output")],
        r"node 'lif' \(LIF\): .* 'i' \(I\), .* and its constant input lets it rise without end",
    ),
    "leaks": (
        {"li": li(1), "i": nir.I(np.ones(1)), "lif": lif(1)},
        [("input", "li"), ("input", "i"), ("li", "lif"), ("i", "lif"), ("lif", "output")],
        r"node 'li' \(LI\): .* nodes LI with 0.001 s and from a node I, which does not leak",
    ),
    "times": (
        {
            "li": nir.LI(np.array([DT, 2 * DT]) * 10, np.ones(2), np.zeros(2)),
            "lif": lif(1),
            "w": nir.Linear(np.ones((2, 1))),
            "w2": nir.Linear(np.ones((1, 2))),
        },
        [("input", "w"), ("w", "li"), ("li", "w2"), ("w2", "lif"), ("lif", "output")],
        r"node 'li' \(LI\): .* cell 0 gets input from nodes LI with 0.001 s and 0.002 s",
    ),
    "loop": (
        {"w": nir.Linear(np.ones((1, 1))), "lif": lif(1)},
        [("input", "w"), ("w", "w"), ("w", "lif")],
        r"node 'w' \(Linear\): it is part of a loop without neurons",
    ),
    "shape": (
        {"w": nir.Linear(np.ones((1, 3))), "lif": lif(1)},
        [("input", "w"), ("w", "lif")],
        r"node 'w' \(Linear\): its weights of shape \(1, 3\) do not fit an input of shape \(1,\)",
    ),
    "short": (
        {"w": nir.Linear(np.ones((1, 1))), "lif": lif(1, 0.5 * DT)},
        [("input", "w"), ("w", "lif")],
        r"node 'lif' \(LIF\): a time constant is 5e-05 s; it must be at least the step, 0.0001 s",
    ),
    "alone": ({"lif": lif(1)}, [], r"node 'lif' \(LIF\): no edge leads to it"),
    "nan": (
        {"w": nir.Linear(np.array([[1.0], [np.nan]])), "lif": lif(2)},
        [("input", "w"), ("w", "lif")],
        r"node 'w' \(Linear\): weight\[1, 0\] is nan; it must be a finite number",
    ),
    "complex": (
        {"w": nir.Linear(np.ones((1, 1), complex)), "lif": lif(1)},
        [("input", "w"), ("w", "lif")],
        r"node 'w' \(Linear\): weight is complex; it must be real",
    ),
    "flags": (
        {"w": nir.Linear(np.ones((1, 1), bool)), "lif": lif(1)},
        [("input", "w"), ("w", "lif")],
        r"node 'w' \(Linear\): weight is of flags; it must be real",
    ),
    "few": (
        {"w": nir.Linear(np.ones((1, 1))), "lif": lif(2)},
        [("input", "w"), ("w", "lif")],
        r"node 'lif' \(LIF\): it has 2 cells, and 1 values lead to it",
    ),
    "many": (
        {"w": nir.Linear(np.ones((3, 1))), "lif": lif(2)},
        [("input", "w"), ("w", "lif")],
        r"node 'lif' \(LIF\): it has 2 cells, and 3 values lead to it",
    ),
    "reset": (
        {"lif": nir.LIF(np.full(1, DT), np.ones(1), np.zeros(1), np.ones(1), np.ones(1))},
        [("input", "lif")],
        r"node 'lif' \(LIF\): v_reset of cell 0 is 1; it must be less than its v_threshold, 1",
    ),
    "delay": (
        {"d": nir.Delay(np.array([1.5 * DT])), "lif": lif(1)},
        [("input", "d"), ("d", "lif")],
        r"node 'lif' \(LIF\): a delay of 0.00015 s on the way to it is not a multiple of the step",
    ),
}


@pytest.mark.parametrize(("nodes", "edges", "message"), WRONG.values(), ids=WRONG)
def test_an_impossible_node_is_named(tmp_path: Path, nodes: Any, edges: Any, message: str) -> None:
    with pytest.raises(NetworkError, match=message) as caught:
        emitted(written(tmp_path, nodes, edges, 1), noise(1), method="euler")
    assert "net.nir" in str(caught.value)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        (
            "w/type",
            "Affnie",
            "'w'.*'Affnie'.*'Affine'",
        ),
        ("lif/v_leak", [b"x"], r"'lif' \(LIF\): v_leak"),
    ],
)
def test_a_wrong_dataset_of_a_file_is_named(
    tmp_path: Path, field: str, value: object, message: str, golden: Golden
) -> None:
    nodes = {"w": nir.Linear(np.ones((1, 1))), "lif": lif(1)}
    path = written(tmp_path, nodes, [("input", "w"), ("w", "lif")], 1)
    with h5py.File(path, "r+") as file:
        del file[f"node/nodes/{field}"]
        file[f"node/nodes/{field}"] = value
    with golden.raises(NetworkError, match=message):
        emitted(path, noise(1), method="euler")


def test_a_file_is_a_brain_whose_inputs_devices_drive(tmp_path: Path, golden: Golden) -> None:
    from nrp_core.experiment.making.maker import network_from

    network = network_from(NETWORKS / "leaky.nir")
    assert set(network.populations) == {"input", "1", "3"}
    assert not network.populations["input"].is_source
    text = tmp_path / "text.nir"
    text.write_text("no network")
    with golden.raises(NetworkError, match="text.nir.*NIR"):
        network_from(text)
    script = tmp_path / "brain.py"
    script.write_text(
        "import pyNN.nest as sim\nfrom nrp_formats import load_nir\nsim.setup(timestep=1.0)\n"
        f"net = load_nir(sim, {str(NETWORKS / 'leaky.nir')!r}, inputs='cells')\nactors = net['3']\n"
    )
    assert load_network(script).views["actors"].size == 3


def _written(folder: Path, threshold: float, **metadata: object) -> Path:
    """Write a layer of two cells."""
    each = np.ones(2)
    cells = nir.LIF(tau=0.001 * each, r=each, v_leak=0 * each, v_threshold=threshold * each, v_reset=0 * each)
    nodes = {"eyes": nir.Input(np.array([3])), "weights": nir.Linear(np.ones((2, 3))), "wheels": cells,
             "output": nir.Output(np.array([2]))}  # fmt: skip
    nir.write(folder / "net.nir", nir.NIRGraph(nodes, [*pairwise(nodes)], metadata))
    return folder / "net.nir"


def test_an_infinite_threshold_is_not_another_unit(tmp_path: Path) -> None:
    network = read_nir(_written(tmp_path, np.inf))
    assert not [one for one in unlikely_units(network) if "v_thresh" in one]


def test_a_step_in_metadata_that_is_not_a_number_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match="'1 ms'"):
        read_nir(_written(tmp_path, 1.0, dt="1 ms"))
