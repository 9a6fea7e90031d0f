"""A SONATA circuit of which one file is changed at random is usable, or refused in clear words."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from mutations import Tally, mutated, numbered
from nrp_brain_event import EventBackend

from nrp_core.brain.sonata import read_sonata
from nrp_core.errors import ExperimentError, NetworkError, NrpError

TYPES = """node_type_id model_type model_template dynamics_params pop_name
100 point_neuron nest:iaf_psc_alpha cell.json Exc
101 point_neuron nest:iaf_cond_exp NULL Slow
102 virtual NULL NULL NULL
"""
EDGE_TYPES = """edge_type_id model_template syn_weight delay
1 static_synapse 100.0 1.5
2 static_synapse -250.0 2.0
"""
CONFIG = {
    "manifest": {"$BASE": ".", "$MODELS": "$BASE"},
    "components": {"point_neuron_models_dir": "$MODELS"},
    "networks": {
        "nodes": [{"nodes_file": "$BASE/nodes.h5", "node_types_file": "$BASE/node_types.csv"}],
        "edges": [{"edges_file": "$BASE/edges.h5", "edge_types_file": "edge_types.csv"}],
    },
}
FILES = (
    "config.json",
    "config.json",
    "node_types.csv",
    "edge_types.csv",
    "cell.json",
    "nodes.h5",
    "edges.h5",
)
LARGEST = 1_000
"""Neurons; the sound circuit has nine."""


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    """A circuit of six cells and three virtual ones."""
    folder = tmp_path / "sound"
    folder.mkdir()
    (folder / "config.json").write_text(json.dumps(CONFIG, indent=1))
    (folder / "node_types.csv").write_text(TYPES)
    (folder / "edge_types.csv").write_text(EDGE_TYPES)
    (folder / "cell.json").write_text(json.dumps({"C_m": 200.0, "tau_m": 12.0, "V_th": -52.0}, indent=1))
    with h5py.File(folder / "nodes.h5", "w") as file:
        cells = file.create_group("nodes/v1")
        cells["node_type_id"] = [100, 101, 100, 100, 101, 100]
        cells["node_group_id"] = np.zeros(6, int)
        cells["node_group_index"] = np.arange(6)
        cells["0/x"] = np.arange(6.0)
        file.create_group("nodes/lgn")["node_type_id"] = [102, 102, 102]
        file.create_group("nodes/lgn/0")
    with h5py.File(folder / "edges.h5", "w") as file:
        edges = file.create_group("edges/lgn_to_v1")
        edges["source_node_id"], edges["target_node_id"] = [0, 1, 2, 2, 0], [0, 1, 2, 3, 4]
        edges["source_node_id"].attrs["node_population"] = "lgn"
        edges["target_node_id"].attrs["node_population"] = "v1"
        edges["edge_type_id"] = [1, 1, 2, 1, 1]
        edges["edge_group_id"], edges["edge_group_index"] = np.zeros(5, int), np.arange(5)
        edges["0/nsyns"] = [5, 4, 3, 2, 1]
    return folder


def use(config: Path) -> None:
    """Read it and let it fire for 2 ms; what comes out are spikes of its neurons, and numbers."""
    network = read_sonata(config)
    assert network.size < LARGEST, network.size
    for projection in network.projections:
        assert np.isfinite(projection.weight).all()
        assert (np.isfinite(projection.delay_ms) & (projection.delay_ms >= 0)).all()
    if not network.size:
        return
    backend = EventBackend()
    with backend.open(network, seed=1, options=backend.options()) as brain:
        brain.run_until(2_000_000)
        for label, population in network.populations.items():
            if not population.is_source:
                assert np.isfinite(brain.read_state("v", network.ids_of(label))).all()


def test_a_mutated_circuit_is_usable_or_refused_in_clear_words(sound: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mutated"
    use(sound / "config.json")

    def is_clear(error: NrpError) -> bool:
        names_file = error.path is not None if isinstance(error, ExperimentError) else bool(str(error))
        return names_file and "Traceback" not in str(error)

    tally = Tally("SONATA circuit", is_clear)
    for number, random in numbered("SONATA circuit"):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(sound, folder)
        file = folder / random.choice(FILES)
        file.write_bytes(mutated(file.read_bytes(), random, text=file.suffix != ".h5"))
        tally.take(number, lambda: use(folder / "config.json"))
    tally.check()


def test_a_heap_in_which_the_library_would_search_for_ever_is_refused(sound: Path) -> None:
    path = sound / "edges.h5"
    data = bytearray(path.read_bytes())
    heap = data.index(b"GCOL")
    free = data.index((4032).to_bytes(8, "little"), heap)  # what its two texts leave of its 4096 bytes
    data[free : free + 8] = bytes(8)
    path.write_bytes(data)
    with pytest.raises(NetworkError, match=r"edges\.h5: the file is damaged"):
        read_sonata(sound / "config.json")
