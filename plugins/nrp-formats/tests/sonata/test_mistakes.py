"""SONATA circuits that cannot be used, or not in full, say where and why."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from golden import Golden
from nrp_formats.sonata import read_sonata

from nrp_core.checks.network_units import unlikely_units
from nrp_core.errors import CapabilityError, NetworkError

Change = Callable[[Path], None]


def _text(name: str, old: str, new: str) -> Change:
    def change(folder: Path) -> None:
        path = folder / name
        assert old in path.read_text()
        path.write_text(path.read_text().replace(old, new))

    return change


def _data(name: str, key: str, values: object) -> Change:
    def change(folder: Path) -> None:
        with h5py.File(folder / name, "r+") as file:
            del file[key]
            if values is not None:
                file[key] = values

    return change


def _more(name: str, key: str, values: object) -> Change:
    def change(folder: Path) -> None:
        with h5py.File(folder / name, "r+") as file:
            file[key] = values

    return change


def _input(target: str) -> Change:
    def change(folder: Path) -> None:
        with h5py.File(folder / "spikes.h5", "w") as file:
            file["spikes/lgn/timestamps"], file["spikes/lgn/node_ids"] = [1.0], [0]
        config = json.loads((folder / "circuit_config.json").read_text())
        entry = {"input_type": "spikes", "input_file": "spikes.h5", "node_set": target}
        (folder / "circuit_config.json").write_text(json.dumps({**config, "inputs": {"a": entry}}))

    return change


def _sets(sets: dict[str, Any]) -> Change:
    def change(folder: Path) -> None:
        (folder / "sets.json").write_text(json.dumps(sets))
        config = json.loads((folder / "circuit_config.json").read_text())
        (folder / "circuit_config.json").write_text(json.dumps({**config, "node_sets_file": "sets.json"}))

    return change


def _cut(folder: Path) -> None:
    path = folder / "edges.h5"
    path.write_bytes(path.read_bytes()[:-500])


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (_text("circuit_config.json", '"networks"', '"network_"'), NetworkError, "no 'networks' with"),
        (_text("circuit_config.json", '"edges": [', '"edgs": ['), NetworkError, "'edgs'"),
        (_text("circuit_config.json", '"components"', '"componets"'), NetworkError,
         "'componets'.*'components'"),
        (_text("models/exc.json", "12.0", "NaN"), NetworkError,
         "exc.json.*all_types.csv:2.*NaN"),
        (_data("edges.h5", "edges/lgn_to_v1/0/nsyns", [5, 4, 3, 2, -1]), NetworkError,
         "'lgn_to_v1'.*-1"),
        (_data("edges.h5", "edges/lgn_to_v1/0/nsyns", [1.5, 4, 3, 2, 1]), NetworkError,
         "'lgn_to_v1'.*1.5"),
        (_data("nodes.h5", "nodes/v1/node_group_id", [0, 0, 0, 0, 1, 7]), NetworkError,
         "'v1'.*0, 1"),
        (_text("models/exc.json", "{", '{"C_m": 9.0, '), NetworkError, "exc.json.*'C_m'"),
        (_text("models/exc.json", "12.0", "true"), NetworkError, "tau_m"),
        (_text("all_types.csv", "5 virtual", "101 point_neuron nest:iaf_cond_exp NULL Other e\n5 virtual"),
         NetworkError, "all_types.csv:5.*node_type_id 101"),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 2.0 7.0"), NetworkError,
         "edge_types.csv:3.*'7.0'"),
        (_text("circuit_config.json", "point_neuron_models_dir", "point_neurons_models_dir"), NetworkError,
         "'point_neurons_models_dir'.*'point_neuron_models_dir'"),
        (_text("circuit_config.json", "node_types_file", "nodes_types_file"), NetworkError,
         "'nodes'.*'nodes_types_file'.*'node_types_file'"),
        (_data("nodes.h5", "nodes/v1/node_id", np.arange(6, dtype=np.uint64) + 2**63), NetworkError,
         "'/nodes/v1/node_id'.*9223372036854775813.*9223372036854775807"),
        (_text("models/exc.json", "200.0", '"200 pF"'), NetworkError,
         r"100.*'v1' \(dynamics_params 'exc.json'\): C_m.*'200 pF'"),
        (_text("models/exc.json", "200.0", "[200.0, 210.0]"), NetworkError,
         r"\(dynamics_params 'exc.json'\): C_m.*\[200.0, 210.0\]"),
        (_text("circuit_config.json", '"edges": [', '"edges": [{"edges_file": "$BASE/edges.h5", '
               '"edge_types_file": "edge_types.csv"}, '), NetworkError, ""),
        (_text("circuit_config.json", "{", "{,"), NetworkError, "circuit_config.json:1: .*cannot be"),
        (_text("circuit_config.json", "nodes.h5", "node.h5"), NetworkError, "node.h5"),
        (_text("circuit_config.json", "edge_types.csv", "edge_type.csv"), NetworkError,
         "edge_type.csv"),
        (_text("all_types.csv", "102 point", "103 point"), NetworkError,
         "'v1'.*102.*100, 101, 103, 5"),
        (_text("all_types.csv", "node_type_id ", "node_type_id,"), NetworkError,
         "'node_type_id'.*','"),
        (_text("all_types.csv", "101 point", "x point"), NetworkError, "all_types.csv:3"),
        (_text("all_types.csv", "exc.json Exc", "no.json Exc"), NetworkError, "all_types.csv:2: .*no.json"),
        (_text("all_types.csv", "iaf_cond_exp", "iaf_cond_expo"), CapabilityError,
         "102.*'v1'.*'nest:iaf_cond_expo'.*nest:iaf_cond_exp"),
        (_text("all_types.csv", "nest:iaf_cond_exp", "nrn:IntFire1"), CapabilityError, "'nrn:IntFire1'"),
        (_text("all_types.csv", "102 point_neuron", "102 biophysical"), CapabilityError,
         "model_type 'biophysical'.*point_neuron"),
        (_text("models/exc.json", "200.0", "-200.0"), NetworkError,
         "'v1/IF_curr_alpha'.*-0.2"),
        (_text("edge_types.csv", "2 static_synapse", "2 nest:stdp_triplet_synapse"), CapabilityError,
         "'lgn_to_v1'.*'nest:stdp_triplet_synapse'.*stdp_synapse"),
        (_text("edge_types.csv", "1 static_synapse", "1 nest:tsodyks_synapse"), CapabilityError,
         "tau_psc.*nest:tsodyks_synapse.*1.5"),
        (_text("all_types.csv", "nest:iaf_cond_exp", "nest:hh_psc_alpha"), CapabilityError,
         "pynn:HH_cond_exp"),
        (_text("edge_types.csv", "-250.0 2.0", "NULL 2.0"), NetworkError,
         "'lgn_to_v1'.*syn_weight"),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 -2.0"), NetworkError,
         "0 .2 -> 2.*-2"),
        (_text("edge_types.csv", "100.0", "heavy"), NetworkError, "syn_weight.*'heavy'"),
        (_data("edges.h5", "edges/lgn_to_v1/target_node_id", None), NetworkError,
         "no dataset 'target_node_id'"),
        (_data("edges.h5", "edges/lgn_to_v1/edge_group_index", [0, 1, 2, 3, 9]), NetworkError,
         "'nsyns'"),
        (_data("nodes.h5", "nodes/v1/node_id", np.arange(6)), NetworkError,
         "'lgn_to_v1'.*10.*'v1'"),
        (_cut, NetworkError, "edges.h5"),
        (_data("nodes.h5", "nodes/v1/node_id", [10, 11, 12, 13, 14, 13]), NetworkError,
         "nodes.h5.*'v1': 2.*13 .node_id"),
        (_data("nodes.h5", "nodes/v1/0/y", [0, 0, np.nan, 0]), NetworkError, "'v1'.*11"),
        (_data("nodes.h5", "nodes/v1/1/x", [np.inf, 1]), NetworkError, "'v1'.*13"),
        (_text("circuit_config.json", '"edges": [', '"edges": 3, "edges": ['), NetworkError,
         "'edges'"),
        (_text("circuit_config.json", '"$MODELS"}', "3}"), NetworkError,
         ""),
        (_text("circuit_config.json", '"edge_types.csv"', "[]"), NetworkError,
         r"'edge_types_file'.*\[\]"),
        (_text("circuit_config.json", '{"manifest"', '{"run": {"inputs": {}}, "manifest"'), NetworkError,
         "'inputs'.*'run'"),
        (_text("models/exc.json", "200.0", '""'), NetworkError, "C_m.*''"),
        (_text("edge_types.csv", "delay", "syn_weight"), NetworkError,
         "edge_types.csv:1.*'syn_weight'"),
        (_data("edges.h5", "edges/lgn_to_v1/edge_group_id", None), NetworkError,
         "'lgn_to_v1'.*'edge_group_index'.*'edge_group_id'"),
        (_data("edges.h5", "edges/lgn_to_v1/edge_group_index", 3), NetworkError,
         ""),
        (_data("nodes.h5", "nodes/v1/node_type_id", np.full((6, 1), 100)), NetworkError,
         r"\(6, 1\)"),
        (_data("nodes.h5", "nodes/v1/0/x", np.zeros((4, 1))), NetworkError,
         r"'/nodes/v1/0/x'.*\(4, 1\)"),
        (_data("nodes.h5", "nodes/v1/node_id", np.arange(10, 15)), NetworkError,
         "node_id"),
        (_sets({"first": {"node_id": [True]}}), NetworkError,
         "'first': node_id"),
        (_sets({"first": {"population": [3]}}), NetworkError,
         ""),
        (_text("circuit_config.json", '{"manifest"', '{"inputs": {"a": 3}, "manifest"'), NetworkError,
         "'inputs'.*JSON"),
    ],
)  # fmt: skip
def test_a_circuit_that_cannot_be_used_says_where_and_why(
    change: Change, error: type[Exception], message: str, circuit: Path, golden: Golden
) -> None:
    change(circuit.parent)
    with golden.raises(error, match=message):
        read_sonata(circuit)


@pytest.mark.parametrize(
    ("change", "remark"),
    [
        (
            _text("models/exc.json", "{", '{"reference": "10.1016/j.x", "version": "1.0", "fit": "2-part", '),
            "",
        ),
        (
            _text(
                "models/exc.json",
                "{",
                '{"authors": ["A", "B"], "asc_init": [0.0, 0.0], "fit": {"ok": true}, ',
            ),
            "",
        ),
        (
            _text("models/exc.json", "V_th", "V_thr"),
            "'V_thr' of the nodes 'v1' is not used; did you mean 'V_th'?",
        ),
        (_text("models/exc.json", "V_th", "comment"), ""),
        (
            _text("all_types.csv", "dynamics_params", "dynamic_params"),
            "'dynamic_params' of the nodes 'v1' is not used; did you mean 'dynamics_params'?",
        ),
        (
            _data("edges.h5", "edges/lgn_to_v1/0/nsyns", np.full(5, b"two")),
            "'nsyns' of the edges 'lgn_to_v1' is not used: it does not hold numbers",
        ),
        (_more("edges.h5", "edges/lgn_to_v1/0/region", np.full(5, b"V1")), ""),
        (_more("edges.h5", "edges/lgn_to_v1/indices/source_to_target/x", [0]), ""),
        (_more("nodes.h5", "nodes/v1/0/@library/morphology", [b"a"]), ""),
        (
            _more("nodes.h5", "nodes/v1/0/dynamic_params/V_m", [0.0]),
            "the group 'dynamic_params' of the nodes 'v1' is not read; did you mean 'dynamics_params'?",
        ),
        (
            _data("nodes.h5", "nodes/v1/1/x", None),
            "the nodes 'v1' have no position: their places lack x",
        ),
        (
            _input("lgnn"),
            "the input 'a' is for the node set 'lgnn', which does not exist; did you mean 'lgn'?",
        ),
        (_input("lgn"), ""),
        (_input("all"), ""),
        (
            _text("models/exc.json", "{", '{"Delta_T": 2.0, '),
            "'Delta_T' of the nodes 'v1' is not used: their models have no such parameter",
        ),
        (
            _text(
                "edge_types.csv",
                "delay\n1 static_synapse 100.0 1.5",
                "delay weight_function\n1 static_synapse 100.0 1.5 wmax",
            ),
            "weight_function of the edges 'lgn_to_v1' is 'wmax': the weights are used as given",
        ),
        (
            _text("circuit_config.json", '{"manifest"', '{"conditions": {"v_init": -80}, "manifest"'),
            "'conditions.v_init' is -80 and has no effect: cells begin as their models say",
        ),
        (
            _text(
                "circuit_config.json", '{"manifest"', '{"run": {"tstop": 3000.0, "duration": 5}, "manifest"'
            ),
            "'run.tstop' is 3000.0 ms and has no effect: the experiment's duration counts",
        ),
        (
            _text("circuit_config.json", '{"manifest"', '{"run": {"dt": 0.5}, "manifest"'),
            "'run.dt' is 0.5 ms and has no effect: the brain's timestep counts",
        ),
        (
            _text(
                "circuit_config.json",
                '{"manifest"',
                '{"inputs": {"push": {"input_type": "voltage_clamp"}}, "manifest"',
            ),
            "the input 'push' has no effect: its input_type 'voltage_clamp' is not read",
        ),
        (
            _text(
                "circuit_config.json",
                '{"manifest"',
                '{"reports": {"soma": {"variable_name": "v"}}, "manifest"',
            ),
            "the report 'soma' has no effect: recordings of runs hold the brain's activity",
        ),
        (_text("all_types.csv", "exc.json Exc e", "exc.json v1 e"), ""),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 2.0 "), ""),
        (
            _text(
                "edge_types.csv",
                "delay\n1 static_synapse 100.0 1.5",
                "delay U\n1 static_synapse 100.0 1.5 0.5",
            ),
            "'U' of the edges 'lgn_to_v1' is not used: static_synapse has no such parameter",
        ),
        (
            _text(
                "edge_types.csv",
                "delay\n1 static_synapse 100.0 1.5",
                "delay U\n1 pynn:TsodyksMarkramSynapse 100.0 1.5 0.5",
            ),
            "",
        ),
        (
            _sets({"all": {"population": "v1"}, "none": {"population": "V1"}, "layer": {"layer": 4}}),
            "the node sets of 'sets.json' contain no node: 'none', 'layer'",
        ),
        (_sets({"all": {"population": "v1"}}), ""),
        (
            _text("models/exc.json", "{", '{"adaptation": [1, 2], "V_m": -60.0, '),
            "'adaptation' of the nodes 'v1' is not used: their models have no such parameter",
        ),
        (
            _data("nodes.h5", "nodes/v1/0/dynamics_params/I_e", [1, np.nan, 3, 400]),
            "'I_e' of 1 nodes 'v1' is not a number; the value of their type is used, or the default",
        ),
    ],
)
def test_an_unused_attribute_is_reported(change: Change, remark: str, circuit: Path) -> None:
    change(circuit.parent)
    assert read_sonata(circuit).remarks == ((remark,) if remark else ())


@pytest.mark.parametrize(("receptor", "is_told"), [("inhibitory", True), ("excitatory", False)])
def test_positive_weights_on_an_inhibitory_receptor_are_reported(
    receptor: str, *, is_told: bool, circuit: Path
) -> None:
    table = circuit.parent / "edge_types.csv"
    table.write_text(
        "edge_type_id model_template syn_weight delay receptor_type\n"
        f"1 static_synapse 100.0 1.5 {receptor}\n2 static_synapse -250.0 2.0 inhibitory\n"
    )
    found = [one for one in unlikely_units(read_sonata(circuit)) if "they excite" in one]
    told = "weights of the projection 'lgn_to_v1 (lgn→v1/IF_curr_alpha) inhibitory' are positive on the"
    assert [one.startswith(told) for one in found] == [True] * is_told
