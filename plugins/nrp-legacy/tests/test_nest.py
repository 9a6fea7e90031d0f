"""Brain files that use NEST directly, and those in HDF5 files, become the networks that they describe."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend
from nrp_legacy.brains import NotedNetwork, inject_currents, load_brain

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, SpikeInjector, SpikeInjectorPort
from nrp_core.brain.interface import Brain
from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.findings.codes import Weight
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network

SENSOR = {"E_L": -60.5, "V_th": -60.0, "V_reset": -60.5, "t_ref": 10.0, "g_L": 2.5, "C_m": 25.0,
          "E_in": -75.0, "tau_syn_ex": 2.5, "tau_syn_in": 2.5}  # fmt: skip
IN_NEST = f"""
import nest
circuit = nest.Create('iaf_cond_alpha', 3, {SENSOR!r})
nest.SetStatus([circuit[2]], {{'V_th': -60.51, 'V_reset': -61.6, 'V_m': -65.0}})
nest.Connect(circuit[0:1], circuit[1:3], 'all_to_all', {{'weight': 0.15, 'delay': 0.1}})
nest.Connect([circuit[1]], [circuit[2]], syn_spec={{'model': 'tsodyks_synapse', 'weight': -1.2, 'delay': 0.1,
             'U': 1.0, 'tau_rec': 1.0, 'tau_fac': 1.0}})
"""
IN_PYNN = """
import pyNN.nest as sim
sim.setup(timestep=0.1)
circuit = sim.Population(3, sim.IF_cond_alpha(v_rest=-60.5, v_thresh=-60.0, v_reset=-60.5, tau_refrac=10.0,
    cm=0.025, tau_m=10.0, tau_syn_E=2.5, tau_syn_I=2.5, e_rev_E=0.0, e_rev_I=-75.0))
circuit[2:3].set(v_thresh=-60.51, v_reset=-61.6)
circuit.initialize(v=[-70.0, -70.0, -65.0])
sim.Projection(circuit[0:1], circuit[1:3], sim.AllToAllConnector(),
    sim.StaticSynapse(weight=1.5e-4, delay=0.1))
sim.Projection(circuit[1:2], circuit[2:3], sim.AllToAllConnector(),
    sim.TsodyksMarkramSynapse(weight=1.2e-3, delay=0.1, U=1.0, tau_rec=1.0, tau_facil=1.0),
    receptor_type='inhibitory')
"""


def loaded(folder: Path, text: str) -> NotedNetwork:
    path = folder / "brain.py"
    path.write_text(text)
    network = load_brain(path, {}, 0)
    assert isinstance(network, NotedNetwork)
    return network


def numbers(network: Network) -> list[object]:
    (cells,) = network.populations.values()
    synapses = [
        (one.receptor, one.pre_index.tolist(), one.post_index.tolist(), one.weight.round(9).tolist(),
         one.delay_ms.tolist(), one.synapse_type, {k: v.tolist() for k, v in one.synapse_parameters.items()})
        for one in network.projections
    ]  # fmt: skip
    return [cells.cell_type, {k: v.tolist() for k, v in cells.parameters.items()},
            cells.initial_values["v"].tolist(), synapses]  # fmt: skip


def test_the_same_network_in_nest_and_in_pynn_is_the_same(tmp_path: Path) -> None:
    assert numbers(loaded(tmp_path, IN_NEST)) == numbers(loaded(tmp_path, IN_PYNN))


def test_variables_that_hold_nodes_are_names_of_neurons(tmp_path: Path) -> None:
    text = "import nest\na = nest.Create('iaf_psc_exp', 3)\nb = nest.Create('iaf_psc_alpha', 2)\n"
    text += "circuit = {'first': a, 'both': a + b}\none = b[1]\nsome = [a[2], b[0]]\nnumbers = [1, 2]\n"
    views = {name: ids.tolist() for name, ids in loaded(tmp_path, text).views.items()}
    assert views == {"a": [0, 1, 2], "b": [3, 4], "first": [0, 1, 2], "both": [0, 1, 2, 3, 4],
                     "one": [4], "some": [2, 3]}  # fmt: skip


def test_each_target_of_a_poisson_generator_gets_a_train_and_recorders_vanish(tmp_path: Path) -> None:
    text = """
import nest
cells = nest.Create('iaf_psc_exp', 4)
noise = nest.Create('poisson_generator', params={'rate': 800.0})
direct = nest.Create('dc_generator', 1, {'amplitude': 300.0})
spikes = nest.Create('spike_detector')
nest.Connect(noise, cells, syn_spec={'weight': 20.0})
nest.Connect(direct, cells[1:2], syn_spec={'weight': 2.0})
nest.Connect(cells, spikes)
"""
    network = loaded(tmp_path, text)
    assert [(p.cell_type, p.size) for p in network.populations.values()] == [
        ("IF_curr_exp", 4), ("SpikeSourcePoisson", 4),
    ]  # fmt: skip
    assert network.populations["iaf_psc_exp"].parameters["i_offset"].tolist() == [0, 0.6, 0, 0]
    (projection,) = network.projections
    assert (projection.pre_index.tolist(), projection.post_index.tolist()) == ([0, 1, 2, 3], [0, 1, 2, 3])


@pytest.mark.parametrize(
    ("rule", "n"),
    [
        ("'all_to_all'", 40),
        ("{'rule': 'fixed_indegree', 'indegree': 3}", 15),
        ("{'rule': 'fixed_outdegree', 'outdegree': 2, 'multapses': False}", 16),
        ("{'rule': 'fixed_total_number', 'N': 17}", 17),
        ("{'rule': 'pairwise_bernoulli', 'p': 1.0}", 40),
    ],
)
def test_every_rule_makes_its_number_of_synapses_the_same_each_time(
    tmp_path: Path, rule: str, n: int
) -> None:
    text = f"""
import nest
a, b = nest.Create('iaf_psc_exp', 8), nest.Create('iaf_psc_exp', 5)
nest.Connect(a, b, {rule}, {{'weight': {{'distribution': 'uniform', 'low': 1.0, 'high': 2.0}}, 'delay': 1.5}})
"""
    first, second = loaded(tmp_path, text), loaded(tmp_path, text)
    (projection,) = first.projections
    assert projection.size == n
    assert 1e-3 <= projection.weight.min() < projection.weight.max() <= 2e-3
    assert first.digest == second.digest


def test_connections_can_be_looked_up_and_changed(tmp_path: Path) -> None:
    text = """
import nest
nest.SetDefaults('iaf_psc_exp', {'tau_m': 7.0})
nest.CopyModel('static_synapse', 'weak', {'weight': 3.0})
a = nest.Create('iaf_psc_exp', 3)
nest.Connect(a, a, 'one_to_one', 'weak')
found = nest.GetConnections(a[1:2])
assert nest.GetStatus(found, 'weight') == (3.0,) and nest.GetStatus(a, ['tau_m'])[0] == (7.0,)
nest.SetStatus(found, {'weight': 5.0})
"""
    (projection,) = loaded(tmp_path, text).projections
    assert projection.weight.tolist() == [0.003, 0.005, 0.003]


def test_unknown_models_are_reported_and_the_rest_is_built(tmp_path: Path) -> None:
    text = "import nest\na = nest.Create('iaf_psc_exp', 2)\nb = nest.Create('music_event_in_proxy')\n"
    network = loaded(tmp_path, text + "nest.Connect(b, a)\nnest.Connect(a, a, syn_spec='ht_synapse')\n")
    assert network.size == 2
    assert [note.subject for note in network.notes] == ["music_event_in_proxy", "ht_synapse"]


def test_synapses_that_do_not_learn_and_recorders_without_data_make_a_run_incomplete(
    tmp_path: Path, golden: Golden
) -> None:
    text = """
import nest
a = nest.Create('iaf_psc_exp', 2)
voltage = nest.Create('voltmeter')
dopamine = nest.Create('volume_transmitter')
nest.CopyModel('stdp_synapse_sinexp', 'learning', {'weight': 2.0})
nest.Connect(voltage, a)
nest.Connect(a, a, syn_spec='learning')
"""
    notes = loaded(tmp_path, text).notes
    assert {note.weight for note in notes} == {Weight.INCOMPLETE}
    golden(*(note.message for note in notes))


def test_a_call_that_cannot_be_names_its_line(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match=r"brain\.py:3.*all_to_al.*'all_to_all'"):
        loaded(tmp_path, "import nest\na = nest.Create('iaf_psc_exp')\nnest.Connect(a, a, 'all_to_al')\n")


def test_a_native_cell_in_a_script_of_pynn_takes_the_units_of_nest(tmp_path: Path) -> None:
    text = "import pyNN.nest as sim\nkind = sim.native_cell_type('iaf_cond_alpha')\n"
    network = loaded(tmp_path, text + f"circuit = sim.Population(2, kind, {SENSOR!r})\n")
    (cells,) = network.populations.values()
    assert (cells.cell_type, cells.parameters["cm"][0], cells.parameters["tau_m"][0]) == (
        "IF_cond_alpha", 0.025, 10.0,
    )  # fmt: skip


def open_brain(network: Network) -> Brain:
    backend = EventBackend()
    return backend.open(network, seed=0, options=backend.options())


def test_currents_of_a_brain_file_flow_at_their_time(tmp_path: Path) -> None:
    text = "import pyNN.nest as sim\ncircuit = sim.Population(2, sim.IF_curr_exp())\n"
    text += "sim.StepCurrentSource(times=[50.0, 100.0], amplitudes=[2.0, 0.0]).inject_into(circuit[1:2])\n"
    network = loaded(tmp_path, text)
    with open_brain(network) as brain:
        inject_currents(network.injections, brain)
        recorder = brain.add_sink(SpikeRecorder(), np.arange(2), name="all")
        brain.run_until(200_000_000)
        spikes = recorder.spikes(-1.0, 200.0)
    assert set(spikes.neurons.tolist()) == {1}
    assert 50 < spikes.times_ms.min() < spikes.times_ms.max() < 101


def test_a_brain_of_2014_in_hdf5_excites_and_inhibits_as_its_tables_say(tmp_path: Path) -> None:
    cells = {"C_m": 25.0, "g_L": 2.5, "E_L": -60.5, "V_th": -60.0, "V_reset": -60.5, "t_ref": 10.0, "a": 0.0,
             "b": 0.0, "Delta_T": 0.0, "tau_w": 100.0, "V_peak": -59.0, "E_ex": 0.0, "E_in": -75.0, "x": 1.0,
             "y": 2.0, "z": 3.0, "tau_syn_E": 2.5}  # fmt: skip
    path = tmp_path / "brain.h5"
    with h5py.File(path, "w") as file:
        for name, value in cells.items():
            file[name] = np.full(3, value)
        file["excitatory"] = np.array([150, 150, 50])
        file["syn_1"] = np.array([[2, 3], [0.1, 0.1], [2.15, 0.028], [1, 1], [1, 1], [1, 1]])
        file["syn_3"] = np.array([[2], [0.1], [-1.7], [1], [1], [1]])
    network = load_brain(path, {}, 0)
    (population,) = network.populations.values()
    assert (population.cell_type, population.size) == ("EIF_cond_alpha_isfa_ista", 3)
    values = {name: population.parameters[name][0] for name in ("cm", "tau_m", "tau_syn_E", "tau_syn_I")}
    assert values == {"cm": 0.025, "tau_m": 10.0, "tau_syn_E": 2.5, "tau_syn_I": 8.0}
    excitatory, inhibitory = network.projections
    assert (excitatory.post_index.tolist(), excitatory.weight.tolist()) == ([1, 2], [0.00215, 2.8e-5])
    assert (inhibitory.pre_index.tolist(), inhibitory.weight.tolist()) == ([2], [0.0017])
    assert network.neurons("circuit").tolist() == [0, 1, 2]


def test_parrots_repeat_what_comes_to_them_from_anywhere(tmp_path: Path) -> None:
    network = loaded(
        tmp_path,
        "import nest\n"
        "source = nest.Create('spike_generator', 1, {'spike_times': [5.0, 5.2, 9.0]})\n"
        "parrots = nest.Create('parrot_neuron', 2)\n"
        "cells = nest.Create('parrot_neuron', 1)\n"
        "nest.Connect(source, parrots[:1], syn_spec={'weight': 3.0, 'delay': 1.0})\n"
        "nest.Connect(parrots, cells, syn_spec={'weight': 0.1, 'delay': 2.0})\n"
        "circuit = parrots + cells\n",
    )
    with open_brain(network) as brain:
        own = brain.add_source(
            SpikeInjector(weight=0.00015, delay=1.0), network.neurons("parrots")[1:], name="own"
        )
        assert isinstance(own, SpikeInjectorPort)
        own.inject_spikes(times_ms=7.0)
        recorder = brain.add_sink(SpikeRecorder(), network.neurons("circuit"), name="all")
        brain.run_until(20_000_000)
        spikes = recorder.spikes(-1.0, 20.0)
    trains = [spikes.times_ms[spikes.neurons == one] for one in network.neurons("circuit").tolist()]
    first, second, cell = trains
    assert first == pytest.approx([6.0, 6.2, 10.0], abs=0.11)
    assert second == pytest.approx([8.0], abs=0.11)
    assert cell == pytest.approx([8.0, 8.2, 10.0, 12.0], abs=0.21)


@pytest.mark.parametrize(
    ("sender", "target"),
    [("dc_generator", "parrot_neuron"), ("dc_generator", "spike_detector"), ("voltmeter", "parrot_neuron")],
)
def test_a_connection_that_needs_a_membrane_is_refused_as_in_nest(
    sender: str, target: str, tmp_path: Path
) -> None:
    text = f"import nest\nnest.Connect(nest.Create('{sender}'), nest.Create('{target}', 2))\n"
    with pytest.raises(NetworkError, match=f"'{sender}' cannot be connected to '{target}'.*no membrane"):
        loaded(tmp_path, text)


@pytest.mark.parametrize(
    "line",
    [
        "nest.Connect(nest.Create('dc_generator', 1, {'amplitude': 5.0}), relays)",
        "sim.DCSource(amplitude=1.0).inject_into(relays)",
    ],
)
def test_a_current_into_parrots_of_pynn_is_refused(line: str, tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match="'population1', which only emits or repeats spikes"):
        loaded(tmp_path, CELLS_OF_PYNN + line + "\n")


def test_devices_that_send_currents_are_refused_at_parrots(tmp_path: Path) -> None:
    network = loaded(tmp_path, "import nest\nparrots = nest.Create('parrot_neuron', 2)\n")
    with open_brain(network) as brain, pytest.raises(NeuronSelectionError, match="only repeats spikes"):
        brain.add_source(DCSource(amplitude=1.0), network.neurons("parrots"), name="current")
    current = InjectedCurrent(np.array([1]), np.array([0.0]), np.array([1.0]))
    with pytest.raises(NetworkError, match="'parrot_neuron', which only repeats spikes"):
        Network(network.populations, currents=(current,))


CELLS_OF_PYNN = """
from hbp_nrp_cle.brainsim import simulator as sim
import nest
circuit = sim.Population(4, sim.IF_cond_alpha())
relays = sim.Population(2, sim.native_cell_type('parrot_neuron'))
"""


def test_nest_connects_cells_of_pynn_in_its_own_units(tmp_path: Path) -> None:
    text = CELLS_OF_PYNN + (
        "nest.Connect(list(map(int, circuit.all_cells)), relays, 'all_to_all', {'weight': 50.0})\n"
        "synapse = {'model': 'tsodyks_synapse', 'U': 0.3, 'weight': [[-1.0, 2.0]] * 4, 'delay': 1.5}\n"
        "nest.Connect(tuple(relays.all_cells), circuit.all_cells, 'all_to_all', synapse)\n"
        "nest.SetStatus(nest.GetConnections(relays, circuit[:1]), 'weight', 3.0)\n"
    )
    network = loaded(tmp_path, text)
    summary = [(one.pre, one.post, one.receptor, one.size, one.synapse_type) for one in network.projections]
    assert summary == [
        ("population0", "population1", "excitatory", 8, "static"),
        ("population1", "population0", "excitatory", 5, "tsodyks_markram"),
        ("population1", "population0", "inhibitory", 3, "tsodyks_markram"),
    ]
    assert network.projections[0].weight[0] == 50.0
    assert network.projections[1].weight.tolist() == pytest.approx([0.003, 0.003, 0.002, 0.002, 0.002])
    assert network.projections[2].weight.tolist() == pytest.approx([0.001, 0.001, 0.001])
    assert set(network.projections[2].delay_ms.tolist()) == {1.5}
    assert set(network.projections[1].synapse_parameters["U"].tolist()) == {0.3}


def test_nodes_of_nest_beside_cells_of_pynn_become_populations(tmp_path: Path) -> None:
    text = CELLS_OF_PYNN + (
        "nest.Connect(nest.Create('poisson_generator', 1, {'rate': 100.0}), circuit[:3], "
        "syn_spec={'weight': 10.0})\n"
        "nest.Connect(nest.Create('dc_generator', 1, {'amplitude': 500.0}), circuit[:1])\n"
        "nest.Connect(circuit[1:], nest.Create('spike_detector'))\n"
        "more = nest.Create('iaf_psc_exp', 3, {'C_m': 100.0})\n"
        "nest.Connect(circuit, more, syn_spec={'model': 'stdp_synapse', 'weight': 10.0, 'Wmax': 20.0})\n"
    )
    network = loaded(tmp_path, text)
    sizes = {label: population.size for label, population in network.populations.items()}
    assert sizes == {"population0": 4, "population1": 2, "poisson_generator": 3, "iaf_psc_exp": 3}
    assert network.views["more"].tolist() == [6, 7, 8]
    assert network.populations["iaf_psc_exp"].parameters["cm"].tolist() == [0.1] * 3
    assert network.populations["population0"].parameters["i_offset"].tolist() == [0.5, 0, 0, 0]
    assert [cells.tolist() for cells in network.built.recorded] == [[1, 2, 3]]
    plastic = {one.post: one for one in network.projections}["iaf_psc_exp"]
    assert set(plastic.synapse_parameters["w_max"].tolist()) == {0.02}


def test_nest_changes_and_reads_cells_of_pynn(tmp_path: Path) -> None:
    text = CELLS_OF_PYNN + (
        "nest.SetStatus(list(circuit.all_cells[:2]), {'V_th': -48.0, 'g_L': 20.0, 'V_m': -60.0})\n"
        "read = nest.GetStatus([int(circuit[1])], ['V_th', 'C_m', 'g_L'])\n"
    )
    network = loaded(tmp_path, text)
    cells = network.populations["population0"]
    assert cells.parameters["v_thresh"].tolist() == [-48.0, -48.0, -50.0, -50.0]
    assert cells.parameters["tau_m"].tolist() == [50.0, 50.0, 20.0, 20.0]
    assert cells.initial_values["v"].tolist() == [-60.0, -60.0, -65.0, -65.0]
    assert network.built.variables["read"] == ((-48.0, 1000.0, 20.0),)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("nest.SetStatus(list(circuit.all_cells), {'V_thr': 1.0})", "'V_thr'.*'V_th'"),
        ("nest.Connect([3], [77])", "77"),
        ("nest.SetStatus([77], {'V_th': 1.0})", "77"),
    ],
)
def test_cells_and_parameters_that_do_not_exist_are_named(
    tmp_path: Path, call: str, message: str, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=message):
        loaded(tmp_path, CELLS_OF_PYNN + call + "\n")


def test_only_a_call_makes_populations_and_moves_the_numbers_of_nodes(tmp_path: Path) -> None:
    text = '"""One population.\n\n    Population (of NEST)\n"""\nimport pyNN.nest as sim\nimport nest\n'
    text += "text = 'sim.Population(3)'\nkind = sim.Population\n"
    text += "circuit = nest.Create('iaf_cond_alpha', 3)\nassert list(circuit) == [1, 2, 3]\n"
    assert loaded(tmp_path, text).size == 3


EARLY = "nodes = nest.Create('iaf_cond_alpha', 3)\nheard = nest.Create('spike_detector')\n"


def test_nodes_may_come_before_the_cells_of_pynn(tmp_path: Path) -> None:
    text = "import nest\n" + EARLY + CELLS_OF_PYNN
    text += "nest.Connect(nodes, circuit, 'one_to_one' if len(circuit) == 3 else 'all_to_all')\n"
    text += "nest.Connect([int(one) for one in circuit], nodes[:2])\nnest.Connect(nodes, heard)\n"
    network = loaded(tmp_path, text)
    summary = {(one.pre, one.post): one.size for one in network.projections}
    assert summary == {("iaf_cond_alpha", "population0"): 12, ("population0", "iaf_cond_alpha"): 8}
    assert [cells.tolist() for cells in network.built.recorded] == [network.views["nodes"].tolist()]


def test_nodes_and_cells_with_the_same_numbers_are_refused(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "cells_of_pynn.py").write_text(CELLS_OF_PYNN)
    with golden.raises(NetworkError, match="'iaf_cond_alpha'.*PyNN's"):
        loaded(
            tmp_path, f"import nest\n{EARLY}from cells_of_pynn import circuit\nnest.Connect(circuit, heard)\n"
        )


def test_native_synapses_have_weights_in_the_units_of_nest(tmp_path: Path) -> None:
    connect = "sim.Projection(circuit, circuit, sim.AllToAllConnector(), sim.native_synapse_type"
    text = CELLS_OF_PYNN + (
        f"{connect}('static_synapse')(weight=2.0))\n"
        f"{connect}('static_synapse')(weight=sim.random.RandomDistribution('uniform', low=2.0, high=3.0)))\n"
        f"{connect}('stdp_synapse')(weight=2.0, Wmax=5.0, alpha=2.0))\n"
    )
    static, drawn, plastic = loaded(tmp_path, text).projections
    assert set(static.weight.tolist()) == {0.002}
    assert 0.002 <= drawn.weight.min() < drawn.weight.max() <= 0.003
    assert (plastic.synapse_type, plastic.synapse_parameters["w_max"][0]) == ("stdp", 0.005)
    assert plastic.synapse_parameters["A_minus"][0] == pytest.approx(0.02)
