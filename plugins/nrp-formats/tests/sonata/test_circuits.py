"""SONATA circuits as networks: written here as the format's guide has it, and by PyNN's own export."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import h5py
import libsonata
import numpy as np
import pytest
from golden import Golden
from nrp_brain_event.backend import EventBackend
from nrp_formats.sonata import read_sonata
from pyNN.network import Network as Components
from pyNN.serialization import export_to_sonata
from sonata_circuits import ALPHA

from nrp_core.brain import SpikeRecorder
from nrp_core.errors import CapabilityError, NetworkError, NeuronSelectionError
from nrp_core.network.data import Network
from nrp_core.network.pynn import builder


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


def test_views_hold_nodes_in_their_order_and_by_the_names_of_their_types(
    circuit: Path, golden: Golden
) -> None:
    network = read_sonata(circuit, populations={"first": "0:2"})
    places = network.positions_of(network.views["v1"])
    assert places[:, 0].tolist() == [10.0, 30.0, 20.0, 50.0, 40.0, 60.0]
    assert network.positions_of(network.views["Inh"])[:, 0].tolist() == [30.0, 40.0]
    assert network.positions_of(network.views["Slow"])[:, 2].tolist() == [7.0, 7.0]
    assert network.populations["lgn"].positions_um is None
    assert network.views["first"].tolist() == [0, 1]
    with golden.raises(NeuronSelectionError):
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


def clamped(circuit: Path, **entries: Any) -> Network:
    path = circuit.parent / "simulation_config.json"
    inputs = {
        name: {"input_type": "current_clamp", "module": "IClamp", **one} for name, one in entries.items()
    }
    path.write_text(json.dumps({"network": "circuit_config.json", "inputs": inputs}))
    return read_sonata(path)


def test_a_clamp_drives_its_nodes_in_the_unit_of_their_models(circuit: Path) -> None:
    """V - E_L is R I_e (1 - exp(-t / tau)) + R I (1 - exp(-(t - delay) / tau)), and V_th - E_L is 18 mV."""
    step = {"node_set": "Inh", "amp": 400.0, "delay": 5.0, "duration": 50.0}
    network = clamped(circuit, step=step)
    (current,) = network.currents
    assert current.neurons.tolist() == network.views["Inh"].tolist()
    assert (current.times_ms.tolist(), current.amplitudes_na.tolist()) == ([5.0, 55.0], [0.4, 0.0])
    backend = EventBackend()
    with backend.open(network, seed=0, options=backend.options()) as brain:
        recorded = brain.add_sink(SpikeRecorder(), range(network.size), name="spikes")
        brain.run_until(100_000_000)
        spikes = recorded.spikes()  # type: ignore[attr-defined]
    raised_mv, offset_mv = 12.0 / 200.0 * 400.0, 12.0 / 200.0 * np.array([3.0, 1.0])
    begins_mv = raised_mv + offset_mv * np.exp(-5.0 / 12.0)
    expected_ms = 5.0 + 12.0 * np.log(begins_mv / (raised_mv + offset_mv - 18.0))
    found = [spikes.times_ms[spikes.neurons == one] for one in network.views["Inh"]]
    assert [train[0] for train in found] == pytest.approx(expected_ms, abs=1e-6)
    assert max(np.concatenate(found)) < 55.0


def test_a_list_is_a_series_of_pulses_and_a_node_set_may_be_in_place(circuit: Path) -> None:
    pulses = {"amp": [100.0, 200.0, 300.0], "delay": [1.0, 2.0, 9.0], "duration": [5.0, 3.0, 1.0]}
    network = clamped(
        circuit,
        pulses={"node_set": {"population": "v1", "node_ids": [11, 13]}, **pulses},
        always={"node_set": "all", "amp": 1.0, "duration": 1e9},
        off={"node_set": "v1", "amp": 1.0, "duration": 1.0, "enabled": False},
    )
    series, always = network.currents
    v1 = network.views["v1"].tolist()
    assert series.neurons.tolist() == [v1[1], v1[3]]
    assert series.times_ms.tolist() == [1.0, 2.0, 5.0, 9.0, 10.0]
    assert series.amplitudes_na.tolist() == pytest.approx([0.1, 0.2, 0.0, 0.3, 0.0])
    assert (sorted(always.neurons.tolist()), always.times_ms.tolist()) == (sorted(v1), [0.0, 1e9])


def test_a_current_comes_from_a_table_in_the_unit_of_the_models(circuit: Path) -> None:
    (circuit.parent / "clamp.csv").write_text("timestamps amps\n0.0 0.0\n5.0 150.0\n6.0 150.0\n9.5 -20.0\n")
    (circuit.parent / "own.csv").write_text("t,I\n1,2\n2,4\n")
    names = {"separator": ",", "timestamps_column": "t", "amplitudes_column": "I"}
    network = clamped(
        circuit,
        one={"input_type": "csv", "node_set": "v1", "file": "clamp.csv"},
        own={"input_type": "file", "node_set": "v1", "file": "$configdir/own.csv", **names},
    )
    one, own = network.currents
    assert (one.times_ms.tolist(), own.times_ms.tolist()) == ([0.0, 5.0, 9.5], [1.0, 2.0])
    assert one.amplitudes_na.tolist() == pytest.approx([0.0, 0.15, -0.02])
    assert own.amplitudes_na.tolist() == pytest.approx([0.002, 0.004])


@pytest.mark.parametrize(
    ("settings", "times_ms"),
    [
        ({}, [0.0, 0.5, 1.0]),
        ({"downsample": 0.0005, "delay": 10.0}, [10.0, 10.5, 11.0]),
        ({"sweep_window": [0.5, 0.75], "delay": 2.0}, [2.5]),
    ],
)
def test_a_current_comes_from_a_sweep_in_amperes(
    settings: dict[str, Any], times_ms: list[float], circuit: Path
) -> None:
    with h5py.File(circuit.parent / "cell.nwb", "w") as file:
        series = file.create_group("epochs/Sweep_6/stimulus/timeseries")
        series["data"] = np.array([0.0, 0.0, 2e-10, 2e-10, 0.0, 0.0])
        series["starting_time"] = 0.0
        series["starting_time"].attrs["rate"] = 4000.0
    entry = {"input_type": "nwb", "node_set": "v1", "file": "cell.nwb", "sweep_id": 6, **settings}
    (current,) = clamped(circuit, sweep=entry).currents
    expected = [0.0, 0.2, 0.0] if len(times_ms) == 3 else [0.2]
    assert current.times_ms.tolist() == times_ms
    assert current.amplitudes_na.tolist() == pytest.approx(expected)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"node_set": "v1", "input_type": "csv", "file": "no.csv"}, "no.csv cannot be read as a table"),
        ({"node_set": "v1", "input_type": "csv"}, "'file' is None; it must be a path"),
        (
            {"node_set": "v1", "input_type": "csv", "file": "circuit_config.json"},
            "has no column 'timestamps'",
        ),
        ({"node_set": "v1", "input_type": "nwb", "file": "nodes.h5"}, "has no stimulus of the sweep"),
        ({"node_set": "v1", "input_type": "nwb", "file": "nodes.h5", "sweep_window": 3}, "must be two times"),
        ({"node_set": "v1", "duration": 1.0}, "'amp' is None; it must be a number"),
        ({"node_set": "v1", "amp": 1.0}, "'duration' is None; it must be a number"),
        ({"node_set": "v2", "amp": 1.0, "duration": 1.0}, "there is no node set 'v2'"),
        ({"amp": 1.0, "duration": 1.0}, "'node_set' is None"),
        ({"node_set": "lgn", "amp": 1.0, "duration": 1.0}, "contains no cell that a current can drive"),
        ({"node_set": "v1", "amp": [1.0, 2.0], "duration": 1.0}, "must have the same number of values"),
        ({"node_set": "v1", "amp": 1.0, "duration": 1.0, "delay": -1.0}, "must ascend from 0 ms"),
    ],
)
def test_a_clamp_that_cannot_be_used_is_refused(entry: dict[str, Any], message: str, circuit: Path) -> None:
    with pytest.raises(NetworkError, match=f"simulation_config.json: the input 'push': .*{message}"):
        clamped(circuit, push=entry)


def test_spikes_in_the_first_layout_are_those_of_the_node_set(circuit: Path) -> None:
    with h5py.File(circuit.parent / "spikes.h5", "w") as file:
        file["spikes/timestamps"], file["spikes/gids"] = [9.0, 3.0, 5.0], [2, 0, 2]
    path = circuit.parent / "simulation_config.json"
    inputs = {"drive": {"input_type": "spikes", "input_file": "$FOLDER/spikes.h5", "node_set": "lgn"}}
    given = {"manifest": {"$FOLDER": "${configdir}"}, "network": "$configdir/circuit_config.json"}
    path.write_text(json.dumps({**given, "inputs": inputs}))
    both = circuit.parent / "config.json"
    both.write_text(json.dumps({"network": "circuit_config.json", "simulation": "simulation_config.json"}))
    for file in (path, both):
        trains = read_sonata(file).populations["lgn"].spike_times_ms
        assert [train.tolist() for train in trains] == [[3.0], [], [5.0, 9.0]]


def test_edges_without_a_delay_have_that_of_nest(circuit: Path) -> None:
    table = circuit.parent / "edge_types.csv"
    table.write_text(table.read_text().replace("delay", "other"))
    network = read_sonata(circuit)
    assert {delay for one in network.projections for delay in one.delay_ms.tolist()} == {1.0}
    assert any("5 edges 'lgn_to_v1' have no delay" in remark for remark in network.remarks)


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


def test_node_sets_select_nodes_by_their_properties(circuit: Path) -> None:
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
        ("[]", "the file of node sets is not a JSON object"),
        ("{", "the file of node sets cannot be read"),
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
    with pytest.raises(NetworkError, match=f"sets.json:.*{message}"):
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


def test_an_exponent_between_the_rules_is_refused(circuit: Path, golden: Golden) -> None:
    _types(
        circuit.parent,
        "edge_types.csv",
        """\
edge_type_id model_template syn_weight delay mu_plus
1 nest:stdp_synapse 100.0 1.5 0.4
2 static_synapse -250.0 2.0 NULL
""",
    )
    with golden.raises(CapabilityError, match="0.4, 1"):
        read_sonata(circuit)


@pytest.mark.parametrize(("given", "v_mv"), [({}, -70.0), ({"V_m": -66.0}, -66.0)])
def test_cells_begin_at_nests_voltage_whatever_their_resting_potential(
    circuit: Path, given: dict[str, float], v_mv: float
) -> None:
    rows = (circuit.parent / "all_types.csv").read_text()
    _types(
        circuit.parent,
        "all_types.csv",
        rows.replace("nest:iaf_cond_exp NULL", "nest:iaf_cond_exp cond.json"),
    )
    _types(circuit.parent, "models/cond.json", json.dumps({"E_L": -78.0, **given}))
    cells = read_sonata(circuit).populations["v1/IF_cond_exp"]
    assert cells.parameters["v_rest"].tolist() == [-78.0] * cells.size
    assert cells.initial_values["v"].tolist() == [v_mv] * cells.size


def test_izhikevich_cells_have_nests_defaults_and_initial_state(circuit: Path, golden: Golden) -> None:
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
    with golden.raises(CapabilityError, match="'v1': V_th.*30"):
        read_sonata(circuit)
