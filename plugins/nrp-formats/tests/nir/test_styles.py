"""Files as different frameworks and versions write them.

Each style was read from the exporter of a framework; the files are made here. The expected spikes are those
of the equations in steps, computed by NumPy.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import nir
import numpy as np
import pytest
from golden import Golden
from nrp_formats import load_nir
from scipy.signal import correlate

from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator

DT, STEPS = 1e-4, 60


def emitted(path: Path, inputs: dict[str, Any], method: str = "euler", **options: Any) -> dict[str, Any]:
    """Return the spikes of each population at the steps of the file."""
    sim = new_simulator()
    sim.setup(timestep=1.0, options={"resolution": "1 ms"})
    cells = load_nir(sim, path, method=method, **options)
    for name, trains in inputs.items():
        cells[name].set(spike_times=[np.flatnonzero(train) + 1.0 for train in trains.T])
    for each in cells.values():
        each.record("spikes")
    sim.run(STEPS + 20.0)
    found = {name: np.zeros((STEPS, each.size), bool) for name, each in cells.items()}
    for name, each in cells.items():
        for cell, train in enumerate(each.get_data().segments[0].spiketrains):
            steps = np.rint(np.asarray(train)).astype(int) - 1 - each.annotations["lag"]
            found[name][steps[(steps >= 0) & (steps < STEPS)], cell] = True
    return found


def written(tmp_path: Path, nodes: dict[str, Any], edges: Any) -> Path:
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, list(edges), type_check=False))
    return tmp_path / "net.nir"


def noise(n: int, seed: int = 5) -> Any:
    return np.random.default_rng(seed).random((STEPS, n)) < 0.3


def fired(drive: Any, beta: float, threshold: Any) -> Any:
    """Return the spikes of ``v = beta v + drive`` with a reset to 0."""
    spikes, v = np.zeros(drive.shape, bool), np.zeros(drive.shape[1:])
    for step, x in enumerate(drive):
        v = beta * v + x
        spikes[step] = v > threshold
        v[spikes[step]] = 0.0
    return spikes


def lif(shape: Any, beta: float = 0.9, threshold: Any = 1.0, kind: type = np.float32, **more: Any) -> Any:
    """Return a node as snnTorch writes it: ``tau = dt / (1 - beta)`` and ``r = tau / dt``."""
    full = np.ones(shape, kind)
    tau = full * DT / (1.0 - beta)
    return nir.LIF(tau=tau, r=tau / DT, v_leak=0 * full, v_threshold=full * np.asarray(threshold), **more)


WEIGHT = np.random.default_rng(2).uniform(-0.3, 0.8, (3, 2))
KERNEL = np.random.default_rng(3).uniform(-0.4, 0.8, (2, 1, 3, 3))
CHAIN = [("input", "w"), ("w", "cells"), ("cells", "output")]


def chain(cells: Any, weight: Any = WEIGHT) -> dict[str, Any]:
    ends = {"input": nir.Input(np.array([2])), "output": nir.Output(np.array([3]))}
    return {**ends, "w": nir.Linear(weight), "cells": cells}


@pytest.mark.parametrize("shape", [(3,), (1,), (1, 3)], ids=["each", "one value", "batch of one"])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_parameters_may_be_one_value_or_have_a_dimension_of_the_batch(
    tmp_path: Path, shape: Any, kind: type
) -> None:
    inputs = noise(2)
    found = emitted(written(tmp_path, chain(lif(shape, kind=kind)), CHAIN), {"input": inputs})
    assert np.array_equal(found["cells"], fired(inputs @ WEIGHT.T, 0.9, 1.0))
    assert found["cells"].sum() > 10


def convolutional(node: Any, cells: Any) -> dict[str, Any]:
    return {
        "input": nir.Input(np.array([1, 4, 5])),
        "w": node,
        "cells": cells,
        "output": nir.Output(np.array([2])),
    }


def convolved(images: Any, before: Any, after: Any) -> Any:
    wide = np.pad(images.reshape(-1, 4, 5).astype(float), ((0, 0), *zip(before, after, strict=True)))
    return np.stack([[correlate(x, kernel[0], "valid") for kernel in KERNEL] for x in wide])


def conv(padding: Any, extent: Any = (4, 5)) -> Any:
    return nir.Conv2d(extent, KERNEL, 1, padding, 1, 1, np.zeros(2))


def test_parameters_may_hold_for_all_cells_of_a_channel(tmp_path: Path) -> None:
    threshold = np.array([[[0.5]], [[1.5]]])
    inputs = noise(20)
    path = written(tmp_path, convolutional(conv(0), lif((2, 1, 1), threshold=threshold)), CHAIN)
    expected = fired(convolved(inputs, (0, 0), (0, 0)), 0.9, threshold)
    assert np.array_equal(emitted(path, {"input": inputs})["cells"], expected.reshape(STEPS, -1))
    assert expected[:, 0].sum() > expected[:, 1].sum() > 10


@pytest.mark.parametrize(
    ("padding", "before", "after"),
    [
        (1, (1, 1), (1, 1)),
        ((1, 0), (1, 0), (1, 0)),
        ("same", (1, 1), (1, 1)),
        ("valid", (0, 0), (0, 0)),
        (np.array([[1, 1], [0, 0]]), (1, 0), (1, 0)),
        (np.array([[0, 1], [2, 0]]), (0, 2), (1, 0)),
    ],
    ids=["number", "pair", "same", "valid", "pairs", "uneven pairs"],
)
def test_padding_may_be_given_in_each_form(tmp_path: Path, padding: Any, before: Any, after: Any) -> None:
    inputs = noise(20)
    drive = convolved(inputs, before, after)
    simple = padding if not isinstance(padding, np.ndarray) else 0
    path = written(tmp_path, convolutional(conv(simple), lif(drive.shape[1:])), CHAIN)
    if simple is not padding:  # the library itself cannot write it
        with h5py.File(path, "a") as file:
            del file["node/nodes/w/padding"]
            file["node/nodes/w/padding"] = padding
    expected = fired(drive, 0.9, 1.0)
    assert np.array_equal(emitted(path, {"input": inputs})["cells"], expected.reshape(STEPS, -1))
    assert expected.sum() > 50


def test_files_of_early_versions_lack_what_later_ones_have(tmp_path: Path) -> None:
    inputs = noise(20)
    drive = convolved(inputs, (0, 0), (0, 0))
    path = written(tmp_path, convolutional(conv(0), lif(drive.shape[1:])), CHAIN)
    with h5py.File(path, "a") as file:
        for name in ("version", "node/nodes/w/input_shape", "node/nodes/cells/v_reset"):
            del file[name]
    expected = fired(drive, 0.9, 1.0)
    assert np.array_equal(emitted(path, {"input": inputs})["cells"], expected.reshape(STEPS, -1))


def test_an_edge_may_name_one_of_several_inputs_of_a_subgraph(tmp_path: Path, golden: Golden) -> None:
    part = {
        "left": nir.Input(np.array([2])), "right": nir.Input(np.array([2])), "a": nir.Linear(WEIGHT),
        "b": nir.Linear(-WEIGHT), "cells": lif(3), "out": nir.Output(np.array([3])),
    }  # fmt: skip
    inner = [("left", "a"), ("right", "b"), ("a", "cells"), ("b", "cells"), ("cells", "out")]
    graph = {
        "x": nir.Input(np.array([2])), "y": nir.Input(np.array([2])),
        "part": nir.NIRGraph(part, inner, type_check=False), "output": nir.Output(np.array([3])),
    }  # fmt: skip
    x, y = noise(2), noise(2, seed=6)
    path = written(tmp_path, graph, [("x", "part.left"), ("y", "part.right"), ("part", "output")])
    found = emitted(path, {"x": x, "y": y})
    assert np.array_equal(found["part.cells"], fired(x @ WEIGHT.T - y @ WEIGHT.T, 0.9, 1.0))
    path = written(tmp_path, graph, [("x", "part"), ("y", "part.right"), ("part", "output")])
    with golden.raises(NetworkError, match="'part'"):
        emitted(path, {})


def test_cells_with_feedback_are_a_subgraph_as_in_snntorch_and_rockpool(tmp_path: Path) -> None:
    feedback = np.random.default_rng(4).uniform(-0.5, 0.3, (3, 3))
    part = {
        "input": nir.Input(np.array([3])), "lif": lif(3), "w_rec": nir.Linear(feedback),
        "output": nir.Output(np.array([3])),
    }  # fmt: skip
    inner = [("input", "lif"), ("lif", "w_rec"), ("w_rec", "lif"), ("lif", "output")]
    inputs = noise(2)
    found = emitted(written(tmp_path, chain(nir.NIRGraph(part, inner)), CHAIN), {"input": inputs})
    v, last = np.zeros(3), np.zeros(3)
    for step, x in enumerate(inputs):
        v = 0.9 * v + WEIGHT @ x + feedback @ last
        last = (v > 1.0).astype(float)
        v[v > 1.0] = 0.0
        assert found["cells.lif"][step].tolist() == last.astype(bool).tolist()


def test_names_and_order_of_nodes_do_not_matter(tmp_path: Path) -> None:
    names = ["10", "2_Linear", "1.b", "layer-0"]
    nodes = dict(zip(names, chain(lif(3)).values(), strict=True))
    order = [names[0], names[2], names[3], names[1]]  # input, weights, cells, output
    inputs = noise(2)
    shuffled = {name: nodes[name] for name in sorted(nodes, reverse=True)}
    found = emitted(written(tmp_path, shuffled, pairwise(order)), {"10": inputs})
    assert np.array_equal(found["layer-0"], fired(inputs @ WEIGHT.T, 0.9, 1.0))


def subtracted(drive: Any, beta: float, *, later: bool) -> Any:
    """Return the spikes of cells that subtract their threshold of 1, after the next decay or before it."""
    spikes, v = np.zeros(drive.shape, bool), np.zeros(drive.shape[1:])
    for step, x in enumerate(drive):
        before = spikes[step - 1] if later and step else 0.0
        v = beta * v + x - before
        spikes[step] = v > 1.0
        v = v - (0.0 if later else spikes[step])
    return spikes


@pytest.mark.parametrize("reset", ["subtract", "subtract_next"])
@pytest.mark.parametrize("beta", [0.9, 0.5])
def test_cells_may_subtract_their_threshold(tmp_path: Path, reset: str, beta: float) -> None:
    inputs = noise(2)
    path = written(tmp_path, chain(lif(3, beta, kind=np.float64), 2.0 * WEIGHT), CHAIN)
    found = emitted(path, {"input": inputs}, reset=reset)["cells"]
    drive = 2.0 * inputs @ WEIGHT.T
    expected = subtracted(drive, beta, later=reset == "subtract_next")
    assert np.array_equal(found, expected)
    others = fired(drive, beta, 1.0), subtracted(drive, beta, later=reset != "subtract_next")
    assert not any(np.array_equal(expected, other) for other in others)


@pytest.mark.parametrize("later", [False, True])
def test_cells_with_a_current_and_without_a_leak_subtract_too(tmp_path: Path, later: bool) -> None:
    alpha, beta, full = 0.6, 0.9, np.ones(3)
    tau_syn, tau = full * DT / (1 - alpha), full * DT / (1 - beta)
    first = nir.CubaLIF(tau_syn, tau, tau / DT, 0 * full, full, 0 * full, tau_syn / DT)
    second = nir.IF(full / DT, full, 0 * full)
    nodes = {**chain(first), "w2": nir.Linear(np.diag([0.7, 0.4, 0.9])), "last": second}
    edges = [("input", "w"), ("w", "cells"), ("cells", "w2"), ("w2", "last"), ("last", "output")]
    inputs = noise(2)
    path = written(tmp_path, nodes, edges)
    found = emitted(path, {"input": inputs}, reset="subtract_next" if later else "subtract")
    current, drive = np.zeros(3), np.zeros((STEPS, 3))
    for step, x in enumerate(inputs @ WEIGHT.T):
        current = alpha * current + x
        drive[step] = current
    expected = subtracted(drive, beta, later=later)
    assert np.array_equal(found["cells"], expected)
    assert np.array_equal(found["last"], subtracted(expected * [0.7, 0.4, 0.9], 1.0, later=later))
    assert 10 < found["last"].sum() < expected.sum()


def test_metadata_that_say_subtract_are_asked_about(tmp_path: Path) -> None:
    graph = nir.NIRGraph(chain(lif(3)), CHAIN, metadata={"reset_mechanism": "subtract"})
    nir.write(tmp_path / "net.nir", graph)
    for reset, told in ((None, 1), ("subtract", 0)):
        sim = new_simulator()
        sim.setup(timestep=1.0)
        load_nir(sim, tmp_path / "net.nir", reset=reset)
        assert sum("cells subtract their threshold" in text for text in sim.network().remarks) == told


def test_another_reset_is_refused(tmp_path: Path, golden: Golden) -> None:
    path = written(tmp_path, chain(lif(3)), CHAIN)
    with golden.raises(NetworkError, match="'subtrct'.*'subtract'"):
        emitted(path, {}, reset="subtrct")


@pytest.mark.parametrize(
    "bias", [0.0, np.array([[0.1, 0.0, -0.05], [0.0, 0.2, 0.1]])], ids=["linear", "affine"]
)
def test_weights_of_three_dimensions_are_a_matrix_for_each_row_of_the_input(
    tmp_path: Path, bias: Any
) -> None:
    weight = np.random.default_rng(4).uniform(-0.3, 0.9, (2, 3, 4))
    map_ = nir.Affine(weight, bias) if np.ndim(bias) else nir.Linear(weight)
    ends = {"input": nir.Input(np.array([2, 4])), "output": nir.Output(np.array([2, 3]))}
    path = written(tmp_path, {**ends, "w": map_, "cells": lif(1)}, CHAIN)
    inputs = noise(8)
    found = emitted(path, {"input": inputs})["cells"]
    expected = fired(np.einsum("boi,tbi->tbo", weight, inputs.reshape(STEPS, 2, 4)) + bias, 0.9, 1.0)
    assert np.array_equal(found, expected.reshape(STEPS, 6))
    assert expected.sum() > 20


def test_a_graph_without_an_input_is_refused_and_its_first_node_named(tmp_path: Path, golden: Golden) -> None:
    path = written(tmp_path, {"w": nir.Linear(WEIGHT), "cells": lif(3)}, [("w", "cells")])
    with golden.raises(NetworkError, match="'w'"):
        emitted(path, {})


def subtracting(drive: Any, decay: float) -> Any:
    """Return the spikes of ``v = decay v + drive`` whose threshold of 1 is subtracted."""
    spikes, v = np.zeros(drive.shape), np.zeros(drive.shape[1:])
    for step, x in enumerate(drive):
        v = decay * v + x
        spikes[step] = v >= 1.0
        v -= spikes[step]
    return spikes


def filtered(frames: Any, weight: Any, stride: int = 1) -> Any:
    return np.stack(
        [[correlate(x, kernel, "valid")[0, ::stride, ::stride] for kernel in weight] for x in frames]
    )


@pytest.mark.parametrize("tau", [None, 8.0])
def test_convolutions_in_the_style_of_sinabs_count_times_in_steps(tmp_path: Path, tau: float | None) -> None:
    """Times are in steps, inputs of LIF last for one of them, thresholds are subtracted, biases are 0."""
    rng = np.random.default_rng(4)
    decay, gain = (1.0, 1.0) if tau is None else (np.exp(-1.0 / tau), 1.0 - np.exp(-1.0 / tau))
    strong = 1.0 if tau is None else 9.0
    first, second = strong * rng.normal(0.05, 0.2, (3, 2, 3, 3)), strong * rng.normal(0.08, 0.2, (4, 3, 2, 2))
    last = strong * rng.normal(0.1, 0.3, (5, 4))

    def cells(*shape: int) -> Any:
        one, none = np.ones(shape), np.zeros(shape)
        if tau is None:
            return nir.IF(r=one, v_threshold=one, v_reset=none)
        return nir.LIF(tau=np.float32(tau), r=np.float32(1), v_leak=np.float32(0), v_threshold=np.float32(1),
                       v_reset=np.float32(0))  # fmt: skip

    nodes = {
        "input": nir.Input(np.array([2, 8, 8])),
        "0": nir.Conv2d((8, 8), first, (1, 1), (0, 0), (1, 1), 1, np.zeros(3)),
        "1": cells(3, 6, 6),
        "2": nir.SumPool2d(np.array([2, 2]), np.array([2, 2]), np.array([0, 0])),
        "3": nir.Conv2d((3, 3), second, (2, 2), (0, 0), (1, 1), 1, np.zeros(4)),
        "4": cells(4, 1, 1),
        "5": nir.Flatten({"input": np.array([4, 1, 1])}, 0, -1),
        "6": nir.Affine(last, np.zeros(5)),
        "7": cells(5),
        "output": nir.Output(np.array([5])),
    }
    nir.write(
        tmp_path / "net.nir", nir.NIRGraph(nodes, [*pairwise(nodes)], type_check=False), compression=None
    )
    frames = noise(128).reshape(STEPS, 2, 8, 8).astype(float)
    one = subtracting(gain * filtered(frames, first), decay)
    pooled = one.reshape(STEPS, 3, 3, 2, 3, 2).sum((3, 5))
    two = subtracting(gain * filtered(pooled, second, 2), decay)
    three = subtracting(gain * two.reshape(STEPS, 4) @ last.T, decay)
    found = emitted(
        tmp_path / "net.nir", {"input": frames.reshape(STEPS, -1)}, "held", dt=1.0, reset="subtract"
    )
    for name, spikes in (("1", one), ("4", two), ("7", three)):
        assert spikes.sum() > 20
        assert (found[name] == spikes.reshape(STEPS, -1)).all()


@pytest.mark.parametrize("is_weighted", [False, True])
def test_integrators_before_cells_in_the_style_of_sinabs_pass_on_values_that_last(
    tmp_path: Path, is_weighted: bool
) -> None:
    rng, n = np.random.default_rng(0), 3
    slow, fast = np.exp(-1.0 / np.array([6.0, 9.0]))
    one, none = np.ones(n), np.zeros(n)
    first, second = (
        5.0 * rng.normal(0.8, 0.5, (n, n)),
        rng.normal(0.8, 0.5, (n, n)) if is_weighted else np.eye(n),
    )
    nodes = {
        "input": nir.Input(np.array([n])), "first": nir.Linear(first),
        "kept": nir.LI(tau=6.0 * one, r=one, v_leak=none), "second": nir.Linear(second),
        "cells": nir.LIF(tau=9.0 * one, r=one, v_leak=none, v_threshold=one, v_reset=none),
        "output": nir.Output(np.array([n])),
    }  # fmt: skip
    nodes = {name: node for name, node in nodes.items() if is_weighted or name != "second"}
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, [*pairwise(nodes)], type_check=False))
    frames = (rng.random((STEPS, n)) < 0.5).astype(float)
    kept = np.zeros((STEPS + 1, n))
    for step, x in enumerate(frames):
        kept[step + 1] = slow * kept[step] + (1.0 - slow) * first @ x
    expected = subtracting((1.0 - fast) * kept[1:] @ second.T, fast)
    found = emitted(tmp_path / "net.nir", {"input": frames}, "held", dt=1.0, reset="subtract")
    assert expected.sum() > 20
    assert (found["cells"] == expected).all()
