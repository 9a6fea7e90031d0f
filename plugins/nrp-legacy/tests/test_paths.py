"""Files that code names by paths of other machines are found, and written where there is a place for them."""

from __future__ import annotations

import csv
import pickle
from pathlib import Path

import h5py
import numpy as np
import pytest
from nrp_legacy.brains import load_brain
from nrp_legacy.code import Source, ignore_note
from nrp_legacy.files import Library
from nrp_legacy.namespace import Namespace
from nrp_legacy.shims.paths import Paths

# code of Python 2 leaves files open
pytestmark = pytest.mark.filterwarnings(
    "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)

FAR = "/home/nobody/.opt/nrpStorage/exp_0/resources"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder of an experiment with data."""
    resources = tmp_path / "experiment" / "resources"
    resources.mkdir(parents=True)
    (resources / "rows.csv").write_text("a,b\n1,2\n")
    (resources / "numbers.pkl").write_bytes(pickle.dumps({"gain": [2]}, 0))
    np.save(resources / "weights.npy", np.array({"w": 3}, dtype=object), allow_pickle=True)
    return resources.parent


def run(folder: Path, code: str) -> dict[str, object]:
    """Execute code as a transfer function file and return its names."""
    path = folder / "tf.py"
    path.write_text(code)
    names = Namespace(ignore_note, Library(folder))
    source = Source.of_file(path).compiled(ignore_note)
    return vars(names.scope.run(path, names.module, source))


@pytest.mark.parametrize("place", [FAR, "resources"])
def test_tables_are_found_by_the_end_of_their_path(folder: Path, place: str) -> None:
    pytest.importorskip("pandas")
    with h5py.File(folder / "resources" / "spikes.h5", "w") as file:
        file["times"] = [1.5]
    found = run(
        folder,
        "import pandas as pd, h5py, glob\n"
        f"column = pd.read_csv('{place}/rows.csv')['b'].tolist()\n"
        f"times = h5py.File('{place}/spikes.h5')['times'][:].tolist()\n"
        "csv = [path.rpartition('/')[2] for path in glob.glob('resources/*.csv')]\n",
    )
    assert (found["column"], found["times"], found["csv"]) == ([2], [1.5], ["rows.csv"])


def test_the_storage_of_the_platform_is_the_folder_around_the_experiment(folder: Path) -> None:
    code = (
        "import os\nfolder = '/home/nobody/.opt/nrpStorage/'\n"
        "found = [folder + name for name in os.listdir(folder) if name.startswith('experiment')]\n"
        "rows = open(found[0] + '/resources/rows.csv').read()\n"
    )
    assert run(folder, code)["rows"] == "a,b\n1,2\n"


def test_data_are_found_by_the_end_of_their_path(folder: Path) -> None:
    found = run(
        folder,
        "import os, csv, cPickle\n"
        f"rows = [row for row in csv.reader(open('{FAR}/rows.csv', 'rb'))]\n"
        f"gain = cPickle.load(open('{FAR}/numbers.pkl'))['gain']\n"
        f"weight = np.load('{FAR}/weights.npy').item()['w']\n"
        f"table = np.loadtxt('resources/rows.csv', delimiter=',', skiprows=1)\n"
        f"there = os.path.isfile('{FAR}/rows.csv'), os.path.exists('{FAR}/no.csv')\n"
        f"names = sorted(os.listdir(os.path.join(os.environ['NRP_EXPERIMENT_DIRECTORY'], 'resources')))\n",
    )
    assert found["rows"] == [["a", "b"], ["1", "2"]]
    assert (found["gain"], found["weight"], found["there"]) == ([2], 3, (True, False))
    assert np.array_equal(found["table"], [1.0, 2.0])  # type: ignore[arg-type]
    assert found["names"] == ["numbers.pkl", "rows.csv", "weights.npy"]


def test_modules_that_are_imported_find_data_too(folder: Path) -> None:
    (folder / "helper.py").write_text(f"text = open('{FAR}/rows.csv').read()\n")
    assert run(folder, "import helper\n")["helper"].text == "a,b\n1,2\n"  # type: ignore[attr-defined]


def test_folders_of_modules_are_found_by_the_end_of_their_path(folder: Path) -> None:
    (folder / "lib" / "control").mkdir(parents=True)
    (folder / "lib" / "control" / "__init__.py").write_text("")
    (folder / "lib" / "control" / "gains.py").write_text("GAIN = 7 / 2\nprint 'py2'\n")
    found = run(
        folder, "import sys\nsys.path.append('/home/nobody/lib')\nfrom control.gains import GAIN as gain\n"
    )
    assert found["gain"] == 3


def test_a_file_without_a_declared_folder_is_written_beside_the_experiment(folder: Path) -> None:
    run(
        folder,
        "import csv\n"
        "import logging\nclass Kept(logging.FileHandler): pass\n"
        f"logging.getLogger('own').addHandler(Kept('{FAR}/own.log'))\n"
        f"logging.getLogger('own').warning('kept')\n"
        f"table = open('{FAR}/out.csv', 'wb')\ncsv.writer(table).writerow(['t', 1])\ntable.close()\n"
        f"log = open('{FAR}/out.txt', 'w', 0)\nprint >>log, 'so'\nlog.close()\n"
        f"np.savetxt('{FAR}/numbers.txt', [1.5])\n",
    )
    assert list(csv.reader((folder / "out.csv").read_text().splitlines())) == [["t", "1"]]
    assert (folder / "out.txt").read_text() == "so\n"
    assert (folder / "own.log").read_text() == "kept\n"
    assert float((folder / "numbers.txt").read_text()) == 1.5


def test_a_file_that_is_there_is_the_one_that_is_meant(folder: Path) -> None:
    other = folder.parent / "rows.csv"
    other.write_text("other")
    assert Paths(Library(folder)).there(str(other)) == str(other)
    with pytest.raises(FileNotFoundError):
        Paths(Library(folder)).open(f"{FAR}/nowhere.csv")


def test_brains_find_data_and_folders_of_the_platform(folder: Path) -> None:
    path = folder / "brain.py"
    path.write_text(
        "import os, csv\nimport pyNN.nest as sim\nos.environ['HBP']\n"
        f"size = int([r for r in csv.reader(open('{FAR}/rows.csv', 'rb'))][1][1])\n"
        "circuit = sim.Population(size, sim.IF_cond_exp())\n"
    )
    assert load_brain(path, {}, 0, library=Library(folder)).size == 2
