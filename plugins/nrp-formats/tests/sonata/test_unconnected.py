"""SONATA circuits that are valid, and in which something connects or drives nothing."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from golden import Golden
from nrp_formats.sonata import read_sonata
from sonata_circuits import write_circuit

from nrp_core.errors import NetworkError


@pytest.fixture
def circuit(tmp_path: Path) -> Path:
    """A circuit of six nodes and three virtual ones."""
    return write_circuit(tmp_path)


def _without(circuit: Path, edges: list[object] | None) -> None:
    config = json.loads(circuit.read_text())
    if edges is None:
        del config["networks"]["edges"]
    else:
        config["networks"]["edges"] = edges
    circuit.write_text(json.dumps(config))


@pytest.mark.parametrize("edges", [None, []])
def test_a_circuit_without_edges_says_so(edges: list[object] | None, circuit: Path) -> None:
    _without(circuit, edges)
    (remark,) = read_sonata(circuit).remarks
    assert remark == "the circuit has no edges: 'networks' of its configuration has no 'edges'"


def test_a_file_without_populations_of_edges_is_named(circuit: Path) -> None:
    with h5py.File(circuit.parent / "edges.h5", "r+") as file:
        del file["edges/lgn_to_v1"]
    assert read_sonata(circuit).remarks == ("edges.h5 has no population of edges: it connects nothing",)


def test_a_population_of_no_edges_is_named(circuit: Path) -> None:
    with h5py.File(circuit.parent / "edges.h5", "r+") as file:
        part = file["edges/lgn_to_v1"]
        names = {name: dict(part[name].attrs) for name in part if isinstance(part[name], h5py.Dataset)}
        for name, attributes in names.items():
            del part[name]
            part[name] = np.zeros(0, int)
            part[name].attrs.update(attributes)
        del part["0/nsyns"]
    assert read_sonata(circuit).remarks == ("the edges 'lgn_to_v1' are none: they connect nothing",)


def _simulation(circuit: Path, population: str, ids: list[int], unit: str = "ms", **entry: object) -> Path:
    with h5py.File(circuit.parent / "spikes.h5", "w") as file:
        part = file.create_group(f"spikes/{population}")
        part["timestamps"], part["node_ids"] = np.arange(len(ids), dtype=float), ids
        part["timestamps"].attrs["units"] = unit
    path = circuit.parent / "simulation_config.json"
    drive = {"input_type": "spikes", "module": "sonata", "input_file": "spikes.h5"} | entry
    path.write_text(json.dumps({"network": circuit.name, "inputs": {"drive": drive}}))
    return path


@pytest.mark.parametrize(
    ("population", "ids", "remark"),
    [
        ("lgn", [0, 2, 1], ""),
        ("lgm", [0], "spikes of 'lgm' have no effect: no nodes have this name; did you mean 'lgn'?"),
        ("v1", [10], "spikes of 'v1' have no effect: its nodes are not virtual, or have a rate"),
        ("lgn", [0, 7, 9], "the input has spikes of 2 nodes that 'lgn' does not have, such as 7"),
    ],
)
def test_spikes_that_drive_no_node_are_reported(
    population: str, ids: list[int], remark: str, circuit: Path
) -> None:
    remarks = read_sonata(_simulation(circuit, population, ids)).remarks
    assert "\n".join(remarks).endswith(remark)
    assert len(remarks) == bool(remark)


def test_spikes_in_another_unit_than_ms_are_refused(circuit: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match="'lgn'.*'s'.*'ms'"):
        read_sonata(_simulation(circuit, "lgn", [0], "s"))


def test_an_input_of_spikes_without_a_file_is_refused(circuit: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match="'drive'.*'input_file'"):
        read_sonata(_simulation(circuit, "lgn", [0], input_file=None))
