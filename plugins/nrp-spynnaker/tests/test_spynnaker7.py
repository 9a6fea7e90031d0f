"""Scripts of sPyNNaker 7, in the words of PyNN 0.7 and in Python 2, and what they import besides it.

The times of spikes are those of the same network in the words of today, which other tests compare with a
machine's; the heads of files are those that sPyNNaker 7 writes.
"""

from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from nrp_spynnaker.dialect.other_modules import NoEquivalentError
from spynnaker_scripts import HEAD, mapped, refused, run

from nrp_core.errors import NetworkError, NrpError

FORMER = """
import spynnaker7.pyNN as p
import spynnaker_external_devices_plugin.pyNN as devices
from spynnaker_external_devices_plugin.pyNN.connections\\
    .spynnaker_live_spikes_connection import SpynnakerLiveSpikesConnection
p.setup(timestep=1.0, min_delay=1.0)
p.set_number_of_neurons_per_core("IF_curr_exp", 50)
inputs = p.Population(2, p.SpikeSourceArray, {'spike_times': [[10.0], [20.0]]}, "inputs")
cells = p.Population(2, p.IF_curr_exp, {'tau_refrac': 50.0, 'v_init': -60.0}, label="cells")
wires = p.Projection(inputs, cells, p.OneToOneConnector(weights=60.0, delays=3.0), target="excitatory")
cells.record()
cells.record_v()
cells.record_gsyn()
p.run(50)
print "ran for %d ms" % (100 / 2), cells.meanSpikeCount()
spikes, voltage = cells.getSpikes(compatible_output=True), cells.get_v(gather=True)
inputs_of_cells = cells.get_gsyn()
cells.printSpikes(FOLDER + "/new/spikes.dat")
cells.print_v(FOLDER + "/v.dat")
p.end()
"""


def test_a_script_of_version_7_runs_in_python_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    script = run(tmp_path, FORMER.replace("FOLDER", repr(str(tmp_path))))
    assert capsys.readouterr().out == "ran for 50 ms 1.0\n"
    assert "'script.py' is in Python 2" in caplog.text
    assert script.inputs.label == "inputs"
    assert script.spikes.tolist() == [[0.0, 13.0], [1.0, 23.0]]
    assert script.voltage.shape == (100, 3)
    assert script.voltage[0].tolist() == [0.0, 0.0, -60.0]  # v_init
    assert script.voltage[50].tolist() == [1.0, 0.0, -60.0]
    assert script.inputs_of_cells.shape == (100, 4)
    assert script.inputs_of_cells[13, 2] > 0
    assert not script.inputs_of_cells[:, 3].any()
    assert (tmp_path / "new/spikes.dat").read_text().splitlines() == [
        "# variable = spikes", "# first_index = 0", "# last_index = 2", "# first_id = 2", "# last_id = 3",
        "# n = 2", "# size = 2", "# dt = 1.0", "13\t0", "23\t1",
    ]  # fmt: skip
    assert np.loadtxt(tmp_path / "v.dat")[0].tolist() == [-60.0, 0.0]
    assert script.devices.SpynnakerLiveSpikesConnection is script.SpynnakerLiveSpikesConnection


def test_recordings_to_a_file_are_written_at_the_end(tmp_path: Path) -> None:
    made = "cells = p.Population(1, p.SpikeSourceArray, {'spike_times': [2.0, 4.0]})\n"
    named, placed = tmp_path / "named.spikes", tmp_path / "placed.dat"
    lines = f"cells.record(to_file={str(named)!r})\ncells.record({str(placed)!r})\np.run(5)\np.end()\n"
    run(tmp_path, HEAD + made + lines)
    assert np.loadtxt(named).tolist() == np.loadtxt(placed).tolist() == [[2.0, 0.0], [4.0, 0.0]]
    run(tmp_path, f"{HEAD}{made}p.record(cells, {str(placed)!r})\np.run(3)\np.end()\n")
    assert np.loadtxt(placed).tolist() == [2.0, 0.0]


def test_data_of_a_script_of_today_stay_those_of_neo(tmp_path: Path, golden: Golden) -> None:
    made = "cells = p.Population(1, p.SpikeSourceArray([2.0]))\ncells.record('spikes')\np.run(5)\n"
    script = run(
        tmp_path, f"{HEAD}{made}block = cells.getSpikes()\nrows = cells.getSpikes(compatible_output=True)\n"
    )
    assert script.block.segments[0].spiketrains[0].magnitude.tolist() == [2.0]
    assert script.rows.tolist() == [[0.0, 2.0]]
    with golden.raises(NetworkError, match=r"'x\.txt'"):
        run(tmp_path, f"{HEAD}p.Population(1, p.SpikeSourceArray([2.0])).record('spikes', to_file='x.txt')\n")
    with golden.raises(NetworkError):
        run(tmp_path, f"{HEAD}{made}cells.write_data('x.txt')\n")


def test_spikes_are_counted_by_index(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "p.Population(5, p.SpikeSourceArray([1.0]))\n"
        "cells = p.Population(3, p.SpikeSourceArray([[1.0], [], [1.0, 2.0]]))\n"
        "cells.record('spikes')\np.run(5)\n"
        "counts, some = cells.get_spike_counts(), cells[1:].get_spike_counts()\n",
    )  # fmt: skip
    assert script.counts == {0: 1, 1: 0, 2: 2}
    assert script.some == {1: 0, 2: 2}


def test_plasticity_of_the_projection_has_the_amplitudes_of_its_rule_for_weights(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(2, p.IF_curr_exp, {})\n"
        "weights = p.AdditiveWeightDependence(w_min=0.0, w_max=2.0, A_plus=0.02, A_minus=0.03)\n"
        "all_pairs, nearest = (p.STDPMechanism(p.SpikePairRule(tau_plus=16.0, nearest=n), weights, mad=True)"
        " for n in (False, True))\n"
        "one, other = (p.Projection(cells, cells, p.AllToAllConnector(weights=0.5), label=repr(n),\n"
        "    synapse_dynamics=p.SynapseDynamics(slow=n)) for n in (all_pairs, nearest))\n"
        "network = p.network()\n",
    )
    for projection, rule in zip(
        script.network.projections, ("SpikePairRule", "SpikeNearestPairRule"), strict=True
    ):
        assert projection.plasticity["timing_dependence"] == rule
        values = {name: set(value.tolist()) for name, value in projection.synapse_parameters.items()}
        assert (values["A_plus"], values["A_minus"], values["tau_plus"]) == (
            {0.02 / 2.0},  # PyNN multiplies them by w_max
            {0.03 / 2.0},
            {16.0},
        )
        assert set(projection.weight.tolist()) == {0.5}


def test_connectors_take_weights_in_the_places_of_both_versions(tmp_path: Path) -> None:
    """The places are those of sPyNNaker7 4.0.0, with the weights first, and those of PyNN 0.7."""
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(2, p.IF_curr_exp, {})\n"
        "made = [p.Projection(cells, cells, one, target='excitatory') for one in (\n"
        "    p.AllToAllConnector(2.0, 17), p.AllToAllConnector(2.0, 17, False),\n"
        "    p.OneToOneConnector(2.0, 17), p.AllToAllConnector(False, 2.0, 17),\n"
        "    p.FixedProbabilityConnector(1.0, 2.0, 17, False),\n"
        "    p.FixedNumberPreConnector(2, 2.0, 17), p.FixedProbabilityConnector(1.0, True, 2.0, 17))]\n",
    )
    assert [len(one) for one in script.made] == [4, 2, 2, 2, 2, 4, 4]
    for projection in script.made:
        assert set(projection.get(["weight", "delay"], "list", with_address=False)) == {(2.0, 17.0)}


def test_parameters_are_set_by_name_and_in_lists(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(2, p.IF_curr_exp, {})\ncells.set('tau_m', 5.0)\ncells.set({'cm': 0.5})\n"
        "cells.tset('i_offset', [[0.1], [0.2]])\ncells.rset('tau_refrac', 3.0)\ncells.tset(tau_syn_E=7.0)\n"
        "cells.initialize('v', -61.0)\np.initialize(cells, 'v', -62.0)\np.set(cells, 'v_reset', -66.0)\n"
        "found = cells.get(['tau_m', 'cm', 'i_offset', 'tau_refrac', 'v_reset', 'tau_syn_E'])\n",
    )  # fmt: skip
    expected = {"tau_m": 5.0, "cm": 0.5, "tau_refrac": 3.0, "v_reset": -66.0, "tau_syn_E": 7.0}
    assert {name: list(script.found[name]) for name in expected} == {n: [v] * 2 for n, v in expected.items()}
    assert list(script.found["i_offset"]) == [0.1, 0.2]
    assert script.cells.initial_arrays["v"].tolist() == [-62.0, -62.0]


def test_limits_of_random_numbers_have_any_order_and_may_be_boundaries(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        "from pyNN.random import NumpyRNG, RandomDistribution\n" + HEAD +
        "rng = NumpyRNG(seed=3, rank=0, num_processes=1)\n"
        "turned = RandomDistribution('uniform', (-63.0, -67.0), rng=rng).next(200)\n"
        "bounds = {'boundaries': [1.0, 1.5], 'rng': rng}\n"
        "redrawn = RandomDistribution('normal', parameters=[1.0, 0.5], constrain='redraw', **bounds)\n"
        "redrawn = redrawn.next(200)\n"
        "clipped = p.RandomDistribution('normal', [1.0, 0.5], constrain='clip', **bounds).next(200)\n"
        "named = p.RandomDistribution('normal', mu=1.0, sigma=0.5, constrain='clip', **bounds).next(200)\n"
        "inner = p.RandomDistribution('uniform', [1.1, 1.4], **bounds).next(200)\n",
    )  # fmt: skip
    assert -67.0 <= script.turned.min() < script.turned.max() <= -63.0
    assert 1.0 < script.redrawn.min() < script.redrawn.max() < 1.5
    for clipped in (script.clipped, script.named):
        assert (clipped == 1.0).sum() > 50  # half of them are below
        assert clipped.max() <= 1.5
    assert 1.1 <= script.inner.min() < script.inner.max() <= 1.4


def test_record_of_nothing_ends_the_recording_and_changes_no_form_of_data(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(2, p.IF_curr_exp(i_offset=2.0))\ncells.record(['v', 'spikes'])\n"
        "cells.record(None)\np.run(30)\nsegment = cells.get_data().segments[0]\n"
        "kinds = [type(cells.getSpikes()).__name__, len(segment.analogsignals)]\n",
    )
    assert script.kinds == ["Block", 0]


def test_weights_in_a_list_are_those_of_the_synapses_in_their_order(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "pre, post = p.Population(3, p.IF_curr_exp()), p.Population(2, p.IF_curr_exp())\n"
        "lists = p.StaticSynapse(weight=[1.0, 2.0, 3.0], delay=[4.0, 5.0, 6.0])\n"
        "paired = p.Projection(pre, pre, p.OneToOneConnector(), lists).get(['weight', 'delay'], 'list')\n"
        "each = p.AllToAllConnector(True, range(6), 2.0)\n"
        "every = p.Projection(pre, post, each).get('weight', 'array')\n",
    )  # fmt: skip
    assert script.paired == [(0, 0, 1.0, 4.0), (1, 1, 2.0, 5.0), (2, 2, 3.0, 6.0)]
    assert script.every.tolist() == [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]  # source after source


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "x = p.Population(1, cell); "
            "p.Projection(x, x, p.OneToOneConnector(weights=1.0), p.StaticSynapse(weight=2.0))",
            "weights or delays of its OneToOneConnector and a synapse type, StaticSynapse",
        ),
        (
            "x = p.Population(3, cell); p.Projection(x, x, p.OneToOneConnector(weights=[1.0, 2.0]))",
            "weight has 2 values where there are 3 x 3",
        ),
        (
            "p.RandomDistribution('gamma', [1, 2], boundaries=[0, 1], constrain='redraw')",
            "'gamma' takes no boundaries with constrain='redraw'; a normal one does",
        ),
        (
            "p.RandomDistribution('uniform', [0.0, 2.0], boundaries=[0.0, 1.0])",
            "'uniform' takes no boundaries with constrain='clip'; a normal one does",
        ),
        (
            "p.Population(1, cell).set('tau_m')",
            "by name and value, in a dictionary or by keyword, not ('tau_m',)",
        ),
        ("p.Population(1, cell)._vertex", "Population._vertex is not supported: there is no machine"),
        ("p.extra_models.IFCurrCombExp2E2I", "extra_models has no 'IFCurrCombExp2E2I'; "),
        ("p.IF_cur_exp", "sPyNNaker has no 'IF_cur_exp'; did you mean 'IF_curr_exp'"),
        ("p.get_spynnaker()", "get_spynnaker is not supported: there is no machine"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(tmp_path: Path, line: str, expected: str) -> None:
    assert expected in str(refused(tmp_path, line))


IMPORTS = """
from pacman.model.constraints.placer_constraints import ChipAndCoreConstraint
from pacman.model.constraints.partitioner_constraints import MaxVertexAtomsConstraint
from pacman.model.partitioner_splitters import SplitterFixedLegacy
import pacman.model.partitioner_splitters as splitters
from spinn_front_end_common.utilities.exceptions import ConfigurationException
from spynnaker.pyNN.exceptions import SpynnakerException
from spynnaker.pyNN.connections.spynnaker_live_spikes_connection import SpynnakerLiveSpikesConnection
import spynnaker as whole
import spynnaker_extra_pynn_models as models
try:
    from spinn_front_end_common.utilities import globals_variables
except ImportError:
    globals_variables = None
try:
    p.Population(0, p.IF_curr_exp())
except (SpynnakerException, ConfigurationException) as error:
    caught = error
settings = {"splitter_object": SplitterFixedLegacy()}
cells = p.Population(9, models.IF_curr_delta, {}, additional_parameters=settings)
cells.set_constraint(ChipAndCoreConstraint(1, 1))
cells.set_constraint(MaxVertexAtomsConstraint(5))
network = p.network()
"""


def test_modules_of_its_tools_that_a_script_names_are_there(tmp_path: Path) -> None:
    script = run(tmp_path, HEAD + IMPORTS)
    assert script.splitters.SplitterFixedLegacy is script.SplitterFixedLegacy
    assert script.globals_variables is None
    assert isinstance(script.caught, NrpError)
    assert script.whole.Population is script.p.Population
    assert script.network.populations["population0"].cell_type == "IF_curr_delta"
    assert len(mapped(script.network)[0].cores) == 2  # of 5 and of 4 cells


@pytest.mark.parametrize(
    ("module", "reason"),
    [
        ("spynnaker.pyNN.models.neuron", "compiled for a machine are not emulated; sim.EquationCell"),
        ("spinn_front_end_common.utilities.globals_variables", "it works on the machine, or on the tools"),
        ("spynnaker.spike_checker", "sPyNNaker's own tests"),
        ("spynnaker.plot_utils", "sPyNNaker 7 does not have it"),
        ("spynnaker8.utilities.DataHolder", "compiled for a machine are not emulated"),
    ],
)
def test_other_modules_of_it_are_refused_by_name(tmp_path: Path, module: str, reason: str) -> None:
    error = refused(tmp_path, f"import {module}")
    assert isinstance(error, NoEquivalentError)
    assert f"'{module}' has no equivalent" in str(error)
    assert reason in str(error)


def test_cells_that_the_simulator_has_are_found_in_modules_of_models(tmp_path: Path) -> None:
    models = "spynnaker.pyNN.models"
    script = run(
        tmp_path,
        f"{HEAD}from {models}.utility_models.spike_injector import SpikeInjector\n"
        f"from {models}.spike_source.spike_source_array import SpikeSourceArray\n"
        f"from {models}.populations import PopulationView\n"
        "from spynnaker.pyNN.utilities.utility_calls import get_n_bits\n"
        "p.set_number_of_neurons_per_core(SpikeInjector, (4, 4))\n"
        "same = SpikeInjector is p.external_devices.SpikeInjector, SpikeSourceArray is p.SpikeSourceArray\n"
        "bits = [get_n_bits(n) for n in (0, 1, 2, 3, 4, 5, 256, 257)]\n",
    )
    assert script.same == (True, True)
    assert script.PopulationView is script.p.PopulationView
    assert script.bits == [0, 1, 1, 2, 2, 3, 8, 9]


@pytest.mark.parametrize(
    ("package", "name"),
    [("models", "neuron"), ("models.spike_source", "SpikeSourceFromFile"), ("utilities", "constants")],
)
def test_other_names_of_its_modules_are_refused_by_name(tmp_path: Path, package: str, name: str) -> None:
    error = refused(tmp_path, f"from spynnaker.pyNN.{package} import {name}")
    assert f"'spynnaker.pyNN.{package}.{name}' has no equivalent" in str(error)


def test_a_file_of_a_script_may_have_the_name_of_a_tool(tmp_path: Path) -> None:
    (tmp_path / "pacman.py").write_text("ghosts = 4\n")
    assert run(tmp_path, f"{HEAD}from pacman import ghosts\n").ghosts == 4


def test_a_grid_of_structural_plasticity_has_whole_sides(tmp_path: Path) -> None:
    script = run(tmp_path, f"{HEAD}near = p.DistanceDependentFormation(grid=[13.86, 13.86])\n")
    assert (script.near.rewiring["grid_x"], script.near.rewiring["grid_y"]) == (13, 13)
    script = run(tmp_path, f"{HEAD}weak = p.RandomByWeightElimination(mid_weight=0.2)\n")
    assert script.weak.rewiring["threshold"] == 0.2


def test_a_script_with_functions_of_python_2_alone_is_in_it(tmp_path: Path) -> None:
    script = run(
        tmp_path, f"{HEAD}halves = [i / 2 for i in xrange(4)]\ncells = p.Population(2, p.IF_curr_exp)\n"
    )
    assert script.halves == [0, 0, 1, 1]
    assert script.cells._size == 2
    own = run(tmp_path, f"{HEAD}xrange = range\nhalves = [i / 2 for i in xrange(2)]\n")
    assert own.halves == [0.0, 0.5]


def test_a_script_in_neither_python_3_nor_2_is_one_error(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match="script.py:3"):
        run(tmp_path, f"{HEAD}if:\n")
