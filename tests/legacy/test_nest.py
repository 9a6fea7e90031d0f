"""Brain files that use NEST directly, and those in HDF5 files, become the networks that they describe."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from nrp_brain_event import EventBackend
from nrp_legacy.brains import NotedNetwork, load_brain
from nrp_legacy.injections import let_flow

from nrp_core.brain.devices.injector import SpikeInjector, SpikeInjectorPort
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import Network
from nrp_core.errors import NetworkError

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


def test_a_call_that_cannot_be_names_its_line(tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match=r"brain\.py:3: .*all_to_al.*did you mean 'all_to_all'"):
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
        let_flow(network.injections, brain)
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
