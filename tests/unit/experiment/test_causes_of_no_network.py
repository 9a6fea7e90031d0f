"""Each cause of a missing network, and of a wrong parameter, has a code whose advice fits it."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks import confined_network
from nrp_core.checks.validate import validate_file
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level
from nrp_core.network.files import read_network, save_network
from nrp_core.network.files.script import load_network

BRAIN = """import nrp_core.pynn as sim
sim.setup(timestep=1.0, max_delay=20000.0)
n = sim.parameter("n", 4, low=1, high=9)
circuit = sim.Population(n, sim.IF_curr_exp(), label="circuit")
sim.Projection(circuit, circuit, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1, delay=1.0))
"""
FUNCTIONS = """
gain = nrp.parameter("gain", 1.0)


@nrp.MapSpikeSource("cell", nrp.brain.circuit[0], nrp.dc_source)
@nrp.Robot2Neuron()
def drive(t, cell):
    cell.amplitude = gain
"""
FILE = """name: cells
timestep: 20 ms
duration: 40 ms
brain: {backend: spinnaker, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
transfer_functions: [drive.py]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(confined_network, "TIME_LIMIT_S", 300.0)  # a slow machine finds the same
    (tmp_path / "experiment.yaml").write_text(FILE)
    (tmp_path / "room.sdf").write_text('<sdf version="1.9"><world name="room"/></sdf>')
    (tmp_path / "brain.py").write_text(BRAIN)
    (tmp_path / "drive.py").write_text(FUNCTIONS)
    save_network(load_network(tmp_path / "brain.py"), tmp_path / "brain.nrpnet")
    return tmp_path


def errors(folder: Path) -> list[Finding]:
    """Return the errors with which a run is refused; a check finds the same."""
    with pytest.raises(InvalidExperimentError) as caught, Run(load_experiment(folder)):
        pass
    found = [one for one in caught.value.findings if one.level is Level.ERROR]
    checked = [one.code for one in validate_file(folder) if one.level is Level.ERROR]
    assert checked == [one.code for one in found]
    return found


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("file", "old", "new", "code"),
    [
        ("brain.py", "weight=0.1", "wieght=0.1", "NRP208"),
        ("brain.py", "n = sim", "import no_such_module\nn = sim", "NRP208"),
        ("brain.py", "delay=1.0", "delay=19000.0", "NRP216"),
        ("brain.py", 'n", 4,', 'n", 40,', "NRP202"),
        (
            "brain.py",
            "circuit =",
            'sim.parameter("n", 5)\ncircuit =',
            "NRP202",
        ),
        ("brain.py", 'n", 4,', 'n", 2 * 2,', "NRP202"),
        ("experiment.yaml", "brain.py", "drive.txt", "NRP208"),
    ],
)
def test_a_cause_has_its_code(folder: Path, file: str, old: str, new: str, code: str) -> None:
    assert old in (folder / file).read_text()
    (folder / "drive.txt").write_text("4 cells\n")
    (folder / file).write_text((folder / file).read_text().replace(old, new, 1))
    (found,) = errors(folder)
    assert found.code is Code[code], found


def test_a_damaged_network_is_not_a_script(folder: Path) -> None:
    (folder / "experiment.yaml").write_text(FILE.replace("brain.py", "brain.nrpnet"))
    kept = (folder / "brain.nrpnet").read_bytes()
    assert read_network(folder / "brain.nrpnet").size == 4
    (folder / "brain.nrpnet").write_bytes(kept[: len(kept) // 2])
    (found,) = errors(folder)
    assert found.code is Code.NRP208


def test_a_script_without_end_has_a_code_of_its_own(folder: Path) -> None:
    (folder / "brain.py").write_text(BRAIN + "while True:\n    pass\n")
    (folder / "experiment.yaml").write_text(FILE.replace("brain.py}", "brain.py, time_limit: 2 s}"))
    with pytest.raises(InvalidExperimentError) as caught, Run(load_experiment(folder)):
        pass
    (found,) = [one for one in caught.value.findings if one.level is Level.ERROR]
    assert found.code is Code.NRP208
    assert found.line in (6, 7)


@pytest.mark.parametrize(
    ("file", "words"),
    [("drive.py", "it is a file of transfer functions"), ("empty.py", "is it the file of the brain?")],
)
def test_a_brain_without_cells_is_one_error_where_the_experiment_names_it(
    folder: Path, file: str, words: str
) -> None:
    (folder / "drive.py").write_text(f"import hbp_nrp_client.tf_framework as nrp\n{FUNCTIONS}")
    (folder / "empty.py").write_text("import nrp_core.pynn as sim\n")
    (folder / "experiment.yaml").write_text(FILE.replace("brain.py", file))
    (found,) = errors(folder)
    said = f"{file} makes no cells, and devices of transfer functions use some: {words}"
    assert (found.path, found.line, found.message) == (folder / "experiment.yaml", 4, said)


def test_an_experiment_whose_functions_use_no_cells_needs_none(folder: Path) -> None:
    (folder / "drive.py").write_text("@nrp.Robot2Neuron()\ndef look(t):\n    print(t)\n")
    (folder / "brain.py").write_text("import nrp_core.pynn as sim\n")
    assert [one for one in validate_file(folder) if one.level is Level.ERROR] == []
