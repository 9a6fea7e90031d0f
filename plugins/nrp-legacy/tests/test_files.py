"""Files are found by the names that experiments of all times and machines give them."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from nrp_legacy.documents import FileNamed
from nrp_legacy.files import Library
from nrp_legacy.reader import read_exc

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
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
    with zipfile.ZipFile(folder / "brain.zip", "w") as archive:
        archive.writestr("cells/cells.py", "")
        archive.writestr("cells/__init__.py", "")
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
    assert rows.read_text().split() == ["t", "0.0", "0.02"]


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
