"""Experiments of the platform become experiments of ours that behave the same, or say what does not."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_legacy.code import Source
from nrp_legacy.convert.folder import Report, write_folder
from nrp_legacy.convert.python import piece_of
from nrp_legacy.reader import read_exc

from nrp_core.cli import app
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.reader import read_yaml
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError
from nrp_core.world.topics import Stamped

CORPUS = Path(__file__).with_name("corpus")
EVERY = [str(path.relative_to(CORPUS)) for path in sorted(CORPUS.rglob("*.exc"))]
SCREENS = "husky_2017/experiment_configuration.exc"

pytestmark = pytest.mark.filterwarnings(
    "ignore::DeprecationWarning"
)  # scripts of those years call initialize()


def imported(corpus: Path, name: str, folder: Path) -> Report:
    return write_folder(original(corpus, name), folder)


def original(corpus: Path, name: str) -> Experiment:
    return read_exc(corpus / name, [f"models=[{corpus / 'models'}]"])


def played(experiment: Experiment) -> dict[str, Any]:
    """Run an experiment; return all that happened in it."""
    said: list[str] = []

    def hear(topic: str, stamped: Stamped) -> None:
        if not topic.startswith("/gazebo/set_"):  # what asks for a colour, as an event or as a service
            said.append(re.sub(" at 0x[0-9a-f]+", "", f"{topic} {stamped.t_ns} {stamped.message!r}"))

    with Run(experiment) as run:
        run.world.add_observer(hear)
        run.run()
        result = run.result()
        return {
            "functions": [function.name for function in run.loop.functions],
            "failures": [(failure["function"], failure["t_s"]) for failure in result.failures],
            "trajectory": result.trajectory_digest, "spikes": result.spikes, "said": said,
        }  # fmt: skip


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", EVERY)
def test_an_imported_experiment_behaves_as_the_original(corpus: Path, tmp_path: Path, name: str) -> None:
    assert imported(corpus, name, tmp_path / "new").left_out == []
    assert played(read_yaml(tmp_path / "new" / "experiment.yaml")) == played(original(corpus, name))


def test_everything_that_it_needs_is_in_its_folder(corpus: Path, tmp_path: Path) -> None:
    imported(corpus, SCREENS, tmp_path / "new")
    written = read_yaml(tmp_path / "new" / "experiment.yaml")
    files = (written.brain.model, written.world.scene, *written.transfer_functions, *written.models)
    assert all((tmp_path / "new") in path.parents for path in files)
    assert written.brain.model.name == "brain.py"
    assert written.brain.populations == {"left": "0:1", "right": "1:2", "record": "0:2"}
    (event,) = written.events.values()
    assert event.at == 10**9
    assert "leftovers of Python 2" in (tmp_path / "new" / "import.md").read_text()


def test_code_that_needs_the_platform_is_kept_and_named(corpus: Path, tmp_path: Path) -> None:
    report = imported(corpus, "husky_2019/cart.exc", tmp_path / "new")
    assert report.kept == ["drive: imports rospy (drive.py:1)"]
    assert report.changed == ["currents: poisson does not have the setting 'label': left out"]
    assert any("robot 'nowhere/model.sdf' not found" in note for note in report.noted)
    written = read_yaml(tmp_path / "new" / "experiment.yaml")
    assert written.compatibility is not None
    assert written.compatibility.platform == "hbp_nrp"
    folder = tmp_path / "new" / "transfer_functions"
    assert "import rospy" in (folder / "drive.py").read_text()
    assert "hbp_nrp_cle" not in (folder / "currents.py").read_text()
    assert "drive: imports rospy (drive.py:1)" in (tmp_path / "new" / "import.md").read_text()


def test_an_experiment_that_needs_nothing_of_the_platform_does_not_name_it(
    corpus: Path, tmp_path: Path
) -> None:
    assert imported(corpus, SCREENS, tmp_path / "new").kept == []
    assert read_yaml(tmp_path / "new" / "experiment.yaml").compatibility is None


def test_units_machines_and_brains_of_the_platform_stay(corpus: Path, tmp_path: Path) -> None:
    imported(corpus, "directnest_2019/husky.exc", tmp_path / "nest")
    assert "import nest" in (tmp_path / "nest" / "brain.py").read_text()
    assert "nest_units: true" in (tmp_path / "nest" / "experiment.yaml").read_text()
    imported(corpus, "screens_2016/ExDBraitenbergHuskyScreens.exc", tmp_path / "screens")
    written = read_yaml(tmp_path / "screens" / "experiment.yaml")
    assert len(written.compatibility.options["state_machines"]) == 3  # type: ignore[union-attr]
    assert not written.maker.can_be_saved


def test_a_function_that_only_the_platform_can_load_is_kept(corpus: Path, tmp_path: Path) -> None:
    (corpus / "bare" / "muscles.py").write_text(
        "from gazebo_ros_muscle_interface.msg import MuscleStates\n"
        "from units import LENGTH\n"
        "@nrp.MapRobotSubscriber('muscles', Topic('/muscles', MuscleStates))\n"
        "@nrp.Neuron2Robot()\n"
        "def stretch(t, muscles):\n"
        "    assert LENGTH == 1\n"
    )
    (corpus / "bare" / "units.py").write_text("LENGTH = 1\n")
    bibi = corpus / "bare" / "bare.bibi"
    added = '<transferFunction xsi:type="PythonTransferFunction" src="muscles.py"/></bibi>'
    space = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
    text = bibi.read_text().replace("</bibi>", added)
    bibi.write_text(text if "xmlns:xsi" in text else text.replace("<bibi ", f"<bibi {space} "))
    report = imported(corpus, "bare/bare.exc", tmp_path / "new")
    (kept,) = report.kept
    assert kept.startswith("stretch: ")
    assert "MuscleStates" in kept or "gazebo_ros_muscle_interface" in kept
    now = played(read_yaml(tmp_path / "new" / "experiment.yaml"))
    assert ("stretch" in now["functions"], now["failures"]) == (True, [])


def test_modules_and_data_beside_brain_and_functions_come_along(corpus: Path, tmp_path: Path) -> None:
    brains = corpus / "models" / "brain_model"
    (brains / "params.py").write_text("from more import SIZE\n")
    (brains / "more.py").write_text("import os\nSIZE = 3\n")
    (brains / "weight.txt").write_text("0.01")
    (brains / "small.py").write_text(
        "import os, params, numpy as np\n"
        "import pyNN.nest as sim\n"
        "print 'weight', np.loadtxt(os.path.join(os.path.dirname(__file__), 'weight.txt'))\n"
        "circuit = sim.Population(params.SIZE, sim.IF_cond_alpha())\n"
    )
    (corpus / "bare" / "data").mkdir()
    (corpus / "bare" / "data" / "gain.txt").write_text("2.0")
    (corpus / "bare" / "bare.bibi").write_text(
        "<bibi><brainModel><file>brain_model/small.py</file></brainModel>"
        '<transferFunction type="PythonTransferFunction">'
        "\nimport os\nfrom os.path import dirname\n"
        "GAIN = float(np.loadtxt(os.path.join(dirname(__file__), 'data/gain.txt')))\n"
        "@nrp.MapSpikeSource('eye', nrp.brain.circuit, nrp.poisson, weight=0.1)\n"
        "@nrp.Robot2Neuron()\ndef see(t, eye):\n    eye.rate = 200.0 * GAIN\n"
        "</transferFunction></bibi>"
    )
    report = imported(corpus, "bare/bare.exc", tmp_path / "new")
    assert (report.kept, report.left_out) == ([], [])
    before = played(original(corpus, "bare/bare.exc"))
    assert before["spikes"]["circuit"] > 0
    for path in (brains / "small.py", corpus / "bare" / "data" / "gain.txt"):
        path.unlink()
    assert played(read_yaml(tmp_path / "new" / "experiment.yaml")) == before


def test_a_platform_that_is_not_known_and_a_wrong_option_are_named(
    corpus: Path, tmp_path: Path, golden: Golden
) -> None:
    imported(corpus, "husky_2019/cart.exc", tmp_path / "new")
    file = tmp_path / "new" / "experiment.yaml"
    with golden.raises(InvalidExperimentError, match="'hbp_nrq'.*'hbp_nrp'"):
        read_yaml(file, ["compatibility.platform=hbp_nrq"])
    with golden.raises(InvalidExperimentError, match=r"'compatibility\.options'.*'nest_unit'"):
        read_yaml(file, ["compatibility.options.nest_unit=true"])


def test_transfer_functions_that_share_names_share_a_file(corpus: Path, tmp_path: Path) -> None:
    brain = corpus / "models" / "brains" / "laser_brain.py"
    brain.write_text("\n".join(line for line in brain.read_text().splitlines() if "inject" not in line))
    report = imported(corpus, "p3dx_2018/p3dx.exc", tmp_path / "new")
    assert "all transfer functions are in one file, because they share N_SECTORS" in report.changed
    assert report.kept == []


def test_methods_of_python_2_are_renamed() -> None:
    piece = piece_of(Source("for key, value in {}.iteritems():\n    print key\n", Path("see.py")))
    assert piece.text == "for key, value in {}.items():\n    print(key)\n"


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


def test_the_command_writes_a_folder_and_reports_the_changes(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    arguments = ["import", str(corpus / "bare"), "-o", str(tmp_path / "new"), "--trust", "--json"]
    assert app.run_app(arguments) == 0
    out = capsys.readouterr().out
    told = json.loads(out[out.index("{") :])
    assert told["file"] == str(tmp_path / "new" / "experiment.yaml")
    assert told["left_out"] == []
    assert app.run_app(arguments) != 0
    assert "it exists already" in capsys.readouterr().out


OF_THE_PLATFORM = [
    ("import random", "random.random()", "random.random"),
    ("", "np.random.rand()", "numpy.random.rand"),
    ("", "np.float(1)", "numpy.float"),
    ("import cPickle", "cPickle.dumps(1)", "cPickle"),
    ("from scipy import misc", "misc.imresize", "scipy.misc.imresize"),
    ("import time", "time.sleep(1)", "time.sleep"),
    ("", "open('/home/nobody/x.txt')", "open() with files outside the experiment"),
    ("", "[1, 2][3/2]", "a quotient as a whole number"),
    ("n = 7/2", "range(n)", "a quotient as a whole number"),
    ("", "laser.value.ranges.index(0)", "laser.value.ranges.index, of a tuple"),
    ("", "map(int, x) + [1]", "map() as a list"),
]
OF_OURS = [
    ("import os, time", "os.path.join('a', 'b'), time.time()"),
    ("", "np.zeros(3) / 2, [1, 2][int(3 / 2)]"),
    ("", "cv2.resize(x, (3, 3)), np.pi"),
    ("", "states.value.name.index('robot')"),
    ("import os", "open(os.path.join(os.path.dirname(__file__), 'x.txt'))"),
    ("", "[i for i in range(3)], sum(map(int, x)), list(x.items())"),
]


@pytest.mark.parametrize(("before", "use", "reason"), OF_THE_PLATFORM)
def test_code_that_would_mean_something_else_in_our_format_is_kept(
    before: str, use: str, reason: str
) -> None:
    piece = piece_of(Source(f"{before}\nx = {use}\n", Path("f.py")))
    assert piece.obstacle == f"relies on {reason} (f.py:{1 if reason == 'cPickle' else 2})"


@pytest.mark.parametrize(("before", "use"), OF_OURS)
def test_code_that_means_the_same_in_our_format_is_not_kept(before: str, use: str) -> None:
    assert piece_of(Source(f"{before}\nx = {use}\n", Path("f.py"))).obstacle == ""


def test_a_name_that_only_another_file_sets_is_shared() -> None:
    piece = piece_of(Source("def f(t):\n    global count\n    count += 1\n", Path("f.py")))
    assert piece.lacks == {"count"}
