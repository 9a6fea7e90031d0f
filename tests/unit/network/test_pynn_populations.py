"""Populations, views and assemblies behave as in PyNN and keep PyNN's numbers."""

from types import ModuleType
from typing import Any

import numpy as np
import pyNN.mock
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from pyNN import errors
from pyNN.parameters import Sequence
from quantities import Hz, V, ms, nS, s, uV

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.cells import CELLS
from nrp_core.network.data import Network
from nrp_core.network.pynn import builder


@pytest.fixture
def sim() -> ModuleType:
    return builder(seed=1)


@pytest.mark.parametrize("cell", [cell for cell in CELLS if hasattr(pyNN.standardmodels.cells, cell)])
def test_a_cell_has_all_of_pynns_parameters_and_state_with_their_defaults(sim: ModuleType, cell: str) -> None:
    sim.Population(2, getattr(sim, cell)(), label="cells")
    (population,) = sim.network().populations.values()
    model = getattr(pyNN.standardmodels.cells, cell)
    defaults = {k: v for k, v in model.default_parameters.items() if k != "spike_times"}
    assert population.cell_type == cell
    assert {k: v.tolist() for k, v in population.parameters.items()} == {
        k: [v] * 2 for k, v in defaults.items()
    }
    initial = {k: v.tolist() for k, v in population.initial_values.items()}
    assert initial == {k: [v] * 2 for k, v in model.default_initial_values.items()}


@pytest.mark.parametrize(
    "value",
    [15.0, [15.0, 16.0, 17.0], np.array([15.0, 16.0, 17.0]), lambda i: 15.0 + i, 15],
    ids=["number", "list", "array", "function", "integer"],
)
def test_a_parameter_may_be_given_in_each_form_of_pynn(sim: ModuleType, value: Any) -> None:
    expected = [15.0, 15.0, 15.0] if isinstance(value, (int, float)) else [15.0, 16.0, 17.0]
    made = sim.Population(3, sim.IF_curr_exp(tau_m=value), label="made")
    changed = sim.Population(3, sim.IF_curr_exp(), label="changed")
    changed.set(tau_m=value)
    assert np.broadcast_to(made.get("tau_m"), 3).tolist() == expected
    populations = sim.network().populations
    assert [populations[name].parameters["tau_m"].tolist() for name in ("made", "changed")] == [expected] * 2


@pytest.mark.filterwarnings("ignore:Passing celltype class:DeprecationWarning")
def test_a_cell_class_of_pynn_itself_is_that_of_the_simulator(sim: ModuleType) -> None:
    pynn = pyNN.standardmodels.cells
    made = [
        sim.Population(2, pynn.IF_curr_exp), sim.Population(2, pynn.IF_curr_exp(tau_m=7.0)),
        sim.Population(1, pynn.SpikeSourceArray(spike_times=[3.0])),
    ]  # fmt: skip
    assert [type(one.celltype) for one in made] == [sim.IF_curr_exp, sim.IF_curr_exp, sim.SpikeSourceArray]
    built = list(sim.network().populations.values())
    assert [set(one.parameters["tau_m"]) for one in built[:2]] == [{20.0}, {7.0}]
    assert built[2].spike_times_ms[0].tolist() == [3.0]


def test_a_cell_class_without_parameters_is_a_cell_type_with_defaults(sim: ModuleType) -> None:
    with pytest.warns(DeprecationWarning, match="celltype class"):
        cells = sim.Population(2, sim.IF_curr_exp)
    assert cells.get("tau_m") == 20.0


def test_setting_a_view_of_a_view_or_a_single_cell_changes_the_population(sim: ModuleType) -> None:
    cells = sim.Population(6, sim.IF_cond_exp(), label="cells")
    cells[1:5][[0, 2]].set(cm=0.5)
    cells[5].cm = 0.25
    assert cells.get("cm").tolist() == [1.0, 0.5, 1.0, 0.5, 1.0, 0.25]
    assert (cells[3].cm, cells[1:5].get("cm").tolist()) == (0.5, [0.5, 1.0, 0.5, 1.0])


def test_the_old_setters_still_work(sim: ModuleType) -> None:
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    with pytest.warns(DeprecationWarning, match="deprecated"):
        cells.tset("cm", [0.5, 0.25])
    with pytest.warns(DeprecationWarning, match="deprecated"):
        sim.set(cells, tau_m=9.0)
    with pytest.warns(DeprecationWarning, match="deprecated"):
        sim.initialize(cells, v=-70.0)
    (population,) = sim.network().populations.values()
    assert population.parameters["cm"].tolist() == [0.5, 0.25]
    assert population.parameters["tau_m"].tolist() == [9.0, 9.0]
    assert population.initial_values["v"].tolist() == [-70.0, -70.0]


def test_initial_values_of_populations_views_assemblies_and_cells(sim: ModuleType) -> None:
    a = sim.Population(3, sim.IF_cond_exp(), initial_values={"v": [-60.0, -61.0, -62.0]}, label="a")
    b = sim.Population(1, sim.IF_cond_exp(), label="b")
    a[1:].initialize(v=-50.0)
    (a[2:] + b).initialize(gsyn_exc=0.1)
    a[0].set_initial_value("v", -40.0)
    populations = sim.network().populations
    assert populations["a"].initial_values["v"].tolist() == [-40.0, -50.0, -50.0]
    assert populations["a"].initial_values["gsyn_exc"].tolist() == [0.0, 0.0, 0.1]
    assert populations["b"].initial_values["gsyn_exc"].tolist() == [0.1]
    assert a[0].get_initial_value("v") == -40.0


def test_an_unknown_parameter_or_state_variable_is_refused(sim: ModuleType, golden: Golden) -> None:
    cells = sim.Population(1, sim.IF_cond_exp(), label="cells")
    with golden.raises(errors.NonExistentParameterError, match="IF_cond_exp.*'tau_n'.*'tau_m'"):
        sim.IF_cond_exp(tau_n=1.0)
    with pytest.raises(errors.NonExistentParameterError, match="tau_n"):
        cells.get("tau_n")
    with golden.raises(NetworkError, match="'cells': IF_cond_exp.*'w'"):
        cells.initialize(w=1.0)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"cm": -0.1}, "'bad'.*-0.1"),
        ({"tau_m": [20.0, 0.0]}, "tau_m"),
        ({"tau_syn_E": float("nan")}, "tau_syn_E"),
        ({"v_rest": [float("nan"), -65.0]}, "v_rest"),
        ({"tau_refrac": -1.0}, "tau_refrac.*-1"),
    ],
)
def test_an_impossible_parameter_is_refused_where_it_is_given(
    sim: ModuleType, parameters: dict[str, Any], says: str, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=says):
        sim.Population(2, sim.IF_cond_exp(**parameters), label="bad")
    cells = sim.Population(2, sim.IF_cond_exp(), label="bad")
    with golden.raises(NetworkError, match=says):
        cells.set(**parameters)


def test_spike_sources_keep_one_train_a_cell(sim: ModuleType, golden: Golden) -> None:
    sim.Population(2, sim.SpikeSourceArray(spike_times=[1.0, 2.0]), label="same")
    sim.Population(2, sim.SpikeSourceArray(spike_times=[Sequence([1.0]), Sequence([])]), label="own")
    sim.Population(1, sim.SpikeSourceArray(spike_times=[[3.0, 4.0]]), label="one")
    trains = {k: [t.tolist() for t in p.spike_times_ms] for k, p in sim.network().populations.items()}
    assert trains == {"same": [[1.0, 2.0]] * 2, "own": [[1.0], []], "one": [[3.0, 4.0]]}
    with golden.raises(NetworkError, match="'late'"):
        sim.Population(1, sim.SpikeSourceArray(spike_times=[2.0, 1.0]), label="late")


@settings(max_examples=25, deadline=None)
@given(sizes=st.lists(st.integers(1, 5), min_size=1, max_size=4), data=st.data())
def test_an_id_is_the_global_id_of_the_neuron(sizes: list[int], data: st.DataObject) -> None:
    sim = builder()
    populations = [sim.Population(size, sim.IF_cond_exp(), label=str(i)) for i, size in enumerate(sizes)]
    network: Network = sim.network()
    chosen = data.draw(st.sampled_from(range(len(sizes))))
    index = data.draw(st.integers(0, sizes[chosen] - 1))
    assert network.label_of(int(populations[chosen][index])) == (str(chosen), index)


def test_an_assembly_counts_from_its_end_too(sim: ModuleType) -> None:
    a, b = sim.Population(3, sim.IF_cond_exp()), sim.Population(2, sim.IF_cond_exp())
    both = a + b
    assert (both[-1], both[-5], both[3]) == (b[1], a[0], b[0])
    assert both[1:-1].size == both[(1, 2, -2)].size == 3
    assert [int(cell) for cell in both[np.array([True, False, False, True, False])]] == [a[0], b[0]]


def test_a_reset_above_the_threshold_may_pass_while_parameters_are_set(
    sim: ModuleType, golden: Golden
) -> None:
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    cells.set(v_thresh=-70.0)
    with golden.raises(NetworkError, match="v_reset.*-65 mV.*v_thresh"):
        sim.network()
    cells.set(v_reset=-75.0)
    assert sim.network().populations["cells"].parameters["v_reset"][0] == -75.0


def test_labels_are_the_same_in_every_simulator_and_never_twice(sim: ModuleType) -> None:
    def labels(sim: ModuleType) -> list[str]:
        for label in (None, "exc", None, "exc"):
            sim.Population(1, sim.IF_cond_exp(), label=label)
        return list(sim.network().populations)

    assert labels(sim) == labels(builder()) == ["population0", "exc", "population2", "exc 2"]


def test_cells_have_positions_if_the_script_cares_where_they_are(sim: ModuleType) -> None:
    sim.Population(4, sim.IF_cond_exp(), label="nowhere")
    sim.Population((2, 2), sim.IF_cond_exp(), label="grid")
    sim.Population(3, sim.IF_cond_exp(), structure=sim.Line(dx=5.0, y=1.0), label="line")
    placed = sim.Population(1, sim.IF_cond_exp(), label="placed")
    placed.positions = np.array([[1.0], [2.0], [3.0]])
    populations = sim.network().populations
    assert populations["nowhere"].positions_um is None
    assert populations["grid"].positions_um.tolist() == [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]
    assert populations["line"].positions_um.tolist() == [[0, 1, 0], [5, 1, 0], [10, 1, 0]]
    assert populations["placed"].positions_um.tolist() == [[1, 2, 3]]


def test_initial_values_are_read_as_they_were_drawn_and_set(sim: ModuleType, golden: Golden) -> None:
    drawn = sim.RandomDistribution("uniform", low=-70.0, high=-60.0)
    cells = sim.Population(3, sim.IF_cond_exp(), initial_values={"v": drawn}, label="cells")
    cells[1].set_initial_value("v", -50.0)
    cells[2:].initialize(v=-51.0)
    with golden.raises(NetworkError):
        cells[:1].initialize(v=float("nan"))
    seen = cells.initial_values["v"].evaluate()
    assert seen.tolist()[1:] == [-50.0, -51.0]
    assert seen.tolist() == sim.network().populations["cells"].initial_values["v"].tolist()


def test_recording_may_be_requested_but_yields_no_data(sim: ModuleType, golden: Golden) -> None:
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    cells.record(["v", "spikes"])
    cells[0:1].record("gsyn_exc", sampling_interval=0.1)
    with golden.raises(errors.RecordingError, match="IF_cond_exp.*'w'"):
        cells.record("w")
    for ask in (cells.get_data, cells.get_spike_counts, (cells + cells[0:1]).get_data):
        with golden.raises(NetworkError, match="'cells'"):
            ask()


def test_a_constant_current_adds_to_the_offset_of_its_cells(sim: ModuleType) -> None:
    cells = sim.Population(3, sim.IF_cond_exp(i_offset=0.1), label="cells")
    source = sim.DCSource(amplitude=0.2)
    source.inject_into(cells[0:2])
    cells[1].inject(source)
    source.amplitude = 0.4
    (population,) = sim.network().populations.values()
    assert population.parameters["i_offset"] == pytest.approx([0.5, 0.9, 0.1])
    assert cells.get("i_offset") == 0.1


def test_a_current_that_changes_in_steps_is_one_of_the_network(sim: ModuleType) -> None:
    sim.setup(timestep=0.1)
    cells = sim.Population(3, sim.IF_cond_exp(i_offset=0.1), label="cells")
    sim.DCSource(amplitude=0.2, start=5.0, stop=10.0).inject_into(cells[1:])
    sim.DCSource(amplitude=0.5, start=4.0).inject_into(cells[:1])
    cells[2].inject(sim.StepCurrentSource(times=[1.0, 2.0], amplitudes=[0.3, -0.1]))
    network = sim.network()
    assert network.populations["cells"].parameters["i_offset"] == pytest.approx([0.1] * 3)
    found = [
        (one.neurons.tolist(), one.times_ms.tolist(), one.amplitudes_na.tolist()) for one in network.currents
    ]
    assert found == [([1, 2], [5.0, 10.0], [0.2, 0.0]), ([0], [4.0], [0.5]), ([2], [1.0, 2.0], [0.3, -0.1])]


def test_a_sinusoidal_current_is_refused(sim: ModuleType, golden: Golden) -> None:
    cells = sim.Population(1, sim.IF_cond_exp(), label="cells")
    with golden.raises(CapabilityError, match="ACSource.*StepCurrentSource"):
        cells.inject(sim.ACSource(frequency=5.0))
    with golden.raises(TypeError):
        sim.DCSource().inject_into(sim.Population(1, sim.SpikeSourcePoisson()))


def test_an_empty_population_is_refused(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(NetworkError, match="'none'"):
        sim.Population(0, sim.IF_cond_exp(), label="none")


@pytest.mark.parametrize("part", ["cells", "cells[0:1]"])
def test_an_attribute_that_means_a_parameter_is_refused(part: str, golden: Golden) -> None:
    sim = builder()
    names = {"cells": sim.Population(2, sim.IF_curr_exp())}
    target = eval(part, names)
    with golden.raises(NetworkError):
        target.tau_mm = 3.0
    with golden.raises(NetworkError):
        target.tau_m = 3.0
    target.my_note = "kept"
    assert target.my_note == "kept"


def test_a_misspelt_setting_of_setup_is_refused_and_those_of_other_simulators_are_not(golden: Golden) -> None:
    sim = builder()
    sim.setup(timestep=0.5, spike_precision="on_grid", threads=2)
    with golden.raises(NetworkError, match="'timstep'.*'timestep'"):
        sim.setup(timstep=0.5)


def test_parameters_with_a_unit_are_numbers_in_that_of_pynn(sim: ModuleType, golden: Golden) -> None:
    """A public script gives `rate=100.0*Hz, duration=100.0*s`; PyNN itself fails on such scalars."""
    noise = sim.Population(2, sim.SpikeSourcePoisson(rate=100.0 * Hz, start=5.0 * ms, duration=2.0 * s))
    assert noise.get(["rate", "start", "duration"]) == [100.0, 5.0, 2000.0]
    cells = sim.Population(2, sim.IF_curr_exp(v_rest=np.array([-0.065, -0.07]) * V, tau_m=0.02 * s))
    assert (cells.get("v_rest").tolist(), cells.get("tau_m")) == ([-65.0, -70.0], 20.0)
    cells.set(v_reset=-66000.0 * uV)
    cells.initialize(v=-0.06 * V)
    assert cells.get("v_reset") == pytest.approx(-66.0)
    assert cells.initial_values["v"].evaluate(simplify=True) == pytest.approx(-60.0)
    with golden.raises(NetworkError, match="IF_curr_exp: tau_m.*2.0 nS"):
        sim.IF_curr_exp(tau_m=2.0 * nS)
