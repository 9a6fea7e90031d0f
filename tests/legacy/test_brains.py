"""Brain files of all years become the networks that they describe."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from nrp_legacy.brains import load_brain, remark

from nrp_core.brain.network import Network
from nrp_core.errors import ExperimentError, NetworkError
from nrp_core.xml_tree import Element, parse_xml

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


def loaded(folder: Path, text: str, populations: str = "") -> tuple[Network, list[str]]:
    path = folder / "brain.py"
    path.write_text(text)
    root = parse_xml(f"<brainModel>{populations}</brainModel>".encode(), Path("b.bibi"), ExperimentError)
    chosen: dict[str, Element] = {one.attributes["population"]: one for one in root.children}
    notes: list[str] = []
    network = load_brain(path, chosen, 0)
    remark(path, chosen, network, notes.append)
    return network, notes


def test_the_spellings_of_pynn_0_7_mean_those_of_today(tmp_path: Path) -> None:
    old, _ = loaded(tmp_path, CELLS + OF_0_7)
    new, _ = loaded(tmp_path, CELLS + OF_TODAY)
    assert old.digest == new.digest


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
        ('<populations population="p" from="4" to="9"/>', [4, 5]),
        ('<neuronGroup population="p"><element>0</element><element>3</element></neuronGroup>', [0, 3]),
        ('<populations population="p" xsi:type="Index" index="2"/>', [2]),
        ('<populations population="p" xsi:type="Population" count="6"/>', [0, 1, 2, 3, 4, 5]),
    ],
)  # fmt: skip
def test_populations_are_chosen_in_every_form(tmp_path: Path, element: str, ids: list[int]) -> None:
    network, notes = loaded(tmp_path, CELLS, element)
    assert np.asarray(network.views["p"]).tolist() == ids
    assert notes == []


def test_a_population_of_a_name_that_the_file_has_is_the_file_s(tmp_path: Path) -> None:
    element = '<populations population="few" xsi:type="Population" count="2"/>'
    network, _ = loaded(tmp_path, CELLS + "few = circuit[4:6]\n", element)
    assert np.asarray(network.views["few"]).tolist() == [4, 5]


def test_a_name_without_neurons_is_told(tmp_path: Path) -> None:
    _, notes = loaded(tmp_path, CELLS, '<populations population="p" from="7" to="9"/>')
    assert notes == ["population 'p' has no neurons in brain.py"]


def test_a_brain_in_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match=r"brains are read from \.py and \.h5 files, not from 'brain.sli'"):
        load_brain(tmp_path / "brain.sli", {}, 0)
