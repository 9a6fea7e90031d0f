"""``nrp inspect`` of a network file: numbers of a small network that are counted by hand."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nrp_core.brain import builder
from nrp_core.network.data import Network
from nrp_core.network.files import save_network


def chain() -> Network:
    """Return five cells: 0 -> 1 -> 2, of which 2 inhibits 3 and 0; 4 has no synapse."""
    sim = builder()
    cells = sim.Population(5, sim.IF_curr_exp(), label="cells")
    for pairs, weight, receptor in (
        ([(0, 1), (1, 2)], 1.0, "excitatory"),
        ([(2, 3), (2, 0)], -1.0, "inhibitory"),
    ):
        connector = sim.FromListConnector([(*pair, weight, 1.0) for pair in pairs])
        sim.Projection(cells, cells, connector, receptor_type=receptor, label=receptor)
    views = {
        "first": np.array([0]),
        "last": np.array([3]),
        "alone": np.array([4]),
        "middle": np.array([1, 2]),
    }
    made: Network = sim.network()
    return replace(made, views=views)


@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_cells_signs_degrees_hubs_and_paths_are_counted(
    suffix: str, tmp_path: Path, nrp: Callable[..., Any]
) -> None:
    save_network(chain(), tmp_path / "chain.nrpnet")
    image = tmp_path / f"map{suffix}"
    done = nrp("inspect", tmp_path / "chain.nrpnet", "--image", image, "--json")
    found = json.loads(done.out)
    assert found["signs"] == {"excite": 2, "inhibit": 1, "both": 0, "neither": 2}
    assert found["out_degrees"] == [0, 0, 1, 1, 2]
    assert found["in_degrees"] == [0, 1, 1, 1, 1]
    assert next(iter(found["hubs"].items())) == ("middle (2)", 2)
    assert found["synapses_apart"] == {
        "middle": {"middle": 1, "first": 1, "last": 1},
        "first": {"middle": 1, "last": 3, "first": 3}, "last": {}, "alone": {},
    }  # fmt: skip
    assert image.read_bytes()[:5] in (b"<?xml", b"\x89PNG\r")


def test_only_a_network_is_drawn_as_svg(tmp_path: Path, nrp: Callable[..., Any]) -> None:
    save_network(chain(), tmp_path / "chain.nrpnet")
    assert nrp("inspect", tmp_path / "chain.nrpnet", "--image", tmp_path / "map.jpg").code == 2
    shown = nrp("inspect", tmp_path / "chain.nrpnet")
    assert shown.code == 0
    assert "synapses on the shortest path from first to: middle 1, first 3, last 3" in shown.out
