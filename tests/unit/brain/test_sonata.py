"""SONATA circuits as networks: written here as the format's guide has it, and by PyNN's own export."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import libsonata
import numpy as np
import pytest
from circuits import ALPHA, write_circuit
from pyNN.network import Network as Components
from pyNN.serialization import export_to_sonata

from nrp_core.brain.files.sonata import read_sonata
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.implausible import implausible
from nrp_core.brain.pynn import builder
from nrp_core.errors import CapabilityError, NetworkError, NeuronSelectionError

Change = Callable[[Path], None]


@pytest.fixture
def circuit(tmp_path: Path) -> Path:
    """A circuit of six nodes and three virtual ones."""
    return write_circuit(tmp_path)


def test_nodes_become_cells_with_nests_units_turned_into_pynns(circuit: Path) -> None:
    network = read_sonata(circuit)
    assert {label: p.size for label, p in network.populations.items()} == {
        "lgn": 3, "v1/IF_curr_alpha": 4, "v1/IF_cond_exp": 2,
    }  # fmt: skip
    alpha = network.populations["v1/IF_curr_alpha"]
    assert alpha.parameters["cm"].tolist() == pytest.approx([0.2] * 4)
    assert alpha.parameters["tau_syn_I"].tolist() == [3.0] * 4
    assert alpha.parameters["v_thresh"].tolist() == [-52.0] * 4
    assert alpha.parameters["tau_refrac"].tolist() == [2.0] * 4  # NEST's default, not PyNN's
    # node k of the group stands at place node_group_index[k]
    assert alpha.parameters["i_offset"].tolist() == pytest.approx([0.4, 0.003, 0.002, 0.001])
    assert alpha.initial_values["v"].tolist() == [-70.0] * 4
    slow = network.populations["v1/IF_cond_exp"]
    assert slow.parameters["tau_m"].tolist() == pytest.approx([250.0 / 16.6667] * 2)


def test_views_hold_nodes_in_their_order_and_by_the_names_of_their_types(circuit: Path) -> None:
    network = read_sonata(circuit, populations={"first": "0:2"})
    places = network.positions_of(network.views["v1"])
    assert places[:, 0].tolist() == [10.0, 30.0, 20.0, 50.0, 40.0, 60.0]
    assert network.positions_of(network.views["Inh"])[:, 0].tolist() == [30.0, 40.0]
    assert network.positions_of(network.views["Slow"])[:, 2].tolist() == [7.0, 7.0]
    assert network.populations["lgn"].positions_um is None
    assert network.views["first"].tolist() == [0, 1]
    with pytest.raises(NeuronSelectionError, match="reaches outside the circuit"):
        read_sonata(circuit, populations={"all": "0:100"})


def test_edges_become_projections_by_receptor(circuit: Path) -> None:
    network = read_sonata(circuit)
    found = {
        (p.post, p.receptor): (
            p.pre_index.tolist(),
            p.post_index.tolist(),
            p.weight.tolist(),
            p.delay_ms.tolist(),
        )
        for p in network.projections
    }
    # weights in pA or nS, times the number of synapses: 1, 2, 3, 4, 5 for edges 0 to 4
    assert found["v1/IF_curr_alpha", "excitatory"] == (
        [0, 1, 0], [0, 1, 3], pytest.approx([0.1, 0.2, 0.5]), [1.5] * 3,
    )  # fmt: skip
    assert found["v1/IF_curr_alpha", "inhibitory"] == ([2], [2], pytest.approx([-0.75]), [2.0])
    assert found["v1/IF_cond_exp", "excitatory"] == ([2], [0], pytest.approx([0.4]), [1.5])
    assert len(found) == 3


def test_another_reader_sees_the_same_nodes_and_edges(circuit: Path) -> None:
    network = read_sonata(circuit)
    nodes = libsonata.NodeStorage(str(circuit.parent / "nodes.h5")).open_population("lgn")
    edges = libsonata.EdgeStorage(str(circuit.parent / "edges.h5")).open_population("lgn_to_v1")
    assert nodes.size == network.populations["lgn"].size
    assert edges.size == sum(projection.size for projection in network.projections)
    seen = {
        (int(projection.pre_index[k]), int(network.ids_of(projection.post)[projection.post_index[k]]))
        for projection in network.projections
        for k in range(projection.size)
    }
    every = edges.select_all()
    targets = network.views["v1"][edges.target_nodes(every).astype(int) - 10]
    assert seen == set(zip(edges.source_nodes(every).tolist(), targets.tolist(), strict=True))


def test_a_simulation_brings_the_spikes_of_virtual_nodes(circuit: Path) -> None:
    with h5py.File(circuit.parent / "spikes.h5", "w") as file:
        part = file.create_group("spikes/lgn")
        part["timestamps"], part["node_ids"] = [9.0, 3.0, 5.0], [2, 0, 2]
    path = circuit.parent / "simulation_config.json"
    inputs = {"drive": {"input_type": "spikes", "module": "sonata", "input_file": "./spikes.h5"}}
    path.write_text(json.dumps({"network": "circuit_config.json", "inputs": inputs}))
    trains = read_sonata(path).populations["lgn"].spike_times_ms
    assert [train.tolist() for train in trains] == [[3.0], [], [5.0, 9.0]]


def built(sim: Any) -> Network:
    sim.setup()
    drawn = sim.RandomDistribution("uniform", low=5.0, high=9.0)
    source = sim.Population(3, sim.SpikeSourcePoisson(rate=7.0), label="source")
    cells = sim.Population(
        6, sim.IF_cond_exp(tau_m=drawn), label="cells", structure=sim.Grid2D(aspect_ratio=1.5, dx=4.0)
    )
    more = sim.Population(2, sim.IF_curr_delta(), label="more", structure=sim.Line())
    weights = sim.RandomDistribution("uniform", low=0.1, high=0.2)
    projections = [
        sim.Projection(source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weights, delay=1.5)),
        sim.Projection(
            cells, more, sim.FixedProbabilityConnector(0.6), sim.StaticSynapse(weight=-0.5, delay=2.0),
            receptor_type="inhibitory",
        ),
    ]  # fmt: skip
    components = Components(source, cells, more)
    components.add(*projections)
    sim.components = components
    network: Network = sim.network()
    return network


def test_an_export_of_pynn_is_read_back_unchanged(tmp_path: Path) -> None:
    sim = builder(1)
    network = built(sim)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        export_to_sonata(sim.components, str(tmp_path / "out"))
    again = read_sonata(tmp_path / "out" / "circuit_config.json")
    assert set(again.populations) == set(network.populations)
    for label, population in network.populations.items():
        other = again.populations[label]
        assert other.cell_type == population.cell_type
        for name, values in population.parameters.items():
            np.testing.assert_allclose(other.parameters[name], values, rtol=1e-12)
        if population.positions_um is not None:
            np.testing.assert_allclose(other.positions_um, population.positions_um)
    for one, other in zip(_synapses(network), _synapses(again), strict=True):
        assert one == pytest.approx(other)


def _synapses(network: Network) -> list[tuple[float, ...]]:
    return sorted(
        (float(p.post == "more"), float(p.receptor == "inhibitory"), float(p.pre_index[k]),
         float(p.post_index[k]), float(p.weight[k]), float(p.delay_ms[k]))
        for p in network.projections for k in range(p.size)
    )  # fmt: skip


NODE_SETS = {
    "everything": {},
    "cortex": {"population": "v1"},
    "some": {"population": "v1", "node_id": [10, 13, 15]},
    "one": {"node_id": 1},
    "inhibitory": {"ei": "i"},
    "two types": {"node_type_id": [100, 102], "population": "v1"},
    "far": {"x": {"$gt": 15.0, "$lte": 50.0}},
    "both": ["inhibitory", "one"],
    "nested": ["both", "some"],
}


def test_node_sets_name_nodes_by_what_they_have_in_common(circuit: Path) -> None:
    config = json.loads(circuit.read_text()) | {"node_sets_file": "$BASE/sets.json"}
    circuit.write_text(json.dumps(config))
    (circuit.parent / "sets.json").write_text(json.dumps(NODE_SETS))
    network = read_sonata(circuit)
    named = {name: network.views[name].tolist() for name in NODE_SETS}
    lgn, v1 = network.views["lgn"].tolist(), network.views["v1"].tolist()
    assert named["everything"] == [*lgn, *v1]
    assert named["cortex"] == v1
    assert named["some"] == [v1[0], v1[3], v1[5]]
    assert named["one"] == [lgn[1]]
    assert named["inhibitory"] == network.views["Inh"].tolist()
    assert named["two types"] == [v1[0], v1[2], v1[3], v1[5]]
    assert named["far"] == [v1[1], v1[2], v1[3], v1[4]]
    assert named["both"] == [lgn[1], *named["inhibitory"]]
    assert set(named["nested"]) == {*named["both"], *named["some"]}


def test_another_reader_finds_the_same_nodes_in_node_sets(tmp_path: Path) -> None:
    sets = {
        "left": {"x": {"$lt": 30}}, "few": {"node_id": [0, 3, 4]},
        "all of it": {"population": "v1"}, "other": {"population": "v2"}, "either": ["left", "few"],
        "exactly": {"x": [20, 40], "node_id": [2, 3]},
    }  # fmt: skip
    config = {"nodes_file": "nodes.h5", "node_types_file": "types.csv"}
    path = tmp_path / "circuit_config.json"
    path.write_text(json.dumps({"networks": {"nodes": [config]}, "node_sets_file": "sets.json"}))
    (tmp_path / "sets.json").write_text(json.dumps(sets))
    types = [
        "node_type_id model_type model_template",
        *(f"{n} point_neuron pynn:IF_curr_exp" for n in (7, 8)),
    ]
    (tmp_path / "types.csv").write_text("\n".join(types))
    with h5py.File(tmp_path / "nodes.h5", "w") as file:
        part = file.create_group("nodes/v1")
        part["node_type_id"], part["node_group_id"], part["node_group_index"] = (
            [7, 8, 7, 8, 7], np.zeros(5, int), np.arange(5),
        )  # fmt: skip
        part["0/x"], part["0/y"], part["0/z"] = np.arange(5) * 10, np.zeros(5), np.zeros(5)
    network = read_sonata(path)
    theirs = libsonata.NodeSets.from_file(str(tmp_path / "sets.json"))
    population = libsonata.NodeStorage(str(tmp_path / "nodes.h5")).open_population("v1")
    for name in sets:
        assert network.views[name].tolist() == theirs.materialize(name, population).flatten().tolist(), name


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ("[]", "the node sets are not a JSON object"),
        ("{", "the node sets cannot be read"),
        ('{"a": ["b"], "bb": {}}', "node set 'a' names no set 'b'; did you mean 'bb'"),
        ('{"a": ["b"], "b": ["a"]}', "node set 'a' contains itself: a > b > a"),
        ('{"a": 3}', "node set 'a' is neither a JSON object nor a list"),
        ('{"lgn": {"population": "v1"}}', "the node set 'lgn' has the name of other nodes"),
        ('{"a": {"x": {"$gr": 3}}}', r"node set 'a': x cannot be compared by '\$gr': 3; did you mean '\$gt"),
    ],
)
def test_node_sets_that_cannot_be_used_say_why(sets: str, message: str, circuit: Path) -> None:
    circuit.write_text(json.dumps(json.loads(circuit.read_text()) | {"node_sets_file": "sets.json"}))
    (circuit.parent / "sets.json").write_text(sets)
    with pytest.raises(NetworkError, match=f"sets.json: .*{message}"):
        read_sonata(circuit)


def _types(folder: Path, name: str, rows: str) -> None:
    (folder / name).write_text(rows)


def test_plastic_edges_become_the_same_rules(circuit: Path) -> None:
    _types(
        circuit.parent,
        "edge_types.csv",
        """\
edge_type_id model_template syn_weight delay lambda alpha Wmax mu_plus mu_minus tau_plus
1 nest:stdp_synapse 100.0 1.5 0.02 1.5 300.0 0 0 16.0
2 nest:tsodyks_synapse -250.0 2.0 NULL NULL NULL NULL NULL NULL
""",
    )
    rows = (circuit.parent / "all_types.csv").read_text().splitlines()
    columns = {"101": "25.0"}
    table = [rows[0] + " tau_minus", *(row + " " + columns.get(row.split()[0], "NULL") for row in rows[1:])]
    _types(circuit.parent, "all_types.csv", "\n".join(table) + "\n")
    params = {**ALPHA, "tau_syn_in": 3.0}
    _types(circuit.parent, "models/exc.json", json.dumps(params))
    network = read_sonata(circuit)
    plastic = {p.label: p for p in network.projections}
    stdp = plastic["lgn_to_v1 (lgn→v1/IF_curr_alpha) excitatory stdp_synapse"]
    assert stdp.plasticity == {"timing": "SpikePairRule", "weight": "AdditiveWeightDependence"}
    values = {name: column.tolist() for name, column in stdp.synapse_parameters.items()}
    assert values["A_plus"] == [0.02] * 3
    assert values["A_minus"] == pytest.approx([0.03] * 3)
    assert values["tau_plus"] == [16.0] * 3
    assert values["tau_minus"] == [20.0, 25.0, 25.0]  # NEST keeps it with the neuron
    # an edge of n synapses changes as n do
    np.testing.assert_allclose(stdp.weight, 0.1 * np.array([1, 2, 5]))
    np.testing.assert_allclose(values["w_max"], 0.3 * np.array([1, 2, 5]))
    dynamic = plastic["lgn_to_v1 (lgn→v1/IF_curr_alpha) inhibitory tsodyks_synapse"]
    assert dynamic.synapse_type == "tsodyks_markram"
    assert {name: c.tolist() for name, c in dynamic.synapse_parameters.items()} == {
        "U": [0.5], "tau_rec": [800.0], "tau_facil": [0.0],
    }  # fmt: skip


def test_an_exponent_between_the_rules_is_refused(circuit: Path) -> None:
    _types(
        circuit.parent,
        "edge_types.csv",
        """\
edge_type_id model_template syn_weight delay mu_plus
1 nest:stdp_synapse 100.0 1.5 0.4
2 static_synapse -250.0 2.0 NULL
""",
    )
    with pytest.raises(CapabilityError, match=r"are 0.4, 1; the nearest rules are additive .both 0. and"):
        read_sonata(circuit)


def test_izhikevich_cells_have_nests_defaults_and_initial_state(circuit: Path) -> None:
    rows = (circuit.parent / "all_types.csv").read_text()
    _types(
        circuit.parent, "all_types.csv", rows.replace("nest:iaf_cond_exp NULL", "nest:izhikevich izh.json")
    )
    given = {"a": 0.1, "I_e": 10.0, "V_m": -60.0}
    _types(circuit.parent, "models/izh.json", json.dumps(given))
    cells = read_sonata(circuit).populations["v1/Izhikevich"]
    both = {**cells.parameters, **cells.initial_values}
    assert {name: column[1] for name, column in both.items()} == {
        "a": 0.1, "b": 0.2, "c": -65.0, "d": 8.0, "i_offset": 0.01, "v": -60.0, "u": -13.0,
    }  # fmt: skip
    _types(circuit.parent, "models/izh.json", json.dumps({**given, "V_th": 25.0}))
    with pytest.raises(CapabilityError, match="nodes 'v1': V_th of Izhikevich cells can only be 30"):
        read_sonata(circuit)


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
        (_text("circuit_config.json", '"edges": [', '"edgs": ['), NetworkError, "'edgs'; did you mean 'ed"),
        (_text("models/exc.json", "12.0", "NaN"), NetworkError, "all_types.csv:2: .*NaN is not a value"),
        (_data("edges.h5", "edges/lgn_to_v1/0/nsyns", [5, 4, 3, 2, -1]), NetworkError,
         "edge 0 of 'lgn_to_v1' has nsyns -1; it must be 0 or more"),
        (_data("edges.h5", "edges/lgn_to_v1/0/nsyns", [1.5, 4, 3, 2, 1]), NetworkError,
         "edge 4 of 'lgn_to_v1' has nsyns 1.5; it must be a whole number"),
        (_data("nodes.h5", "nodes/v1/node_group_id", [0, 0, 0, 0, 1, 7]), NetworkError,
         "nodes 'v1': node 5 is in the group 7, and the groups are 0, 1"),
        (_text("models/exc.json", "{", '{"C_m": 9.0, '), NetworkError, "all_types.csv:2: .*'C_m' is given"),
        (_text("models/exc.json", "12.0", "true"), NetworkError, "tau_m is True, not a number"),
        (_text("all_types.csv", "5 virtual", "101 point_neuron nest:iaf_cond_exp NULL Other e\n5 virtual"),
         NetworkError, "all_types.csv:5: the node_type_id 101 is given a second time"),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 2.0 7.0"), NetworkError,
         "edge_types.csv:3: has 1 more values than there are columns, from '7.0' on"),
        (_text("circuit_config.json", "point_neuron_models_dir", "point_neurons_models_dir"), NetworkError,
         "components has no key 'point_neurons_models_dir'; did you mean 'point_neuron_models_dir'"),
        (_text("circuit_config.json", "node_types_file", "nodes_types_file"), NetworkError,
         "an entry of 'nodes' has no key 'nodes_types_file'; did you mean 'node_types_file'"),
        (_data("nodes.h5", "nodes/v1/node_id", np.arange(6, dtype=np.uint64) + 2**63), NetworkError,
         "'/nodes/v1/node_id' holds 9223372036854775813; a number in it can be at most 9223372036854775807"),
        (_text("models/exc.json", "200.0", '"200 pF"'), NetworkError,
         r"node type 100 of 'v1' \(dynamics_params 'exc.json'\): C_m is '200 pF', not a number"),
        (_text("models/exc.json", "200.0", "[200.0, 210.0]"), NetworkError,
         r"\(dynamics_params 'exc.json'\): C_m is \[200.0, 210.0\], not a number"),
        (_text("circuit_config.json", '"edges": [', '"edges": [{"edges_file": "$BASE/edges.h5", '
               '"edge_types_file": "edge_types.csv"}, '), NetworkError, "two populations of edges have"),
        (_text("circuit_config.json", "{", "{,"), NetworkError, "circuit_config.json:1: .*not JSON"),
        (_text("circuit_config.json", "nodes.h5", "node.h5"), NetworkError, "node.h5: there is no such file"),
        (_text("circuit_config.json", "edge_types.csv", "edge_type.csv"), NetworkError,
         "edge_type.csv: the table of types cannot be read"),
        (_text("all_types.csv", "102 point", "103 point"), NetworkError,
         "nodes 'v1' have the type 102, which no table has; it has 100, 101, 103, 5"),
        (_text("all_types.csv", "node_type_id ", "node_type_id,"), NetworkError,
         "'node_type_id'; columns are separated by spaces, not ','"),
        (_text("all_types.csv", "101 point", "x point"), NetworkError, "all_types.csv:3: has no number in"),
        (_text("all_types.csv", "exc.json Exc", "no.json Exc"), NetworkError, "all_types.csv:2: .*no.json"),
        (_text("all_types.csv", "iaf_cond_exp", "iaf_cond_expo"), CapabilityError,
         "node type 102 of 'v1' is of model 'nest:iaf_cond_expo', .* supported model: nest:iaf_cond_exp"),
        (_text("all_types.csv", "nest:iaf_cond_exp", "nrn:IntFire1"), CapabilityError, "'nrn:IntFire1'"),
        (_text("all_types.csv", "102 point_neuron", "102 biophysical"), CapabilityError,
         "model_type 'biophysical'; supported are point_neuron and virtual"),
        (_text("models/exc.json", "200.0", "-200.0"), NetworkError,
         "population 'v1/IF_curr_alpha': cm of cell 0 is -0.2; it must be more than 0"),
        (_text("edge_types.csv", "2 static_synapse", "2 nest:stdp_triplet_synapse"), CapabilityError,
         "edge type 2 of 'lgn_to_v1' is of model 'nest:stdp_triplet_synapse', .* model: stdp_synapse"),
        (_text("edge_types.csv", "1 static_synapse", "1 nest:tsodyks_synapse"), CapabilityError,
         "tau_psc of nest:tsodyks_synapse is 3 ms and the time constant .* 1.5 ms"),
        (_text("all_types.csv", "nest:iaf_cond_exp", "nest:hh_psc_alpha"), CapabilityError,
         "the nearest supported model: pynn:HH_cond_exp"),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 NULL"), NetworkError,
         r"edge 2 of 'lgn_to_v1' \(type 2\) has no delay"),
        (_text("edge_types.csv", "-250.0 2.0", "-250.0 -2.0"), NetworkError,
         "delay of synapse 0 .2 -> 2. is -2; it must be 0 ms or more"),
        (_text("edge_types.csv", "100.0", "heavy"), NetworkError, "syn_weight is 'heavy', not a number"),
        (_data("edges.h5", "edges/lgn_to_v1/target_node_id", None), NetworkError,
         "no dataset 'target_node_id'"),
        (_data("edges.h5", "edges/lgn_to_v1/edge_group_index", [0, 1, 2, 3, 9]), NetworkError,
         "'nsyns' has 5 values, and place 9 is used"),
        (_data("nodes.h5", "nodes/v1/node_id", np.arange(6)), NetworkError,
         "edges 'lgn_to_v1' refer to node 10, which nodes 'v1' do not have"),
        (_cut, NetworkError, "edges.h5: the file is cut short or damaged"),
        (_data("nodes.h5", "nodes/v1/node_id", [10, 11, 12, 13, 14, 13]), NetworkError,
         "nodes.h5: .*nodes 'v1': 2 nodes have the id 13 .node_id.; ids must be distinct"),
        (_data("nodes.h5", "nodes/v1/0/y", [0, 0, np.nan, 0]), NetworkError, "'v1': y of node 11 is nan; a"),
        (_data("nodes.h5", "nodes/v1/1/x", [np.inf, 1]), NetworkError, "'v1': x of node 13 is inf; a posit"),
        (_text("circuit_config.json", '{"manifest"', '{"inputs": {"a": 3}, "manifest"'), NetworkError,
         "an entry of 'inputs' is not a JSON object"),
    ],
)  # fmt: skip
def test_a_circuit_that_cannot_be_used_says_where_and_why(
    change: Change, error: type[Exception], message: str, circuit: Path
) -> None:
    change(circuit.parent)
    with pytest.raises(error, match=message):
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
            _text("models/exc.json", "{", '{"Delta_T": 2.0, '),
            "'Delta_T' of the nodes 'v1' is not used: their models have no such parameter",
        ),
        (
            _text("models/exc.json", "{", '{"params": {"V_reset": -60.0}, '),
            "'params' of the nodes 'v1' holds 'V_reset', which is only read outside of it",
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
                '{"inputs": {"push": {"input_type": "current_clamp"}}, "manifest"',
            ),
            "the input 'push' has no effect: its input_type is 'current_clamp', and only 'spikes' are read",
        ),
        (
            _text(
                "circuit_config.json",
                '{"manifest"',
                '{"reports": {"soma": {"variable_name": "v"}}, "manifest"',
            ),
            "the report 'soma' has no effect: recordings of runs hold the brain's activity",
        ),
        (
            _data("nodes.h5", "nodes/v1/node_group_index", [3, 2, 2, 0, 0, 1]),
            "the nodes 1 and 2 of 'v1' have the same place 2 in their group (node_group_index), and so the "
            "same attributes",
        ),
        (
            _text("all_types.csv", "exc.json Exc e", "exc.json lgn e"),
            "the pop_name 'lgn' of nodes 'v1' names none of them: other nodes have this name",
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
            "'adaptation' ([1, 2]) in 'exc.json', the parameters of the nodes 'v1', is not used: their "
            "models have no such parameter",
        ),
        (
            _data("nodes.h5", "nodes/v1/0/dynamics_params/I_e", [1, np.nan, 3, 400]),
            "'I_e' of 1 nodes 'v1' is not a number; the value of their type is used, or the default",
        ),
    ],
)
def test_an_attribute_that_is_not_used_is_told(change: Change, remark: str, circuit: Path) -> None:
    change(circuit.parent)
    assert read_sonata(circuit).remarks == ((remark,) if remark else ())


@pytest.mark.parametrize(("receptor", "is_told"), [("inhibitory", True), ("excitatory", False)])
def test_positive_weights_on_an_inhibitory_receptor_are_told(
    receptor: str, *, is_told: bool, circuit: Path
) -> None:
    table = circuit.parent / "edge_types.csv"
    table.write_text(
        "edge_type_id model_template syn_weight delay receptor_type\n"
        f"1 static_synapse 100.0 1.5 {receptor}\n2 static_synapse -250.0 2.0 inhibitory\n"
    )
    found = [one for one in implausible(read_sonata(circuit)) if "they excite" in one]
    told = "weights of the projection 'lgn_to_v1 (lgn→v1/IF_curr_alpha) inhibitory' are positive on the"
    assert [one.startswith(told) for one in found] == [True] * is_told
