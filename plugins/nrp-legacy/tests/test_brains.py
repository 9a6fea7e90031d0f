"""Brain files of all years become the networks that they describe."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from nrp_legacy.brains import load_brain, remark

from nrp_core.checks.network_units import unlikely_units
from nrp_core.errors import CapabilityError, ExperimentError, NetworkError
from nrp_core.findings import Findings
from nrp_core.network.data import Network
from nrp_core.network.files import read_network, save_network
from nrp_core.xml import Element, parse_xml

SETUP = "import pyNN.nest as sim\nsim.setup(timestep=0.1)\n"
CELLS = SETUP + "circuit = sim.Population(6, sim.IF_cond_alpha, {'tau_m': 10.0})\n"
OF_TODAY = """sim.Projection(circuit[0:1], circuit[1:2], sim.AllToAllConnector(),
    sim.TsodyksMarkramSynapse(weight=1e-4, delay=0.5, U=1.0, tau_rec=2.0, tau_facil=3.0),
    receptor_type='inhibitory')
sim.Projection(circuit[1:2], circuit[2:3], sim.OneToOneConnector(),
    sim.StaticSynapse(weight=2e-4, delay=1.0))
"""
OF_0_7 = """
dynamics = sim.SynapseDynamics(fast=sim.TsodyksMarkramMechanism(U=1.0, tau_rec=2.0, tau_facil=3.0))
sim.Projection(circuit[0:1], circuit[1:2], sim.AllToAllConnector(weights=1e-4, delays=0.5),
    synapse_dynamics=dynamics, target='inhibitory')
sim.Projection(circuit[1:2], circuit[2:3],
    method=sim.OneToOneConnector(weights=2e-4, delays=1.0))
"""


def loaded(folder: Path, text: str, populations: str = "") -> tuple[Network, Findings]:
    path = folder / "brain.py"
    path.write_text(text)
    root = parse_xml(f"<brainModel>{populations}</brainModel>".encode(), Path("b.bibi"), ExperimentError)
    chosen: dict[str, Element] = {one.attributes["population"]: one for one in root.children}
    notes = Findings()
    network = load_brain(path, chosen, 0)
    remark(path, chosen, network, notes.add)
    return network, notes


def test_the_spellings_of_pynn_0_7_mean_those_of_today(tmp_path: Path) -> None:
    old, _ = loaded(tmp_path, CELLS + OF_0_7)
    new, _ = loaded(tmp_path, CELLS + OF_TODAY)
    assert old.digest == new.digest


def test_a_generator_may_stand_where_pynn_0_7_had_the_weights(tmp_path: Path) -> None:
    line = (
        "sim.Projection(circuit, circuit, sim.FixedProbabilityConnector(0.5, True, {}),"
        " sim.StaticSynapse())\n"
    )
    made = [
        loaded(tmp_path, CELLS + line.format(given))[0]
        for given in ("sim.NumpyRNG(seed=5)", "rng=sim.NumpyRNG(seed=5)", "rng=sim.NumpyRNG(seed=6)")
    ]
    assert made[0].digest == made[1].digest != made[2].digest


def test_weights_of_pynn_0_7_can_depend_on_the_distance(tmp_path: Path) -> None:
    network, _ = loaded(
        tmp_path,
        CELLS + "sim.Projection(circuit, circuit, "
        "sim.AllToAllConnector(weights='0.01 * exp(-d)', delays='1.0 + d'), target='excitatory')\n",
    )
    (projection,) = network.projections
    distance = np.abs(np.subtract(projection.pre_index, projection.post_index, dtype=float))
    assert projection.weight == pytest.approx(0.01 * np.exp(-distance))
    assert projection.delay_ms == pytest.approx(1.0 + distance)


@pytest.mark.parametrize(
    "line",
    ["import hbp_nrp_cle.brainsim.simulator as sim", "from python_cle.brainsim import simulator as sim"],
)
def test_the_simulator_of_the_platform_is_one_of_pynn(tmp_path: Path, line: str) -> None:
    network, _ = loaded(tmp_path, f"{line}\ncircuit = sim.Population(6, sim.IF_cond_alpha())\n")
    assert network.size == 6


@pytest.mark.parametrize(
    ("element", "ids"),
    [
        ('<populations population="p" xsi:type="Range" from="1" to="5" step="2"/>', [1, 3]),
        ('<neuronGroup population="p"><element>0</element><element>3</element></neuronGroup>', [0, 3]),
        ('<populations population="p" xsi:type="Index" index="2"/>', [2]),
        ('<populations population="p" xsi:type="Population" count="6"/>', [0, 1, 2, 3, 4, 5]),
    ],
)  # fmt: skip
def test_populations_are_chosen_in_every_form(tmp_path: Path, element: str, ids: list[int]) -> None:
    network, notes = loaded(tmp_path, CELLS, element)
    assert np.asarray(network.views["p"]).tolist() == ids
    assert notes == []


def test_a_count_of_neurons_that_a_population_does_not_have_is_reported(tmp_path: Path) -> None:
    network, notes = loaded(tmp_path, CELLS, '<populations population="p" xsi:type="Population" count="9"/>')
    assert len(network.views["p"]) == 6
    assert notes.messages == ["count of the population 'p' is 9, and brain.py has 6: all are used"]


def test_a_population_beyond_the_brain_has_the_neurons_that_are_there_and_is_reported(tmp_path: Path) -> None:
    network, notes = loaded(tmp_path, CELLS, '<populations population="p" from="4" to="9"/>')
    assert np.asarray(network.views["p"]).tolist() == [4, 5]
    expected = "population 'p' goes to neuron 8, and brain.py has 6: the others are left out"
    assert notes.messages == [expected]


def test_a_population_of_a_name_that_the_file_has_is_the_file_s(tmp_path: Path) -> None:
    element = '<populations population="few" xsi:type="Population" count="2"/>'
    network, _ = loaded(tmp_path, CELLS + "few = circuit[4:6]\n", element)
    assert np.asarray(network.views["few"]).tolist() == [4, 5]


def test_a_name_without_neurons_is_reported(tmp_path: Path) -> None:
    _, notes = loaded(tmp_path, CELLS, '<populations population="p" from="7" to="9"/>')
    assert notes.messages == ["population 'p' has no neurons in brain.py: from=7, to=9"]


def test_a_script_without_a_circuit_is_named_as_the_cause(tmp_path: Path) -> None:
    element = '<populations population="p" from="0" to="2"/>'
    _, notes = loaded(tmp_path, CELLS.replace("circuit", "neurons"), element)
    assert notes.messages == [
        "population 'p' has no neurons in brain.py: from=0, to=2; the script has no variable 'circuit' with "
        "cells, from which they are chosen"
    ]


def test_a_brain_in_another_kind_of_file_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match=r"\.h5.*'brain.sli'"):
        load_brain(tmp_path / "brain.sli", {}, 0)


def test_a_machine_accepts_calls_and_its_devices_send_nothing(tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(
        "import pyNN.spiNNaker as sim\n"
        "import spynnaker_external_devices_plugin.pyNN as external\n"
        "sim.setup(timestep=1.0)\n"
        "sim.set_number_of_neurons_per_core(sim.IF_curr_exp, 50)\n"
        "live = sim.Population(2, sim.external_devices.SpikeInjector(), label='live')\n"
        "cells = sim.Population(3, sim.IF_curr_exp())\n"
        "external.activate_live_output_for(cells)\n"
        "circuit = cells\n"
    )
    network = load_brain(path, {}, 0)
    assert [len(network.neurons(name)) for name in ("live", "circuit")] == [2, 3]


def test_a_network_whose_weights_are_numbers_of_numpy_is_kept_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(
        "import numpy as np\nimport pyNN.nest as sim\ncircuit = sim.Population(2, sim.IF_curr_exp())\n"
        "w = np.array([0.5])\n"
        "sim.Projection(circuit, circuit, sim.AllToAllConnector(),\n"
        "    sim.StaticSynapse(weight=w[0], delay=w[0]))\n"
    )
    network = load_brain(path, {}, 0)
    save_network(network, tmp_path / "brain.nrpnet")
    assert read_network(tmp_path / "brain.nrpnet").digest == network.digest


def test_a_brain_of_2019_logs_divides_and_scales_its_synapses_by_a_function_of_nest(
    tmp_path: Path, golden: Golden
) -> None:
    text = (
        f"from __future__ import division\n{SETUP}from past.utils import old_div\nimport nest\n"
        "from hbp_nrp_excontrol.logs import clientLogger\n"
        "circuit = sim.Population(old_div(7, 2), sim.IF_curr_exp())\n"
        "scale = nest.ll_api.sli_func('LambertWm1', -0.1)\nclientLogger.info('scale', scale)\n"
        "sim.Projection(circuit[0:1], circuit[1:3], sim.AllToAllConnector(), "
        "sim.StaticSynapse(weight=[[-scale, 2.0]]))\n"
    )
    network, notes = loaded(tmp_path, text)
    assert not list(notes)
    weight = network.projections[0].weight
    # the lower branch of w exp(w) = -0.1 is below -1
    assert weight[0] > 1.0
    assert weight[0] * np.exp(-weight[0]) == pytest.approx(0.1, rel=1e-12)
    with golden.raises(NetworkError, match=r"sli_func\('LambertW1'"):
        loaded(tmp_path, text.replace("LambertWm1", "LambertW1"))


def test_negative_weights_of_conductances_inhibit_by_their_size_as_in_nest(
    tmp_path: Path, golden: Golden
) -> None:
    line = "sim.Projection(circuit, circuit, sim.OneToOneConnector(), sim.StaticSynapse(weight={}, delay=1.0)"
    sizes = "sim.RandomDistribution('uniform', ({}, {}), rng=sim.NumpyRNG(seed=3))"
    (given,) = loaded(tmp_path, CELLS + line.format("-2e-4") + ")\n")[0].projections
    (drawn,) = loaded(tmp_path, CELLS + line.format(sizes.format(-2e-4, -1e-4)) + ")\n")[0].projections
    assert (given.receptor, drawn.receptor) == ("inhibitory", "inhibitory")
    assert np.ptp(given.weight) == 0
    assert given.weight[0] == pytest.approx(2e-4)
    assert np.all((drawn.weight > 1e-4) & (drawn.weight < 2e-4))
    with golden.raises(NetworkError):
        loaded(tmp_path, CELLS + line.format("-2e-4") + ", receptor_type='excitatory')\n")
    of_currents = CELLS.replace("IF_cond_alpha", "IF_curr_alpha") + line.format("-2e-4") + ")\n"
    (current,) = loaded(tmp_path, of_currents)[0].projections
    assert current.weight[0] == pytest.approx(-2e-4)


@pytest.mark.parametrize(("cells", "sign"), [("IF_curr_exp", -1), ("IF_cond_exp", 1)])  # of inhibition
@pytest.mark.parametrize("ends", ["a, b", "a + b, b"])
def test_weights_of_both_signs_act_on_the_receptor_that_nest_chooses(
    tmp_path: Path, cells: str, sign: int, ends: str
) -> None:
    (tmp_path / "b.py").write_text(f"""
from hbp_nrp_cle.brainsim import simulator as sim
import numpy as np
a, b = sim.Population(2, sim.{cells}()), sim.Population(2, sim.{cells}())
ends = [{ends}]
weights = np.array([[1.0, -0.5], [0.2, 0.0], [-0.3, 0.1], [0.4, -0.6]])[:ends[0].size]
sim.Projection(*ends, sim.AllToAllConnector(), sim.StaticSynapse(weight=weights))
circuit = a + b
""")
    network = load_brain(tmp_path / "b.py", {}, seed=1)
    found: dict[str, list[float]] = {"excitatory": [], "inhibitory": []}
    for part in network.projections:
        found[part.receptor] += part.weight.tolist()
    excitatory, inhibitory = [0.0, 0.2, 1.0], [-0.5]
    if ends != "a, b":
        excitatory, inhibitory = [0.0, 0.1, 0.2, 0.4, 1.0], [-0.6, -0.5, -0.3]
    assert sorted(found["excitatory"]) == excitatory
    assert sorted(found["inhibitory"]) == sorted(-sign * one for one in inhibitory)


def test_weights_below_0_inhibit_cells_that_take_currents_whatever_their_receptor(tmp_path: Path) -> None:
    """PyNN checks the weights of a new projection, NEST not those that are set later."""
    weights = "projection.set(weight=np.array([[0.0, -10.0], [-5.0, 0.0]]))\n"
    ends = "circuit[:2], circuit[:2]"
    projection = f"projection = sim.Projection({ends}, sim.AllToAllConnector(), sim.StaticSynapse())\n"
    cells = CELLS.replace("IF_cond_alpha", "IF_curr_alpha") + "import numpy as np\n"
    parts = loaded(tmp_path, cells + projection + weights)[0].projections
    found = {part.receptor: sorted(part.weight.tolist()) for part in parts}
    assert found == {"excitatory": [0.0, 0.0], "inhibitory": [-10.0, -5.0]}


def test_limits_of_a_uniform_distribution_may_come_in_any_order(tmp_path: Path) -> None:
    text = CELLS + "from pyNN.random import RandomDistribution\n"
    for written in ("('uniform', (3.0, 1.0))", "('uniform', low=3.0, high=1.0)"):
        drawn = f"weight = RandomDistribution{written}\n"
        network, _ = loaded(
            tmp_path,
            text + drawn + "sim.Projection(circuit, circuit, sim.AllToAllConnector(), "
            "sim.StaticSynapse(weight=weight), receptor_type='excitatory')\n",
        )
        weight = network.projections[0].weight
        assert 1.0 <= weight.min() < 1.5
        assert 2.5 < weight.max() <= 3.0


@pytest.mark.parametrize(
    "synapses",
    [
        "sim.TsodyksMarkramSynapse(weight=1.0, U=1.0, tau_rec=0.0, tau_facil=0.0)",
        "sim.native_synapse_type('tsodyks_synapse')(weight=1.0, U=1.0, tau_rec=0.0, tau_fac=0.0)",
    ],
)
def test_synapses_that_recover_at_once_do_so_within_a_nanosecond(tmp_path: Path, synapses: str) -> None:
    network, _ = loaded(
        tmp_path, CELLS + f"sim.Projection(circuit, circuit, sim.AllToAllConnector(), {synapses})\n"
    )
    assert set(network.projections[0].synapse_parameters["tau_rec"].tolist()) == {1e-6}
    assert unlikely_units(network) == []


def test_synapses_of_nest_recover_at_once_too(tmp_path: Path) -> None:
    text = "import nest\ncircuit = nest.Create('iaf_cond_alpha', 2)\n"
    text += "synapse = {'model': 'tsodyks_synapse', 'U': 1.0, 'tau_rec': 0.0, 'weight': 1.0}\n"
    network, _ = loaded(tmp_path, text + "nest.Connect(circuit[:1], circuit[1:], 'all_to_all', synapse)\n")
    assert network.projections[0].synapse_parameters["tau_rec"].tolist() == [1e-6]


def test_a_copied_model_of_nest_is_a_cell_type_of_pynn(tmp_path: Path) -> None:
    text = SETUP + "sim.nest.CopyModel('iaf_cond_alpha', 'my_cell', {'t_ref': 7.0, 'E_L': -65.0})\n"
    text += "circuit = sim.Population(2, sim.native_cell_type('my_cell')(E_L=-66.0))\n"
    network, _ = loaded(tmp_path, text)
    (population,) = network.populations.values()
    assert population.cell_type == "IF_cond_alpha"
    assert population.parameters["tau_refrac"].tolist() == [7.0, 7.0]
    assert population.parameters["v_rest"].tolist() == [-66.0, -66.0]


def test_a_copied_synapse_model_of_nest_is_a_synapse_type_of_pynn(tmp_path: Path) -> None:
    text = CELLS + "sim.nest.CopyModel('tsodyks_synapse', 'mine', {'U': 0.3, 'tau_rec': 0.0})\n"
    text += "kind = sim.native_synapse_type('mine')\n"
    text += "sim.Projection(circuit, circuit, sim.AllToAllConnector(), kind(weight=1.0))\n"
    (projection,) = loaded(tmp_path, text)[0].projections
    assert set(projection.synapse_parameters["U"].tolist()) == {0.3}


OWN_CONNECTOR = """
import nest
from pyNN.connectors import Connector

class Listed(Connector):
    def __init__(self, pairs):
        self.source, self.target = zip(*pairs)

    def connect(self, projection):
        nest.Connect([projection.pre.all_cells[i] for i in self.source],
                     [projection.post.all_cells[j] for j in self.target],
                     RULE, syn_spec=projection.nest_synapse_model)

synapse = sim.TsodyksMarkramSynapse(weight=0.5, delay=2.0, U=0.3, tau_rec=4.0, tau_facil=0.0)
made = sim.Projection(circuit[0:3], circuit[2:6], Listed([(0, 3), (2, 1)]), synapse)
assert made.nest_synapse_model == "tsodyks_synapse"
"""


def test_a_connector_of_a_user_connects_by_nest(tmp_path: Path, golden: Golden) -> None:
    network, _ = loaded(tmp_path, CELLS + OWN_CONNECTOR.replace("RULE", "'one_to_one'"))
    (projection,) = network.projections
    assert list(zip(projection.pre_index.tolist(), projection.post_index.tolist(), strict=True)) == [
        (2, 3),
        (0, 5),
    ]
    assert set(projection.weight.tolist()) == {0.5}
    assert set(projection.synapse_parameters["U"].tolist()) == {0.3}
    (projection,) = loaded(tmp_path, CELLS + OWN_CONNECTOR.replace("RULE", "'all_to_all'"))[0].projections
    assert len(projection.weight) == 4
    with golden.raises(CapabilityError, match="'fixed_indegree'"):
        loaded(tmp_path, CELLS + OWN_CONNECTOR.replace("RULE", "'fixed_indegree'"))


def test_a_brain_file_that_imports_messages_is_not_accused(tmp_path: Path) -> None:
    text = f"from std_msgs.msg import String\n{SETUP}circuit = sim.Population(2, sim.IF_cond_alpha())\n"
    network, notes = loaded(tmp_path, text)
    assert (network.size, list(notes)) == (2, [])
