"""Experiments of the platform become experiments of ours that behave the same, or say what does not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from nrp_legacy.code import Source
from nrp_legacy.convert.folder import Report, write_folder
from nrp_legacy.convert.python import piece_of
from nrp_legacy.reader import read_exc

from nrp_core.cli import app
from nrp_core.experiment.reader import read_yaml
from nrp_core.experiment.run import Run

FAITHFUL = ["husky_2017/experiment_configuration.exc", "husky_2015/ExDConf.exc", "bare/bare.exc",
            "icub_2017/icub.exc"]  # fmt: skip

pytestmark = pytest.mark.filterwarnings(
    "ignore::DeprecationWarning"
)  # scripts of those years call initialize()


def imported(corpus: Path, name: str, folder: Path) -> Report:
    return write_folder(read_exc(corpus / name, [f"models=[{corpus / 'models'}]"]), folder)


@pytest.mark.parametrize("name", FAITHFUL)
def test_an_imported_experiment_behaves_as_the_original(corpus: Path, tmp_path: Path, name: str) -> None:
    report = imported(corpus, name, tmp_path / "new")
    assert report.left_out == []
    results = []
    for experiment in (
        read_exc(corpus / name, [f"models=[{corpus / 'models'}]"]),
        read_yaml(tmp_path / "new" / "experiment.yaml"),
    ):
        with Run(experiment) as run:
            run.run()
            results.append((run.result(), [function.name for function in run.loop.functions]))
    (old, old_names), (new, new_names) = results
    assert old_names == new_names
    assert (old.trajectory_digest, old.spikes) == (new.trajectory_digest, new.spikes)


def test_everything_that_it_needs_is_in_its_folder(corpus: Path, tmp_path: Path) -> None:
    imported(corpus, FAITHFUL[0], tmp_path / "new")
    written = read_yaml(tmp_path / "new" / "experiment.yaml")
    files = (written.brain.model, written.world.scene, *written.transfer_functions, *written.models)
    assert all((tmp_path / "new") in path.parents for path in files)
    assert written.brain.model.name == "brain.py"
    assert written.brain.populations == {"left": "0:1", "right": "1:2", "record": "0:2"}
    (event,) = written.events.values()
    assert event.at == 10**9
    assert "leftovers of Python 2" in (tmp_path / "new" / "import.md").read_text()


def test_what_has_no_counterpart_is_left_out_and_named(corpus: Path, tmp_path: Path) -> None:
    report = imported(corpus, "husky_2019/cart.exc", tmp_path / "new")
    assert report.left_out == ["drive (drive.py): it uses rospy"]
    assert report.changed == ["currents: poisson has no setting 'label': left out"]
    assert any("no robot 'nowhere/model.sdf'" in note for note in report.noted)
    names = {path.stem for path in read_yaml(tmp_path / "new" / "experiment.yaml").transfer_functions}
    assert names == {"currents", "all_neurons_spike_monitor", "switched_off", "count_spikes"}


def test_transfer_functions_that_share_names_share_a_file(corpus: Path, tmp_path: Path) -> None:
    report = imported(corpus, "p3dx_2018/p3dx.exc", tmp_path / "new")
    assert "one file of all transfer functions, which share N_SECTORS" in report.changed
    assert "a network: left out" in "\n".join(report.changed)


def test_code_keeps_all_but_its_imports_and_spellings() -> None:
    code = """# a comment
import hbp_nrp_cle.tf_framework as nrp
from hbp_nrp_cle.robotsim.RobotInterface import Topic
import hbp_nrp_cle.tf_framework.tf_lib
@nrp.MapSpikeSource("noise", nrp.brain.s, nrp.nc_source, std=0.1, source=None)
@nrp.MapRobotSubscriber("camera", Topic('camera/', sensor_msgs.msg.Image), queue_size=2)
@Robot2Neuron()
def see(t, noise, camera):  # another
    noise.mean = np.mean([hbp_nrp_cle.tf_framework.tf_lib.detect_red(camera.value).left])
"""
    piece = piece_of(Source(code, Path("see.py")))
    assert (
        piece.text
        == """import numpy as np
Robot2Neuron = nrp.Robot2Neuron


# a comment



@nrp.MapSpikeSource("noise", nrp.brain.s, nrp.nc_source, stdev=0.1)
@nrp.MapRobotSubscriber("camera", Topic('/camera', sensor_msgs.msg.Image))
@Robot2Neuron()
def see(t, noise, camera):  # another
    noise.mean = np.mean([nrp.tf_lib.detect_red(camera.value).left])
"""
    )
    assert (piece.obstacle, piece.lacks) == ("", frozenset())


def test_the_command_writes_a_folder_and_tells_what_changed(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    arguments = ["import", str(corpus / "bare"), "-o", str(tmp_path / "new"), "--json"]
    assert app.run_app(arguments) == 0
    out = capsys.readouterr().out
    told = json.loads(out[out.index("{") :])
    assert told["file"] == str(tmp_path / "new" / "experiment.yaml")
    assert told["left_out"] == []
    assert app.run_app(arguments) != 0
    assert "is not empty" in capsys.readouterr().out
