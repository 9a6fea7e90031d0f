"""Receptors that cells in equations name themselves, in networks, their files and their controls."""

from __future__ import annotations

from pathlib import Path

from golden import Golden

from nrp_core.brain import builder
from nrp_core.errors import NetworkError
from nrp_core.network.controls import with_shuffled_signs
from nrp_core.network.data import Network
from nrp_core.network.files import read_network, save_network
from nrp_core.recording.folder.recording_folder import projection_data
from nrp_core.seeds import Seeds


def network() -> Network:
    """Return four cells, of which two end on a receptor that excites and two on one that inhibits."""
    sim = builder()
    kind = sim.PointNeuron(sim.LIF(), GABAA=sim.ExpPSR(), AMPA=sim.ExpPSR(), inhibitory=sim.ExpPSR())
    cells = sim.Population(4, kind, label="cells")
    for first, receptor in ((0, "AMPA"), (2, "GABAA")):
        synapse = sim.StaticSynapse(weight=0.1)
        some = cells[first : first + 2]
        sim.Projection(some, cells, sim.AllToAllConnector(), synapse, receptor_type=receptor, label=receptor)
    found: Network = sim.network()
    return found


def test_a_file_keeps_them(tmp_path: Path) -> None:
    save_network(network(), tmp_path / "named.h5")
    kept = read_network(tmp_path / "named.h5")
    assert [projection.receptor for projection in kept.projections] == ["AMPA", "GABAA"]
    assert kept.digest == network().digest


def test_receptors_that_pynn_lists_as_inhibitory_inhibit() -> None:
    shown = {one.label: projection_data(one)["excites"] for one in network().projections}
    assert shown == {"AMPA": True, "GABAA": False}


def test_the_usual_ones_keep_their_numbers_and_others_fill_the_gaps() -> None:
    cells = network().populations["cells"]
    numbers = {name: cells.receptor_number(name) for name in ("GABAA", "AMPA", "inhibitory")}
    assert numbers == {"GABAA": 0, "inhibitory": 1, "AMPA": 2}


def test_signs_are_not_exchanged_between_receptors_without_an_opposite(golden: Golden) -> None:
    with golden.raises(NetworkError):
        with_shuffled_signs(network(), Seeds(0))
