"""Trained networks whose cells cannot fire are reported; those that fire by their last input are not."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import nir
import numpy as np
import pytest
from golden import Golden
from nrp_formats import read_nir

from nrp_core.checks.network_units import unlikely_units
from nrp_core.errors import NetworkError

DT = 1e-4
KEPT = 0.9  # of a voltage in a step: it rises to 10 times what comes in each step


def _remarks(
    folder: Path, weight: float, current_based: bool, bias: float = 0.0, is_joined: bool = True
) -> list[str]:
    tau, each = np.full(2, DT / (1.0 - KEPT)), np.ones(2)
    membrane = {"r": tau / DT, "v_leak": 0 * each, "v_threshold": each, "v_reset": 0 * each}
    cells = (
        nir.CubaLIF(tau_syn=tau, tau_mem=tau, w_in=tau / DT, **membrane)
        if current_based
        else nir.LIF(tau=tau, **membrane)
    )
    nodes = {
        "eyes": nir.Input(np.array([3])),
        "weights": nir.Affine(np.full((2, 3), weight), np.full(2, bias)),
        "wheels": cells,
        "output": nir.Output(np.array([2])),
    }
    edges = [("weights", "wheels"), ("wheels", "output")]
    edges += [("eyes", "weights")] if is_joined else []
    nir.write(folder / "net.nir", nir.NIRGraph(nodes, edges))
    return list(read_nir(folder / "net.nir").remarks)


@pytest.mark.parametrize(
    ("weight", "current_based", "bias", "found"),
    [
        (0.034, False, 0.0, False),  # three inputs in every step: 10 * 3 * 0.034 is 1.02, above 1
        (0.030, False, 0.0, True),
        (-0.6, False, 0.0, True),
        (-0.6, False, 0.2, False),
        (0.0034, True, 0.0, False),
        (0.0025, True, 0.0, True),
    ],
)
def test_a_node_that_no_input_makes_fire_is_reported(
    tmp_path: Path, weight: float, current_based: bool, bias: float, found: bool
) -> None:
    remarks = _remarks(tmp_path, weight, current_based, bias)
    assert len(remarks) == found
    assert all("no cell of 'wheels' can fire: all inputs together, in every step" in one for one in remarks)


@pytest.mark.parametrize(
    ("fires", "found"), [(True, ["no cell of 'wheels' can fire: its threshold is inf"]), (False, [])]
)
def test_cells_with_an_infinite_threshold_are_reported_and_integrators_are_not(
    tmp_path: Path, fires: bool, found: list[str]
) -> None:
    each = np.ones(2)
    membrane = {"tau": DT / (1.0 - KEPT) * each, "r": each, "v_leak": 0 * each}
    cells = nir.LIF(**membrane, v_threshold=np.inf * each, v_reset=0 * each) if fires else nir.LI(**membrane)
    nodes = {"eyes": nir.Input(np.array([3])), "weights": nir.Linear(np.ones((2, 3))), "wheels": cells,
             "output": nir.Output(np.array([2]))}  # fmt: skip
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, [*pairwise(nodes)]))
    network = read_nir(tmp_path / "net.nir")
    assert list(network.remarks) == found
    assert not [one for one in unlikely_units(network) if "v_thresh" in one]  # no cell is in uV


def test_a_time_constant_shorter_than_a_step_is_reported(tmp_path: Path, golden: Golden) -> None:
    _remarks(tmp_path, 0.6, False)
    graph = nir.read(tmp_path / "net.nir")
    for dt, words in (
        (1e-3, None),
        (0.01, "'wheels' (LIF) is 0.001 s, shorter than a step of the file, 0.01 s"),
    ):
        graph.metadata["dt"] = dt
        nir.write(tmp_path / "net.nir", graph)
        found = [one for one in read_nir(tmp_path / "net.nir").remarks if "shorter" in one]
        assert [words is not None and words in one for one in found] == [True] * (words is not None)
    graph.metadata["dt"] = "1 ms"
    nir.write(tmp_path / "net.nir", graph)
    with golden.raises(NetworkError, match="'1 ms'"):
        read_nir(tmp_path / "net.nir")


def test_an_input_that_reaches_no_cell_is_reported(tmp_path: Path) -> None:
    """The library puts inputs before nodes without one, so nothing else is missing."""
    assert _remarks(tmp_path, 0.034, False) == []
    assert "the input 'eyes' reaches no cell" in _remarks(tmp_path, 0.034, False, is_joined=False)


@pytest.mark.parametrize(
    ("edges", "words"),
    [
        ([("eyes", "loose")], "no edge leaves the node 'loose' (Linear)"),
        ([], "no edge leads to the node 'loose' (Linear)"),
        ([("eyes", "loose"), ("loose", "wheels")], None),
    ],
)
def test_a_node_without_edges_is_reported(
    tmp_path: Path, edges: list[tuple[str, str]], words: str | None
) -> None:
    tau, each = np.full(2, DT / (1.0 - KEPT)), np.ones(2)
    nodes = {
        "eyes": nir.Input(np.array([3])),
        "weights": nir.Linear(np.ones((2, 3))),
        "loose": nir.Linear(np.ones((2, 3))),
        "wheels": nir.LIF(tau=tau, r=tau / DT, v_leak=0 * each, v_threshold=each, v_reset=0 * each),
        "output": nir.Output(np.array([2])),
    }
    always = [("eyes", "weights"), ("weights", "wheels"), ("wheels", "output")]
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, [*always, *edges], type_check=False))
    assert list(read_nir(tmp_path / "net.nir").remarks) == ([words] if words else [])


@pytest.mark.parametrize(("start", "is_told"), [("wheels", False), ("weights", True)])
def test_an_output_of_no_cell_is_reported(tmp_path: Path, start: str, is_told: bool) -> None:
    tau, each = np.full(2, DT / (1.0 - KEPT)), np.ones(2)
    nodes = {
        "eyes": nir.Input(np.array([3])),
        "weights": nir.Affine(np.full((2, 3), 0.5), np.zeros(2)),
        "wheels": nir.LIF(tau=tau, r=tau / DT, v_leak=0 * each, v_threshold=each, v_reset=0 * each),
        "output": nir.Output(np.array([2])),
    }
    edges = [("eyes", "weights"), ("weights", "wheels"), (start, "output")]
    nir.write(tmp_path / "net.nir", nir.NIRGraph(nodes, edges))
    found = "the output 'output' is that of no cell: 'weights' (Affine) leads to it"
    assert list(read_nir(tmp_path / "net.nir").remarks) == [found] * is_told
