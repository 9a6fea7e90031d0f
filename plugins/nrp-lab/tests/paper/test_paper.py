"""An experiment as an archive, and its repetition."""

import json
import subprocess
import sys
import zipfile
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.paper import requirements
from nrp_lab.paper.archive import write_archive
from nrp_lab.paper.methods import values_text
from nrp_lab.paper.verification import Outcome, compare_runs

from nrp_core import shipped
from nrp_core.recording import Recording

pytestmark = pytest.mark.slow
SETTINGS = ("duration=500ms", "comparison=null", "world.options.image_scale=0.25")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seeds of half a second on both engines."""
    target = tmp_path_factory.mktemp("paper") / "husky.zip"
    grid = RunGrid.of("braitenberg_husky", (), ("mujoco", "pybullet"), 2, SETTINGS)
    write_archive(grid, target, 1, lambda done, total, last: None)
    return target


def test_an_archive_has_runs_figures_methods_and_the_verdict(archive: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(tmp_path)
    manifest = json.loads((tmp_path / "paper.json").read_text())
    assert {(run["world"], run["seed"]) for run in manifest["runs"]} == {
        (world, seed) for world in ("mujoco", "pybullet") for seed in (7, 8)
    }
    for run in manifest["runs"]:
        assert not Recording(tmp_path / run["folder"]).check().flaws
    assert {"run.svg", "raster.svg", "trajectory.svg"} <= {each.name for each in tmp_path.glob("figures/*")}
    assert manifest["verdict"] in (tmp_path / "verdict.html").read_text()
    methods = (tmp_path / "methods.md").read_text()
    assert "| circuit | neurons | IF_cond_alpha | 8 |" in methods
    assert "| 0.0012 uS | 0.1 ms |" in methods
    assert "husky: 45.4 kg, 6 links, 5 joints" in methods
    assert str(Path.cwd()) not in methods
    lines = (tmp_path / "requirements.txt").read_text().splitlines()
    assert {f"nrp-core=={version('nrp-core')}", f"numpy=={version('numpy')}"} <= set(lines)
    assert not any(line.startswith(("mypy", "ruff", "pip=")) for line in lines)
    assert r"circuit & neurons & IF\_cond\_alpha & 8 \\" in (tmp_path / "tables.tex").read_text()
    wheels = {path.name.partition("-")[0] for path in tmp_path.glob("wheels/*.whl")}
    assert {"nrp_core", "nrp_lab"} <= wheels


def test_an_archive_names_no_folder_of_its_author(archive: Path) -> None:
    here = {
        Path(place).as_posix()[1:]
        for place in (*sys.path, Path.cwd(), sys.prefix)
        if len(Path(place).parts) > 2
    }
    with zipfile.ZipFile(archive) as packed:
        for name in packed.namelist():
            if not name.endswith((".whl", ".mcap")):
                content = name + packed.read(name).decode()
                assert not [place for place in here if f"/{place}/" in content], name


OWN = {
    "experiment.yaml": """
name: own
duration: 40 ms
timestep: 20 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
""",
    "brain.py": """
import own_module
import pyNN.nest as sim
sim.setup(timestep=0.1)
cells = sim.Population(own_module.SIZE, sim.IF_curr_exp(), label="cells")
""",
    "room.sdf": '<sdf version="1.9"><world name="room"/></sdf>',
}


def test_an_archive_names_packages_and_files_that_its_runs_read_by_way_of_a_module(
    nrp: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modules, experiment = tmp_path / "modules", tmp_path / "experiment"
    modules.mkdir()
    experiment.mkdir()
    (modules / "own_module.py").write_text("import sortedcontainers\nSIZE = 3\n")
    for name, text in OWN.items():
        (experiment / name).write_text(text)
    monkeypatch.syspath_prepend(str(modules))
    monkeypatch.setenv("PYTHONPATH", str(modules))  # of the process that runs
    target = tmp_path / "own.zip"
    done = nrp("paper", experiment / "experiment.yaml", "--seeds", 1, "--jobs", 1, "-o", target, "--json")
    assert done.code == 0
    own = str(modules / "own_module.py")
    assert json.loads(done.out)["elsewhere"] == [own]
    assert own in done.err
    with zipfile.ZipFile(target) as packed:
        lines = packed.read("requirements.txt").decode().splitlines()
        readme = packed.read("README.md").decode()
        assert "/own_module.py`" in readme
        assert str(tmp_path) not in readme
    assert f"sortedcontainers=={version('sortedcontainers')}" in lines
    assert f"nrp-lab=={version('nrp-lab')}" in lines
    assert not any(line.startswith(("nrp-legacy", "matplotlib")) for line in lines), "not read"


def test_its_runs_are_identical_when_they_are_repeated(nrp: Any, archive: Path) -> None:
    done = nrp("paper", archive, "--verify", "--json")
    found = json.loads(done.out)
    assert done.code == 0
    assert [(run["outcome"], run["steps"]) for run in found["runs"]] == [("identical", 25)] * 4


def test_nothing_is_run_if_a_file_was_changed(nrp: Any, archive: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed.zip"
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            target.writestr(
                name,
                content.replace(b"IF_cond_alpha", b"IF_cond_exp") if name.endswith("brain.py") else content,
            )
    done = nrp("paper", changed, "--verify", "--json")
    found = json.loads(done.out)
    assert done.code == 1
    assert len(found["changed"]) == 4
    assert not found["runs"]


def test_a_run_that_ends_elsewhere_is_different(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "one"
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(folder)
    manifest = json.loads((folder / "paper.json").read_text())
    one = next(run for run in manifest["runs"] if run["world"] == "mujoco")
    one["final_pose"]["husky"]["x"] += 1.0
    result = Recording(folder / one["folder"]).run["result"]
    criteria = {name: each["passed"] for name, each in result["criteria"].items()}
    assert compare_runs(one, criteria, result["final_pose"], 0.01)[0] is Outcome.DIFFERENT
    one["final_pose"]["husky"]["x"] -= 0.999
    assert compare_runs(one, criteria, result["final_pose"], 0.01)[0] is Outcome.EQUIVALENT
    one["criteria"] = dict.fromkeys(criteria, True)
    assert compare_runs(one, criteria, result["final_pose"], 0.01)[0] is Outcome.DIFFERENT


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("braitenberg_husky", "-o", "husky.tar"), "husky.tar"),
        (("nothing.zip", "--verify"), "nothing.zip"),
        (("braitenberg_husky", "--verify", "--seeds", 3), "--seeds"),
    ],
)
def test_a_mistake_is_one_sentence(nrp: Any, arguments: tuple[object, ...], words: str) -> None:
    done = nrp("paper", *arguments)
    assert done.code != 0
    assert words in done.err


def test_several_values_are_their_range_and_mean() -> None:
    assert values_text([2.0, 2.0]) == "2"
    assert values_text([1.0, 3.0]) == "1 to 3, mean 2"


@pytest.mark.heavy
@pytest.mark.parametrize("name", [name for name in shipped() if "/" not in name])
def test_every_experiment_that_ships_is_an_archive_that_can_be_repeated(
    nrp: Any, name: str, tmp_path: Path
) -> None:
    """One run of each, to its end."""
    target = tmp_path / f"{name}.zip"
    assert nrp("paper", name, "--seeds", 1, "-s", "comparison=null", "-o", target).code == 0
    done = nrp("paper", target, "--verify", "--json")
    assert done.code == 0
    assert [run["outcome"] for run in json.loads(done.out)["runs"]] == ["identical"]


def test_wheels_that_cannot_be_built_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    origin = json.dumps({"url": tmp_path.as_uri(), "dir_info": {"editable": True}})
    monkeypatch.setattr(requirements, "distribution", lambda _: SimpleNamespace(read_text=lambda _: origin))
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=1))
    assert requirements.write_wheels(["nrp-core==1", "numpy==2"], tmp_path) == ["nrp-core"]


def test_an_archive_is_verified_without_matplotlib_which_it_does_not_require() -> None:
    hidden = "import sys; sys.modules['matplotlib'] = None; import nrp_lab.paper.verification"
    subprocess.run([sys.executable, "-P", "-c", hidden], check=True)
