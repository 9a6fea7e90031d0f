"""A small SONATA circuit, for whoever reads or breaks one."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np

ALPHA = {"C_m": 200.0, "tau_m": 12.0, "tau_syn_ex": 1.5, "tau_syn_in": 3.0, "V_th": -52.0}
NODE_TYPES = """node_type_id model_type model_template dynamics_params pop_name ei
100 point_neuron nest:iaf_psc_alpha exc.json Exc e
101 point_neuron nest:iaf_psc_alpha exc.json Inh i
102 point_neuron nest:iaf_cond_exp NULL Slow e
"""
EDGE_TYPES = """edge_type_id model_template syn_weight delay
1 static_synapse 100.0 1.5
2 static_synapse -250.0 2.0
"""


def write_circuit(folder: Path) -> Path:
    """Write a circuit of six nodes and three virtual ones, as the Allen Institute's examples are laid out.

    Returns:
        its configuration.
    """
    (folder / "models").mkdir()
    (folder / "models" / "exc.json").write_text(json.dumps(ALPHA))
    (folder / "edge_types.csv").write_text(EDGE_TYPES)
    with h5py.File(folder / "nodes.h5", "w") as file:
        file.attrs["magic"] = np.uint32(0x0A7A)
        part = file.create_group("nodes/v1")
        part["node_id"] = np.arange(10, 16)
        part["node_type_id"] = [100, 101, 100, 102, 101, 102]
        part["node_group_id"] = [0, 0, 0, 1, 0, 1]
        part["node_group_index"] = [3, 2, 1, 0, 0, 1]
        part["0/x"], part["0/y"], part["0/z"] = [40.0, 20.0, 30.0, 10.0], np.zeros(4), np.full(4, 5.0)
        part["0/dynamics_params/I_e"] = [1.0, 2.0, 3.0, 400.0]
        part["1/x"], part["1/y"], part["1/z"] = [50.0, 60.0], np.zeros(2), np.full(2, 7.0)
        file.create_group("nodes/lgn")["node_type_id"] = [5, 5, 5]
        file.create_group("nodes/lgn/0")
    with h5py.File(folder / "edges.h5", "w") as file:
        part = file.create_group("edges/lgn_to_v1")
        part["source_node_id"], part["target_node_id"] = [0, 1, 2, 2, 0], [10, 11, 12, 13, 14]
        part["source_node_id"].attrs["node_population"] = "lgn"
        part["target_node_id"].attrs["node_population"] = "v1"
        part["edge_type_id"] = [1, 1, 2, 1, 1]
        part["edge_group_id"], part["edge_group_index"] = np.zeros(5, int), [4, 3, 2, 1, 0]
        part["0/nsyns"] = [5, 4, 3, 2, 1]
    config = {
        "manifest": {"$BASE": ".", "$MODELS": "$BASE/models"},
        "components": {"point_neuron_models_dir": "$MODELS"},
        "networks": {
            "nodes": [
                {"nodes_file": "$BASE/nodes.h5", "node_types_file": "${BASE}/all_types.csv"},
            ],
            "edges": [{"edges_file": "$BASE/edges.h5", "edge_types_file": "edge_types.csv"}],
        },
    }
    rows = [*NODE_TYPES.splitlines(), "5 virtual NULL NULL NULL NULL"]
    (folder / "all_types.csv").write_text("\n".join(rows) + "\n")
    path = folder / "circuit_config.json"
    path.write_text(json.dumps(config))
    return path
