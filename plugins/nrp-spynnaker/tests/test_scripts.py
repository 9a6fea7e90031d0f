"""Scripts of sPyNNaker run unchanged: one for each kind of line that is not PyNN's."""

import subprocess
import sys
from math import exp
from pathlib import Path
from typing import Any

import pytest
from spynnaker_scripts import HEAD, mapped, refused, run

from nrp_core import load_network, save_network
from nrp_core.errors import CapabilityError, LifecycleError, NetworkError
from nrp_core.network.files.network_file import read_network

CHAIN = """
inputs = p.Population(2, p.SpikeSourceArray(spike_times=[[10.0], [20.0]]), label="inputs")
cells = p.Population(2, p.IF_curr_exp(tau_syn_E=5.0, tau_refrac=50.0), label="cells")
wires = p.Projection(inputs, cells, p.OneToOneConnector(), p.StaticSynapse(weight={weight}, delay=3.0){more})
cells.record(["spikes", "v", "gsyn_exc", "gsyn_inh"])
p.run(50)
"""


def trains(population: Any) -> list[list[float]]:
    return [train.magnitude.tolist() for train in population.get_data("spikes").segments[0].spiketrains]


def test_a_spike_travels_as_on_the_machine(tmp_path: Path) -> None:
    script = run(tmp_path, HEAD + CHAIN.format(weight=60.0, more=""))
    assert trains(script.cells) == [[13.0], [23.0]]
    assert script.p.name() == "SpiNNaker"


@pytest.mark.parametrize("longest", ["", ", max_delay=2.0"])
def test_a_delay_above_the_longest_of_setup_passes_as_on_the_machine(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, longest: str
) -> None:
    head = HEAD.replace("min_delay=1.0", f"min_delay=1.0{longest}")
    assert trains(run(tmp_path, head + CHAIN.format(weight=60.0, more="")).cells) == [[13.0], [23.0]]
    assert ("sPyNNaker ignores max_delay" in caplog.text) is bool(longest)


def test_every_way_to_import_it_gives_the_same_simulator_and_leaves_no_module(tmp_path: Path) -> None:
    before = set(sys.modules)
    script = run(
        tmp_path,
        "import pyNN.spiNNaker as a\nimport spynnaker.pyNN as b\nimport spynnaker8 as c\n"
        "from pyNN import spiNNaker as d\n"
        "from pyNN.spiNNaker import Population\nfrom spynnaker.pyNN.external_devices import SpikeInjector\n"
        "import spynnaker.pyNN.utilities.neo_convertor as convertor\n"
        "from spynnaker8.utilities import neo_compare\n"
        "main = __name__ == '__main__'\n",
    )
    assert script.a is script.b is script.d
    assert script.c.Population is script.Population is script.a.Population
    assert script.main
    assert not [name for name in set(sys.modules) - before if "spynnaker" in name and "nrp_core" not in name]


def test_neurons_per_core_and_splitters_reach_the_mapper(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        "from spynnaker.pyNN.extra_algorithms.splitter_components import (\n"
        "    SplitterAbstractPopulationVertexNeuronsSynapses)\n"
        + HEAD
        + "p.set_number_of_neurons_per_core(p.IF_curr_exp, 5)\n"
        "inputs = p.Population(100, p.SpikeSourcePoisson(rate=10.0), label='in', neurons_per_core=20)\n"
        "few = p.Population(20, p.IF_curr_exp(), label='few', additional_parameters={\n"
        "    'splitter': SplitterAbstractPopulationVertexNeuronsSynapses(2)})\n"
        "many = p.Population((6, 5), p.IF_curr_exp(), label='many', neurons_per_core=(3, 5))\n"
        "usual = p.Population(20, p.IF_cond_exp(), label='usual')\n"
        "for target in (few, many, usual):\n"
        "    p.Projection(inputs, target, p.AllToAllConnector(), p.StaticSynapse(weight=0.01, delay=1.0))\n"
        "network = p.network()\n",
    )
    hints = {label: dict(part.hints) for label, part in script.network.populations.items()}
    assert hints["few"] == {"neurons_per_core": 5, "synapse_cores": 2}
    cores = {v.label: len(v.cores) for v in mapped(script.network)}
    assert cores == {"in": 100 // 20, "few": 20 // 5 * 3, "many": 30 // 15, "usual": 1}
    save_network(script.network, tmp_path / "kept.nrpnet")
    assert read_network(tmp_path / "kept.nrpnet").digest == script.network.digest


def test_the_expected_input_of_a_population_sets_its_binary_point(tmp_path: Path) -> None:
    settings = ("", "max_expected_summed_weight=[40.0, 3.0]", "spikes_per_second=2000.0")
    shifts = []
    for more in settings:
        script = run(
            tmp_path,
            HEAD + "inputs = p.Population(10, p.SpikeSourceArray(spike_times=[1.0]), label='in')\n"
            f"cells = p.Population(10, p.IF_curr_exp(), label='cells', {more})\n"
            "p.Projection(inputs, cells, p.OneToOneConnector(), p.StaticSynapse(weight=1.5, delay=1.0))\n"
            "network = p.network()\n",
        )
        shifts.append({v.label: v.left_shifts for v in mapped(script.network)}["cells"][0])
    assert shifts == [1, 6, 2]  # the power of two above 1.5; 40; and two spikes of 1.5 in a step of 1 ms


def test_cells_of_extra_models_take_their_input_in_nanoamperes(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD
        + "cond = p.Population(2, p.extra_models.Izhikevich_cond(i_offset=[0.0, 10.0], v=-70.0, u=-14.0))\n"
        "curr = p.Population(2, p.Izhikevich(i_offset=[0.0, 10.0], tau_syn_E=2.0))\n"
        "for cells in (cond, curr):\n    cells.record(['spikes', 'v'])\np.run(300)\n",
    )
    for cells, kind in ((script.cond, "IZK_cond_exp"), (script.curr, "IZK_curr_exp")):
        assert script.p.network().populations[cells.label].cell_type == kind
        assert [bool(train) for train in trains(cells)] == [False, True]
        v = cells.get_data("v").segments[0].analogsignals[0].magnitude[:, 0]
        assert v == pytest.approx(-70.0, abs=0.1)  # 0.04 v^2 + 5 v + 140 = 0.2 v


def test_synaptic_input_of_current_based_cells_is_recorded_and_converted(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        "from spynnaker.pyNN.utilities import neo_convertor, neo_compare\n"
        + HEAD + CHAIN.format(weight=2.0, more="")
        + "data = cells.get_data()\nneo_compare.compare_blocks(data, data)\n"
        "gsyn = neo_convertor.convert_gsyn(data, data)\nv = neo_convertor.convert_v_list(data)[0]\n"
        "spikes = neo_convertor.convert_spikes(data)\n",
    )  # fmt: skip
    input_na = 2.0 * 5.0 * (1.0 - exp(-1 / 5.0))  # of a step, for an exponential with 5 ms
    first = script.gsyn[script.gsyn[:, 0] == script.gsyn[0, 0]]
    assert first[:, 1].tolist() == list(range(50))
    assert first[13, 2] == pytest.approx(input_na, rel=2e-3)
    assert first[18, 2] == pytest.approx(first[13, 2] * exp(-1.0), rel=2e-3)
    assert not script.gsyn[:, 3].any()
    assert script.v.shape == (2 * 50, 3)
    assert script.spikes.shape == (0, 2)
    assert script.cells.spinnaker_get_data("v", as_matrix=True).shape == (50, 2)


@pytest.mark.parametrize("cell", ["IF_curr_delta", "extra_models.IFCurDelta"])
def test_the_input_of_delta_synapses_is_recorded_in_the_step_of_its_arrival(
    tmp_path: Path, cell: str
) -> None:
    lines = CHAIN.format(weight=2.0, more="").replace("IF_curr_exp(tau_syn_E=5.0, ", f"{cell}(")
    data = run(tmp_path, HEAD + lines).cells.get_data().segments[0]
    excited, inhibited = (data.filter(name=f"gsyn_{end}")[0].magnitude for end in ("exc", "inh"))
    assert excited[13].tolist() == [2.0, 0.0]
    assert excited[23].tolist() == [0.0, 2.0]
    assert excited.sum() == 4.0
    assert not inhibited.any()


def test_either_sign_inhibits_on_the_inhibitory_receptor(tmp_path: Path) -> None:
    lowest = []
    for weight in (2.0, -2.0):
        more = ", receptor_type='inhibitory'"
        script = run(tmp_path, HEAD + CHAIN.format(weight=weight, more=more))
        assert (script.p.network().projections[0].weight == -2.0).all()
        weights = [weight for _, _, weight in script.wires.get("weight", "list")]
        assert weights == [2.0, 2.0]  # as they are stored
        lowest.append(script.cells.get_data("v").segments[0].analogsignals[0].magnitude.min())
    assert lowest[0] == lowest[1] < -66.0


def test_a_negative_weight_excites_as_on_the_machine_and_is_reported(tmp_path: Path) -> None:
    """sPyNNaker 7.4.1 takes the size of all weights (``numpy.abs`` in ``generate_weights``)."""
    seen = {}
    for weight, more in ((2.0, ""), (-2.0, ""), (-2.0, ", receptor_type='inhibitory'")):
        script = run(tmp_path, HEAD + CHAIN.format(weight=weight, more=more))
        v = script.cells.get_data("v").segments[0].analogsignals[0].magnitude
        seen[weight, more] = v.tobytes(), script.p.network().remarks
    (usual, none), (negative, (told,)), (_, nothing) = seen.values()
    assert usual == negative
    assert "'inputs→cells': its weights are negative" in told
    assert not none + nothing


@pytest.mark.parametrize(("given", "kept"), [("200 / 3", 66.0), ("(9.5, 2)", 18.0), ("None", None)])
def test_parts_of_a_cell_on_a_core_are_left_out(tmp_path: Path, given: str, kept: float | None) -> None:
    setting = f"p.set_number_of_neurons_per_core(p.IF_curr_exp, {given})\n"
    script = run(tmp_path, f"{HEAD}{setting}cells = p.Population(9, p.IF_curr_exp())\n")
    assert script.cells.hints.get("neurons_per_core") == kept


def test_packets_of_a_machine_are_refused_at_their_line(tmp_path: Path) -> None:
    error = refused(tmp_path, "p.Population(9, cell, label='x').record(['v', 'packets-per-timestep'])")
    assert isinstance(error, CapabilityError)
    assert f"{tmp_path / 'script.py'}:" in str(error)
    assert "'packets-per-timestep' counts the packets that each core" in str(error)


@pytest.mark.parametrize(
    "given", ["p.Population(600, kind, neurons_per_core=512)", "p.Population(600, kind)"]
)
def test_a_core_takes_at_most_256_neurons(tmp_path: Path, given: str) -> None:
    """As ``PopulationVertex.get_max_atoms_per_core`` of sPyNNaker 7.4.1."""
    setting = "" if "512" in given else "p.set_number_of_neurons_per_core(p.IF_curr_exp, 300)\n"
    script = run(tmp_path, f"{HEAD}{setting}kind = p.IF_curr_exp()\ncells = {given}\np.run(1)\n")
    assert script.cells.hints["neurons_per_core"] == 256
    assert any("at most 256 neurons" in text for text in script.p.network().remarks)


@pytest.mark.parametrize("name", ["per_dimension_per_core(7)", "per_core(n_atoms=7)"])
def test_a_type_of_cells_takes_the_number_on_a_core_itself(tmp_path: Path, name: str) -> None:
    setting = f"p.IF_curr_exp.set_model_max_atoms_{name}\n"
    made = "cells, others = (p.Population(9, kind()) for kind in (p.IF_curr_exp, p.IF_cond_exp))\n"
    script = run(tmp_path, f"{HEAD}{setting}{made}")
    assert script.cells.hints["neurons_per_core"] == 7.0
    assert "neurons_per_core" not in script.others.hints


def test_its_own_connectors_make_the_synapses_that_they_name(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(4, p.IF_curr_exp())\ncells.record('all')\n"
        "straight = p.Projection(cells, cells, p.OneToOneOffsetConnector(-1))\n"
        "ring = p.Projection(cells, cells, p.OneToOneOffsetConnector(3, wrap=True))\n"
        "many = p.Projection(cells, cells, p.MultapseConnector(7))\np.run(2)\n",
    )
    pairs = [
        sorted(zip(w.pre_index.tolist(), w.post_index.tolist(), strict=True))
        for w in (script.straight, script.ring)
    ]
    assert pairs == [[(1, 0), (2, 1), (3, 2)], [(0, 3), (1, 0), (2, 1), (3, 2)]]
    assert len(script.many) == 7
    recorded = {signal.name for signal in script.cells.get_data().segments[0].analogsignals}
    assert recorded == {"v", "gsyn_exc", "gsyn_inh"}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "p.extra_models.RecurrentRule()",
            "RecurrentRule is not supported: the rules here are SpikePairRule",
        ),
        ("p.PoolDenseConnector([[1]])", "PoolDenseConnector is not supported: how the machine numbers"),
        ("p.PoolDenseConnector.get_post_pool_shape((8, 8), 2)", "PoolDenseConnector is not supported: how"),
        (
            "p.ConvolutionConnector([[1, 2], [3, 4]])",
            "its kernel has the shape (2, 2); both numbers must be odd",
        ),
        ("p.external_devices.MunichMotorDevice()", "MunichMotorDevice is not supported: it is a device"),
    ],
)
def test_calls_without_an_equivalent_are_refused_by_name(tmp_path: Path, line: str, expected: str) -> None:
    error = refused(tmp_path, line)
    assert isinstance(error, CapabilityError)
    assert expected in str(error)


def test_a_network_that_has_ended_does_not_run_again_from_the_start(tmp_path: Path) -> None:
    lines = "x = p.Population(1, cell); p.external_devices.activate_live_output_for(x); p.run(1); p.end(); "
    for run_again in ("p.run(1)", "p.run(None)"):
        error = refused(tmp_path, lines + run_again)
        assert isinstance(error, LifecycleError)
        assert "end() has released the network" in str(error)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("p.Population(1, cell, spike_per_second=3)", "did you mean 'spikes_per_second'"),
        ("p.Population(1, cell, neurons_per_core=0)", "neurons_per_core is 0; it must be a whole number"),
        ("p.set_number_of_neurons_per_core('IF_cur_exp', 5)", "'IF_cur_exp' is not a cell type"),
        ("p.IF_curr_exp(20.0)", "IF_curr_exp: give its parameters by name, such as IF_curr_exp(v_rest=...)"),
        ("p.StructuralMechanismStatic(p.RandomSelection())", "its formation is None; it must be one such as"),
        ("p.StructuralMechanismStatic(f_rev=10.0)", "no parameter 'f_rev'; did you mean 'f_rew'"),
        ("p.ConvolutionConnector(1.0)", "its kernel is 1.0; it must be a matrix, or have a kernel_shape"),
        ("p.ConvolutionConnector([1, 2, 3], 2)", "its kernel is [1, 2, 3]; it must be a matrix, or have"),
        ("p.ConvolutionConnector([[1]], strides=0)", "strides is 0; it must be one or two whole numbers"),
        (
            "x = p.Population(9, cell, label='x'); p.Projection(x, x, p.ConvolutionConnector([[1]]))",
            "give 'x' a size of two numbers, or structure=sim.Grid2D(width / height)",
        ),
        (
            "near, weak = p.DistanceDependentFormation(), p.RandomByWeightElimination(0.5); "
            "p.StructuralMechanismStatic(p.RandomSelection(), near, weak, seed=2**32)",
            "seed is 4294967296; it must be a whole number from 0 to 4294967295",
        ),
        (
            "near, weak = p.DistanceDependentFormation((0.5, 3)), p.RandomByWeightElimination(0.5); "
            "p.StructuralMechanismStatic(p.RandomSelection(), near, weak)",
            "grid_x is 0; it must be a whole number from 1 on",
        ),
        (
            "x = p.Population((3, 4), cell); p.Projection(x, x, p.ConvolutionConnector([[1]], strides=2))",
            "from a grid of (3, 4) goes to one of (1, 2), not (3, 4)",
        ),
        (
            "x = p.Population(9, cell, label='x'); k = p.KernelConnector((2, 2), (3, 3), 1); "
            "p.Projection(x, x, k)",
            "'x' has 9 cells, more than the grid of (2, 2) of its KernelConnector",
        ),
        ("p.extra_models.Vogels2011Rule()", "Vogels2011Rule: alpha is None; it must be a number"),
        ("p.extra_models.Vogels2011Rule(0.1, taw=5.0)", "no parameter 'taw'; did you mean 'tau'"),
        ("p.DistanceDependentFormation(grid=16)", "grid is 16; it must be two whole numbers"),
        (
            "near = p.DistanceDependentFormation(p_form_forward=1.5); "
            "p.StructuralMechanismStatic(p.RandomSelection(), near, p.RandomByWeightElimination(0.5))",
            "p_form_forward is 1.5; it must be a number from 0 to 1",
        ),
        ("p.RandomByWeightElimination()", "RandomByWeightElimination has no default for threshold"),
        ("p.external_devices.add_poisson_live_rate_control(p.Population(1, cell))", "has no rate"),
        (
            "p.external_devices.activate_live_output_for(p.Population(1, cell), databse_notify_port_num=3)",
            "no argument 'databse_notify_port_num'; did you mean 'database_notify_port_num'",
        ),
        ("p.external_devices.activate_live_output_for('cells')", "its population is 'cells'; it must be"),
        ("p.Projection(input, input, p.OneToOneConnector(), p.StaticSynapse())", "its source is <built"),
        ("live(['a']); p.Population(1, cell); p.run(1)", "names 'a', which has no live output"),
        ("p.external_devices.activate_live_output_for(p.Population(1, cell), port=70000)", "port is 70000"),
        (
            "x = p.Population(1, cell, label='x'); p.external_devices.activate_live_output_for(x, port=9, "
            "message_type=p.external_devices.EIEIOType.KEY_16_BIT); p.run(1)",
            "live output of 'x': keys of 16 bits are not sent",
        ),
        (
            "[p.Population(1, p.external_devices.SpikeInjector(port=49321), label=x) for x in "
            "'ab']; p.run(1)",
            "cannot receive spikes at UDP port",
        ),
        ("p.Population(1, p.external_devices.SpikeInjector(virtual_kei=1))", "did you mean 'virtual_key'"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_line(tmp_path: Path, line: str, expected: str) -> None:
    error = refused(tmp_path, line)
    assert isinstance(error, NetworkError)
    assert expected in str(error)


@pytest.mark.parametrize(
    ("given", "ports"), [("database_notify_port_num=19997", [19997]), ("notify=False", []), ("", [19999])]
)
def test_an_injector_names_the_port_of_its_program(tmp_path: Path, given: str, ports: list[int]) -> None:
    made = f"p.Population(1, p.external_devices.SpikeInjector({given}))"
    script = run(tmp_path, f"{HEAD}injector = {made}\nports = injector.celltype.hub.ports\n")
    assert script.ports == ports


def test_such_a_script_is_a_brain_of_an_experiment_too(tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(
        "import spynnaker.pyNN as sim\nfrom spynnaker.pyNN.extra_algorithms import splitter_components\n"
        "sim.setup(1.0)\nsettings = {'neurons_per_core': 2, 'seed': 1}\n"
        "cells = sim.Population(4, sim.IF_cond_exp(), additional_parameters=settings)\n"
        "sim.Population(1, sim.external_devices.SpikeInjector(port=12345), label='in')\n"
    )
    network = load_network(path)
    assert dict(network.populations["population0"].hints) == {"neurons_per_core": 2}
    assert "seed has no effect" in network.remarks[0]
    assert network.remarks[1] == (
        "population 'in' receives no spikes at UDP port 12345: an experiment runs the network"
    )


def test_the_command_line_runs_one_and_ends_with_one_error(warm: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(HEAD + "p.extra_models.StocExp()\n")
    command = [warm / "python", "-m", "nrp_core.pynn", "--as", "spinnaker"]
    done = subprocess.run([*command, "bad.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert "bad.py:3: StocExp is not supported: it has a random threshold" in done.stderr


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("n_boards_required=0", "setup: n_boards_required is 0; it must be a number above 0, or None"),
        (
            "n_chips_required='many'",
            "setup: n_chips_required is 'many'; it must be a number above 0, or None",
        ),
        ("time_scale_factor=-1", "setup: time_scale_factor is -1; it must be a number above 0, or None"),
        ("machine_time_step=True", "setup: machine_time_step is True; it must be a number above 0, or None"),
    ],
)
def test_an_impossible_size_of_the_machine_is_refused(setting: str, words: str, tmp_path: Path) -> None:
    assert words in str(refused(tmp_path, f"p.setup(timestep=1.0, {setting})"))


def test_possible_sizes_of_the_machine_are_taken(tmp_path: Path) -> None:
    run(
        tmp_path,
        f"{HEAD}p.setup(timestep=1.0, n_boards_required=3, time_scale_factor=1.5, n_chips_required=None)\n",
    )


@pytest.mark.heavy
def test_a_cell_that_is_not_emulated_runs_in_floating_point(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cell = p.Population(1, p.extra_models.Izhikevich_cond_dual(v=-65.0), label='dual')\n"
        "source = p.Population(1, p.SpikeSourceArray([5.0]))\n"
        "p.Projection(source, cell, p.AllToAllConnector(), p.StaticSynapse(weight=0.5),\n"
        "    receptor_type='excitatory2')\n"
        "cell.record(['spikes', 'v'])\np.run(20)\ndata = cell.get_data().segments[0]\n",
    )
    assert len(script.data.spiketrains[0]) > 0
    assert script.data.filter(name="v")[0][0, 0] == -65.0


@pytest.mark.one_of(3)
@pytest.mark.parametrize("cell", ["IF_curr_dual_exp", "Izhikevich_cond_dual"])
def test_the_recorded_excitation_is_that_of_both_receptors(cell: str, tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + f"cell = p.Population(1, p.extra_models.{cell}())\n"
        "source = p.Population(1, p.SpikeSourceArray([5.0]))\n"
        "for weight, receptor in ((0.25, 'excitatory'), (0.5, 'excitatory2')):\n"
        "    p.Projection(source, cell, p.AllToAllConnector(), p.StaticSynapse(weight, delay=1.0),\n"
        "        receptor_type=receptor)\n"
        "cell.record('gsyn_exc')\np.run(20)\ngsyn = cell.get_data().segments[0].analogsignals[0]\n",
    )
    assert float(script.gsyn[6, 0]) == pytest.approx(0.75)


@pytest.mark.parametrize("name", ["spynnaker8", "pyNN.spiNNaker"])
def test_all_names_of_the_simulator_come_by_a_star(tmp_path: Path, name: str) -> None:
    script = run(
        tmp_path,
        f"from {name} import *\nimport numpy\nsetup(timestep=1.0)\n"
        "cells = Population(numpy.int64(4), IF_curr_exp(i_offset=1.0))\n"
        "Projection(cells, cells, AllToAllConnector(), StaticSynapse(weight=0.1, delay=2.0))\n"
        "cells.record('v')\nrun(10)\nv = cells.get_data().segments[0].filter(name='v')[0]\n",
    )
    assert script.v.shape == (10, 4)


def test_a_list_of_weights_has_one_for_each_row_and_rows_of_no_cells_are_left_out(tmp_path: Path) -> None:
    """As ``from_list_connector.py`` of sPyNNaker 7.4.1, which takes them by the index of the row."""
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(3, p.IF_curr_exp())\n"
        "source = p.Population(2, p.SpikeSourceArray([5.0]))\nrows = [(1, 2), (0, 4), (0, 1)]\n"
        "synapse = p.StaticSynapse(weight=[1.0, 2.0, 3.0], delay=[4, 5, 6])\n"
        "wired = p.Projection(source, cells, p.FromListConnector(rows), synapse)\n"
        "own = p.FromListConnector([(0, 0, 7.0), (1, 1, 8.0)], column_names=['delay'])\n"
        "mixed = p.Projection(source, cells, own, p.StaticSynapse(weight=[0.5, 1.5], delay=1.0))\n"
        "p.run(10)\nlists = [one.get(['weight', 'delay'], 'list') for one in (wired, mixed)]\n",
    )
    found = [[tuple(map(float, row)) for row in rows] for rows in script.lists]
    assert found == [[(0, 1, 3.0, 6.0), (1, 2, 1.0, 4.0)], [(0, 0, 0.5, 7.0), (1, 1, 1.5, 8.0)]]


def test_the_probability_of_synapses_may_be_a_text_of_their_indices(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(4, p.IF_curr_exp())\n"
        "texts = ['1.0*(i < j)', 'floor((i + j)/6)', '1.0']\n"
        "wired = [p.Projection(cells, cells, p.IndexBasedProbabilityConnector(text)) for text in texts]\n"
        "lists = [one.get(['weight'], 'list') for one in wired]\n",
    )
    pairs = [{(int(i), int(j)) for i, j, _ in found} for found in script.lists]
    every = {(i, j) for i in range(4) for j in range(4)}
    assert pairs == [{(i, j) for i, j in every if i < j}, {(3, 3)}, every]


def test_one_cell_is_a_view(tmp_path: Path) -> None:
    """As ``IDMixin`` of sPyNNaker, in its ``test_set_initial_value.py``."""
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(3, p.IF_curr_exp(v_rest=-70.0))\ncells[1].record(['v'])\np.run(5)\n"
        "v = cells[1].get_data('v').segments[0].analogsignals[0]\n",
    )
    assert script.v.shape == (5, 1)
    assert script.v.annotations["channel_ids"].tolist() == [int(script.cells[1])]


def test_initial_values_of_a_run_are_those_after_a_reset(tmp_path: Path) -> None:
    """As ``Population.initialize`` of sPyNNaker 7.4.1, in its ``test_reset_initialize.py``."""
    script = run(
        tmp_path,
        HEAD + "cell = p.Population(1, p.IF_curr_exp())\ncell.initialize(v=-62.0)\ncell.record('v')\n"
        "p.run(10)\ncell.initialize(v=-61.0)\np.run(10)\np.reset()\np.run(10)\n"
        "first, second = (part.analogsignals[0].magnitude[:, 0] for part in cell.get_data('v').segments)\n",
    )
    assert (len(script.first), len(script.second)) == (20, 10)
    assert (script.first[0], script.second[0]) == (-62.0, -61.0)
    assert script.first[10] == pytest.approx(-65.0 + 3.0 * exp(-0.5), abs=0.01)


@pytest.mark.parametrize(
    ("connector", "n", "words"),
    [
        ("FixedNumberPreConnector(3.0)", 4 * 3, ""),
        ("FixedNumberPostConnector(2.9999)", 4 * 3, ""),
        ("MultapseConnector(7.0, with_replacement=True)", 7, ""),
        ("FixedNumberPostConnector(3.5)", 0, "n must be an integer"),
        ("FixedNumberPreConnector(4, allow_self_connections=False)", 0, "draws 4 of 3 cells"),
        ("FixedNumberPostConnector(5)", 0, "draws 5 of 4 cells"),
    ],
)
def test_a_number_of_synapses_follows_the_rules_of_spynnaker(
    connector: str, n: int, words: str, tmp_path: Path
) -> None:
    """As ``test_fixed_number_post_connector.py`` of sPyNNaker."""
    lines = f"cells = p.Population(4, p.IF_curr_exp()); wires = p.Projection(cells, cells, p.{connector})\n"
    if words:
        assert words in str(refused(tmp_path, lines))
    else:
        assert len(run(tmp_path, HEAD + lines).wires) == n


def test_delays_below_a_time_step_become_one(tmp_path: Path) -> None:
    """As ``AbstractConnector._clip_delays`` of sPyNNaker 7.4.1, as for its test_synaptic_expander.py."""
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(5, p.IF_curr_exp())\n"
        "wires = p.Projection(cells, cells, p.OneToOneConnector(),\n"
        "    p.StaticSynapse(weight=0.1, delay=[3.0, -4.5, 0.2, 1.0, 2.0]))\np.run(1)\n",
    )
    assert list(script.wires.get("delay", "list", with_address=False)) == [3.0, 1.0, 1.0, 1.0, 2.0]
    assert any("2 delays are below a time step of 1 ms" in text for text in script.p.network().remarks)


def test_a_population_has_its_own_number_of_updates_in_a_step(tmp_path: Path) -> None:
    """A leaky cell with ten updates a step fires in the steps in which it does with steps of a tenth.

    A tenth of a step is rounded down on the machine, so that a refractory period lasts one update more.
    """
    times = []
    for step, more in ((1.0, ", n_steps_per_timestep=10"), (0.1, ""), (1.0, "")):
        script = run(
            tmp_path,
            f"import pyNN.spiNNaker as p\np.setup({step})\n"
            f"cell = p.Population(1, p.IF_curr_exp(i_offset=2.0, tau_refrac=2.0){more})\n"
            "cell.record('spikes')\np.run(60)\n",
        )
        times.append(trains(script.cell)[0])
    many, fine, usual = times
    assert many == pytest.approx([t // 1.0 for t in fine], abs=1.0)
    assert many[1:] != usual[1:]
    assert "must be a whole number" in str(
        refused(tmp_path, "p.Population(1, cell, n_steps_per_timestep=1.5)")
    )


def test_its_panel_draws_spikes_and_heat_maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    script = run(
        tmp_path,
        HEAD + "import numpy as np\nfrom spynnaker.spynnaker_plotting import SpynnakerPanel\n"
        "from spynnaker8.spynakker_plotting import SpynnakerPanel as Former\n"
        "from pyNN.utility.plotting import Figure\n"
        "source = p.Population(2, p.SpikeSourceArray([[1.0, 4.0], [2.0]]))\nsource.record('spikes')\n"
        "cells = p.Population(3, p.IF_curr_exp())\ncells.record('v')\np.run(5)\n"
        "figure = Figure(SpynnakerPanel(source.get_data('spikes'), yticks=True, xlim=(0, 5)),\n"
        "    Former(cells.get_data('v').segments[0]), SpynnakerPanel(np.array([[1, 7.0], [3, 9.0]])),\n"
        "    SpynnakerPanel(np.array([[1, 0, 7.0], [0, 2, 9.0]])))\n",
    )
    spikes, v, rows, values = (one for one in script.figure.fig.axes if one.get_label() != "<colorbar>")
    assert sorted(zip(*spikes.lines[0].get_data(), strict=True)) == [(1.0, 0.0), (2.0, 1.0), (4.0, 0.0)]
    assert v.images[0].get_array().shape == (3, 5)
    assert [each.tolist() for each in rows.lines[0].get_data()] == [[7.0, 9.0], [1.0, 3.0]]
    assert values.images[0].get_array()[[1, 0], [0, 2]].tolist() == [7.0, 9.0]


def test_sources_and_targets_are_names_of_a_projection_too(tmp_path: Path) -> None:
    """sPyNNaker 7.4.1 leaves the names out where addresses are part of each row anyway."""
    script = run(
        tmp_path,
        HEAD + "a, b = p.Population(2, p.IF_curr_exp()), p.Population(3, p.IF_curr_exp())\n"
        "rows = [(1, 2, 0.5, 2.0), (0, 1, 0.25, 1.0), (1, 0, 1.0, 3.0)]\n"
        "wires = p.Projection(a, b, p.FromListConnector(rows), p.StaticSynapse())\n"
        "names = ['source', 'target', 'weight']\n"
        "with_ends = wires.get(names, 'list')\n"
        "asked = wires.get(names, 'list', with_address=False)\n"
        "pairs = wires.get(['source', 'target'], 'list')\n",
    )
    assert script.with_ends == script.asked == [(0, 1, 0.25), (1, 0, 1.0), (1, 2, 0.5)]
    assert script.pairs == [(0, 1), (1, 0), (1, 2)]


def test_initial_values_are_read_by_their_names(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "a = p.Population(2, p.IF_curr_exp())\na.initialize(v=[-60.0, -61.0])\n"
        "every, one = a.get_initial_values(), a.get_initial_values([1])\n",
    )
    assert script.every["v"].tolist() == [-60.0, -61.0]
    assert script.one["v"].tolist() == [-61.0]


def test_a_misspelt_setting_is_a_warning(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    run(tmp_path, "import pyNN.spiNNaker as p\np.setup(timestep=1.0, min_dealy=1.0)\n")
    text = "setup: sPyNNaker ignores 'min_dealy', which is not a setting; did you mean 'min_delay'?"
    assert [record.message for record in caplog.records] == [text]


def test_a_helper_in_python_2_may_stand_beside_a_script_in_python_3(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("def half(n):\n    print 'halved', n\n    return n / 2\n")
    script = run(tmp_path, HEAD + "import helper\nfound = helper.half(7), 7 / 2\nprint(f'{found}')\n")
    assert script.found == (3, 3.5)
