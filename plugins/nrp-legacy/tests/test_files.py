"""Files are found by the names that experiments of all times and machines give them."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from nrp_legacy.documents import FileNamed
from nrp_legacy.files import Library
from nrp_legacy.reader import read_exc

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.xml import parse_xml

EXPERIMENT = '<ExD><environmentModel src="room"/><bibiConf src="x.bibi"/></ExD>'
BIBI = """<bibi><bodyModel>husky_model</bodyModel><brainModel>two_cells</brainModel>
<transferFunction>@nrp.MapCSVRecorder("rows", filename="rows.csv", headers=["t"])
@nrp.Robot2Neuron()
def function(t, rows):
    rows.record_entry(t)
</transferFunction></bibi>"""


@pytest.fixture
def library(corpus: Path, tmp_path: Path) -> Library:
    """An experiment beside a library: it holds archives and a room of its own."""
    folder, models = tmp_path / "lab" / "Experiment", corpus / "models"
    (folder / "rooms").mkdir(parents=True)
    (folder / "rooms" / "Hall.sdf").write_text("<sdf version='1.5'><world name='w'/></sdf>")
    with zipfile.ZipFile(folder / "husky.zip", "w") as archive:
        archive.write(models / "husky_model" / "model.sdf", "husky_v2/newest.sdf")
        archive.writestr("husky_v2/model.config", "<model><sdf version='1.6'>newest.sdf</sdf></model>")
        archive.writestr("husky_v2/lift.sdf", "")
    with zipfile.ZipFile(folder / "brain.zip", "w") as archive:
        archive.writestr("cells/cells.py", "")
        archive.writestr("cells/__init__.py", "")
    for place in (folder / "mouse/model.sdf", models / "arm/arm.sdf", models / "arm/arm_gripper.sdf"):
        place.parent.mkdir(exist_ok=True)
        place.touch()
    (models / "circle").symlink_to(models, target_is_directory=True)
    return Library(folder, [models])


def named(attributes: str, text: str) -> FileNamed:
    return FileNamed.of(parse_xml(f"<it {attributes}>{text}</it>".encode(), Path("x.bibi"), ValueError))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("attributes", "text", "found"),
    [
        ("", "/home/bbpnrsoa/.opt/nrp/Models/husky_model/model.sdf", "husky_model/model.sdf"),
        ("", "$NRP_MODELS_DIRECTORY/husky_model/model.sdf", "husky_model/model.sdf"),
        ("", "$(HBP)/Models/husky_model/model.sdf", "husky_model/model.sdf"),
        ("", "~/.opt/nrp/Models/Husky_Model/Model.SDF", "husky_model/model.sdf"),
        ("", r"C:\NRP\Models\husky_model\model.sdf", "husky_model/model.sdf"),
        ("", "model://husky_model", "husky_model/model.sdf"),
        ("", "../../Models/husky_model/model.sdf", "husky_model/model.sdf"),
        ("model='husky_model'", "model.sdf", "husky_model/model.sdf"),
        ("customAsset='true' assetPath='husky.zip'", "model.sdf", "husky_v2/newest.sdf"),
        ("customAsset='true' assetPath='husky.zip'", "lift.sdf", "husky_v2/lift.sdf"),
        ("customAsset='false' assetPath='arm'", "arm_gripper.sdf", "arm/arm_gripper.sdf"),
        ("customAsset='false' assetPath='arm'", "arm/arm_gripper.sdf", "arm/arm_gripper.sdf"),
        ("customAsset='false' assetPath='arm'", "", "arm/arm.sdf"),
        ("customAsset='false' assetPath='arm'", "arm_left.sdf", None),
        ("robotId='mouse'", "model.sdf", "mouse/model.sdf"),
        ("", "storage://experiment-1/husky.zip", "husky_v2/newest.sdf"),
        ("", "storage://experiment-1/rooms/hall.sdf", "rooms/Hall.sdf"),
        ("src='rooms'", "", "rooms/Hall.sdf"),
        ("", "nowhere/model.sdf", None),
        ("", "no_such_model", None),
    ],
)
def test_a_robot_or_room_is_found_by_its_name(
    library: Library, attributes: str, text: str, found: str | None
) -> None:
    path = library.find_sdf(named(attributes, text))
    assert path is None if found is None else str(path).endswith(found)


@pytest.mark.parametrize(
    ("text", "files", "found"),
    [
        ("nao/model.sdf", ["robots/nao/model.urdf"], "nao/model.urdf"),
        ("nao/nao.urdf", ["nao/nao.sdf"], "nao/nao.sdf"),
        ("lab/hall.sdf", ["worlds/hall_2018/hall.sdf"], "hall_2018/hall.sdf"),
        ("lab/hall.sdf", ["new/hall.sdf", "old/hall.sdf"], "new/hall.sdf"),  # copies
        ("lab/hall.sdf", ["new/hall.sdf", "old/hall.sdf", "other/hall.sdf"], None),
        ("nao/model.sdf", ["roboy/model.sdf"], None),  # every robot has a file of this name
        ("nao/model.sdf", ["../Experiment/model.sdf"], "Experiment/model.sdf"),  # perhaps of another robot
    ],
)
def test_a_model_elsewhere_is_used_if_there_is_no_other_and_that_is_reported(
    tmp_path: Path, text: str, files: list[str], found: str | None
) -> None:
    models = tmp_path / "Models"
    models.mkdir()
    for file in files:
        (models / file).parent.mkdir(parents=True, exist_ok=True)
        (models / file).write_text("<!-- other -->" if "other" in file else "")
    (tmp_path / "Experiment").mkdir(exist_ok=True)
    library = Library(tmp_path / "Experiment", [models])
    path = library.find_sdf(named("", text))
    assert path is None if found is None else str(path).endswith(found)
    assert library.elsewhere == ({text: path} if found else {})


def test_another_robot_of_an_archive_is_reported(library: Library) -> None:
    path = library.find_sdf(named("customAsset='true' assetPath='husky.zip'", "arm.sdf"))
    assert path is not None
    assert path.name == "newest.sdf"
    assert library.elsewhere == {"arm.sdf": path}


@pytest.mark.parametrize("has_models", [True, False])
def test_an_owner_of_no_models_is_told_how_to_name_them(tmp_path: Path, has_models: bool) -> None:
    (tmp_path / "x.exc").write_text(EXPERIMENT)
    (tmp_path / "x.bibi").write_text(BIBI)
    if has_models:
        (tmp_path / "Models").mkdir()
    with Run(read_exc(tmp_path / "x.exc")) as run:
        run.run_until(0.02)
        told = [one for one in run.result().problems if one.code is Code.NRP204]
    assert ["NRP_MODELS" in one.message for one in told] == [True] * (not has_models)


@pytest.mark.parametrize("place", ["Models", "Experiments/Models", "Experiments/course/resources/Models"])
def test_the_models_of_a_repository_are_found_without_a_setting(
    corpus: Path, tmp_path: Path, place: str
) -> None:
    folder = tmp_path / "repository" / "Experiments" / "course"
    folder.mkdir(parents=True)
    (folder / "x.exc").write_text(EXPERIMENT.replace("room", "kitchen/kitchen.sdf"))
    (folder / "x.bibi").write_text(BIBI.replace("two_cells", "brains/two_cells.py"))
    models = tmp_path / "repository" / place
    shutil.copytree(corpus / "models", models)
    (models / "house").mkdir()
    (models / "house" / "kitchen.sdf").write_text("<sdf version='1.5'><world name='w'/></sdf>")
    with Run(read_exc(folder / "x.exc")) as run:
        run.run_until(0.02)
        judgement = run.result().judgement
    assert judgement.complete
    assert run.experiment.world.robots["robot"].model == models / "husky_model" / "model.sdf"
    reported = {problem.subject for problem in judgement.problems if problem.code is Code.NRP204}
    assert reported == {"kitchen/kitchen.sdf", "brains/two_cells.py"}


_MESH = "model://husky_model/meshes/base.stl"


@pytest.mark.parametrize(
    ("uri", "files", "found"),
    [
        (_MESH, ["parts/husky_model/meshes/base.stl", "parts/other/meshes/base.stl"], "husky_model/meshes"),
        (_MESH, ["robots/rover/meshes/Base.STL"], "robots/rover/meshes"),
        (_MESH, ["a/base.stl", "b/base.stl"], "a"),  # copies
        (_MESH, ["a/base.stl", "b/base.stl", "other/base.stl"], None),
        ("package://rover/meshes/base.stl", ["a/rover/meshes/base.stl", "other/base.stl"], "rover/meshes"),
        ("file:///home/user/rover/meshes/base.stl", ["a/rover/meshes/base.stl"], "rover/meshes"),
        (_MESH, ["../outside/husky_model/meshes/base.stl"], None),
    ],
)
def test_a_mesh_elsewhere_in_the_repository_is_used_if_there_is_no_other_and_its_folder_is_reported(
    tmp_path: Path, uri: str, files: list[str], found: str | None
) -> None:
    experiment = tmp_path / "repository" / "experiments" / "course"
    for folder in (experiment, tmp_path / "repository" / ".git"):
        folder.mkdir(parents=True)
    for file in files:
        path = tmp_path / "repository" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("other" if "other" in file else "")
    library = Library(experiment)
    mesh = library.find_mesh(uri)
    assert mesh is None if found is None else str(mesh and mesh.parent).endswith(found)
    assert library.elsewhere == ({uri.rpartition("/")[0]: mesh.parent} if mesh else {})


def test_a_robot_has_the_meshes_that_are_elsewhere_in_its_repository(tmp_path: Path) -> None:
    """The mesh is a tetrahedron with edges of 1 m along the axes, whose volume is 1/6 m^3."""
    folder = tmp_path / "experiments" / "course"
    for each in (folder, tmp_path / ".git", tmp_path / "meshes"):
        each.mkdir(parents=True)
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    write_stl(tmp_path / "meshes" / "base.stl", corners[[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]])
    shape = f"<geometry><mesh><uri>{_MESH}</uri></mesh></geometry>"
    (folder / "rover.sdf").write_text(
        f"<sdf version='1.6'><model name='m'><link name='l'><collision name='c'>{shape}</collision></link>"
        "</model></sdf>"
    )
    (folder / "x.exc").write_text(
        '<ExD><environmentModel src="empty_world.sdf"/><bibiConf src="x.bibi"/></ExD>'
    )
    (folder / "x.bibi").write_text("<bibi><bodyModel>rover.sdf</bodyModel></bibi>")
    with Run(read_exc(folder / "x.exc")) as run:
        (link,) = run.world.scene.model("robot").links
        found = [one.message for one in run.problems if one.code is Code.NRP204]
        assert run.result().complete
    assert link.inertial is not None
    assert link.inertial.mass == pytest.approx(1000 / 6)
    assert "there is no 'model://husky_model/meshes': '../../meshes' is used" in found
    assert "room 'empty_world.sdf' not found: a plain floor is used" in found  # which is all of that room


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("two_cells", "brain_model/two_cells.py"),
        ("brain_model/two_cells", "brain_model/two_cells.py"),
        (r"brain_model\Two_Cells.py", "brain_model/two_cells.py"),
        ("${HBP}/Models/brain_model/two_cells.py", "brain_model/two_cells.py"),
        ("brain.zip", "cells/cells.py"),
        ("no_such_brain.py", None),
    ],
)
def test_a_brain_is_found_by_its_name(library: Library, text: str, found: str | None) -> None:
    path = library.find_brain(named("", text))
    assert path is None if found is None else str(path).endswith(found)


def test_an_experiment_runs_out_of_an_archive_and_its_records_stand_beside_it(
    library: Library, corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with zipfile.ZipFile(tmp_path / "downloaded.zip", "w") as archive:
        archive.writestr("template_husky_0/experiment_configuration.exc", EXPERIMENT)
        archive.writestr("template_husky_0/x.bibi", BIBI)
        archive.write(library.folder / "rooms" / "Hall.sdf", "template_husky_0/room/Hall.sdf")
        archive.write(library.folder / "husky.zip", "template_husky_0/husky.zip")
    monkeypatch.setenv("NRP_MODELS_DIRECTORY", str(corpus / "models"))
    with Run(load_experiment(tmp_path / "downloaded.zip")) as run:
        run.run_until(0.04)
        (rows,) = run.write_csv()
        assert "robot" in run.result().final_pose
        assert run.brain.network.size > 0
    assert rows == tmp_path / "downloaded" / "csv" / "rows.csv"
    assert rows.read_text().split() == ["t,Simulation_reset", "0.0", "0.02"]


def test_the_models_of_an_installation_are_found_by_its_variables(
    corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab = tmp_path / "lab"
    lab.mkdir()
    (lab / "x.exc").write_text(EXPERIMENT)
    (lab / "x.bibi").write_text(BIBI)
    (corpus / "models").rename(corpus / "Models")
    monkeypatch.setenv("HBP", str(corpus))
    found = read_exc(lab / "x.exc")
    assert found.brain.model == corpus / "Models" / "brain_model" / "two_cells.py"
    assert read_exc(lab / "x.exc", [f"models=[{lab}]"]).brain.model.name == "no_brain.py"
