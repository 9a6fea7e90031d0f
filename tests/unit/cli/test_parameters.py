"""Parameters in experiments: set, checked without executing a script, recorded, replayed, shown."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.checks.validate import validate_file
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError
from nrp_core.network.files.script import load_network
from nrp_core.running import run

FAKES = Path(__file__).parents[2] / "shared" / "fakes"

BRAIN = """\
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
cells = sim.parameter("cells", 4, low=4, high=100, doc="number of cells")
delay = sim.parameter("delay", 1.0, unit="ms", low=0.1)
circuit = sim.Population(cells, sim.IF_curr_exp(), label="circuit")
sim.Projection(circuit, circuit, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1, delay=delay))
"""
DRIVE = """\
import std_msgs.msg
import geometry_msgs.msg

speed = nrp.parameter("speed", 0.5, unit="m/s", low=0, high=2, doc="speed of the robot")


@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(speed, 0, 0))
"""


@pytest.fixture
def folder(fakes, tmp_path):
    """The experiment of the fakes, with parameters in its brain and its functions."""
    shutil.copytree(FAKES, tmp_path / "e")
    (tmp_path / "e" / "brain.py").write_text(BRAIN)
    (tmp_path / "e" / "drive.py").write_text(DRIVE)
    file = tmp_path / "e" / "experiment.yaml"
    text = file.read_text()
    file.write_text(text[: text.index("events:")])
    return tmp_path / "e"


def errors(found):
    return [one for one in found if one.level == "error"]


def test_a_value_of_the_file_and_of_the_command_line_reaches_the_brain(folder):
    file = folder / "experiment.yaml"
    file.write_text(file.read_text().replace("model: brain.py", "model: brain.py, parameters: {cells: 6}"))
    with Run(load_experiment(folder)) as one:
        assert one.brain.network.size == 6
        assert one.brain.network.projections[0].delay_ms[0] == 1.0
    overrides = ["brain.parameters.cells=9", "brain.parameters.delay=2500 us"]
    with Run(load_experiment(folder, overrides)) as one:
        assert one.brain.network.size == 9
        assert one.brain.network.projections[0].delay_ms[0] == 2.5


def test_a_value_reaches_the_transfer_functions(folder):
    for given, distance in (([], 0.5), (["function_parameters.speed=200 cm/s"], 2.0)):
        end = run(folder, given, until_s=1.0).final_pose["husky"]["x"]
        # the first command acts after one step; discs move exactly as they are told
        assert end == pytest.approx(distance * (1.0 - 0.02), abs=0.021 * distance)


def test_runs_in_one_process_keep_their_own_values(folder):
    with (
        Run(load_experiment(folder, ["function_parameters.speed=2", "brain.parameters.cells=7"])) as fast,
        Run(load_experiment(folder)) as slow,
    ):
        for one in (fast, slow, fast, slow):
            one.step()
        assert (fast.brain.network.size, slow.brain.network.size) == (7, 4)
        fast.run(0.4)
        slow.run(0.4)
        x = {one: one.result().final_pose["husky"]["x"] for one in (fast, slow)}
        assert x[fast] == pytest.approx(4 * x[slow])


def test_functions_that_are_changed_during_a_run_get_the_values(folder):
    with Run(load_experiment(folder, ["function_parameters.speed=2"])) as one:
        one.step()
        one.change(add=[folder / "drive.py"])
        one.run(0.4)
        assert one.result().final_pose["husky"]["x"] > 0.7


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("brain.parameters", "cels: 5", "there is no parameter 'cels'; did you mean 'cells'?"),
        ("brain.parameters", "cells: 3", "cells is 3; it must be 4..100 (declared at brain.py:4)"),
        ("brain.parameters", "cells: 4.5", "it must be a whole number"),
        ("brain.parameters", "delay: 2 mV", "'mV' cannot be converted to 'ms' (declared at brain.py:5)"),
        ("function_parameters", "sped: 1", "there is no parameter 'sped'; did you mean 'speed'?"),
        ("function_parameters", "speed: 3 m/s", "it must be 0..2 m/s (declared at drive.py:4)"),
    ],
)
def test_a_wrong_value_is_one_finding_with_its_line_before_a_script_runs(folder, key, value, message):
    mark = folder / "ran"
    for script in ("brain.py", "drive.py"):
        path = folder / script
        marking = f"    open({str(mark)!r}, 'w').close()\n"
        path.write_text(f"{path.read_text()}try:\n{marking}except PermissionError:  # in a check\n    pass\n")
    file = folder / "experiment.yaml"
    text = file.read_text()
    if key == "function_parameters":
        line = text.count("\n") + 2
        file.write_text(f"{text}function_parameters:\n  {value}\n")
    else:
        line = text[: text.index("brain:")].count("\n") + 2
        file.write_text(text.replace("model: brain.py", f"model: brain.py, parameters:\n  {{{value}}}"))
    (finding,) = errors(validate_file(folder))
    assert (finding.code.name, finding.path, finding.line) == ("NRP202", file, line)
    assert message in finding.message
    with pytest.raises(InvalidExperimentError) as caught:
        Run(load_experiment(folder))
    assert [one.message for one in errors(caught.value.findings)] == [finding.message]


def test_a_declaration_that_is_not_literal_is_one_finding_with_its_line(folder):
    file = folder / "brain.py"
    file.write_text(BRAIN.replace('"delay", 1.0', '"delay", 2 * cells'))
    (finding,) = errors(validate_file(folder, ["brain.parameters.delay=3"]))
    assert (finding.code.name, finding.path, finding.line) == ("NRP202", file, 5)


@pytest.mark.parametrize(
    ("wrong", "code"),
    [('"delay", low=5, high=0', "NRP202"), ('"delay", 9.0, low=0, high=5', "NRP202")],
)
def test_a_declaration_that_ends_the_script_is_one_finding(folder, wrong, code):
    file = folder / "brain.py"
    right = '"delay", 1.0, unit="ms", low=0.1'
    assert right in BRAIN
    file.write_text(BRAIN.replace(right, wrong))
    assert [one.code.name for one in errors(validate_file(folder))] == [code]


def test_a_brain_that_is_not_a_script_has_no_parameters(folder, golden: Golden):
    from nrp_core.network.files import save_network

    save_network(load_network(folder / "brain.py"), folder / "brain.nrpnet")
    overrides = [f"brain.model={folder / 'brain.nrpnet'}"]
    assert [one.message for one in errors(validate_file(folder, overrides))] == []
    (finding,) = errors(validate_file(folder, [*overrides, "brain.parameters.cells=5"]))
    assert "'cells'" in finding.message
    golden(finding.message)


def test_the_known_size_of_a_network_depends_on_the_values(folder):
    wanted = ["brain.populations.actors='2:6'"]
    assert errors(validate_file(folder, [*wanted, "brain.parameters.cells=6"])) == []
    (finding,) = errors(validate_file(folder, [*wanted, "brain.parameters.cells=5"]))
    assert finding.code.name == "NRP211"


def test_values_are_recorded_replayed_and_shown(nrp, folder, tmp_path):
    recording = tmp_path / "out"
    run(
        folder,
        ["brain.parameters.cells=6", "function_parameters.speed=150 cm/s"],
        until_s=0.2,
        record=recording,
    )
    shown = nrp("inspect", recording)
    assert "brain parameter cells = 6\n" in shown.out
    assert "functions parameter speed = 1.5 m/s\n" in shown.out
    told = json.loads(nrp("inspect", recording, "--json").out)["parameters"]
    assert told["brain"]["cells"]["value"] == 6
    assert (told["brain"]["delay"]["value"], told["brain"]["delay"]["unit"]) == (1.0, "ms")
    shutil.rmtree(folder)  # the recording has all that it needs
    done = nrp("replay", recording, "--verify")
    assert done.code == 0, done.err
    assert "identical" in done.out


def test_inspect_shows_the_parameters_of_an_experiment_and_of_its_files(nrp, folder):
    done = nrp("inspect", folder, "-s", "brain.parameters.delay=2 ms")
    assert done.code == 0, done.err
    assert "parameter cells = 4  (4..100; number of cells)\n" in done.out
    assert "parameter delay = 2.0 ms  (default 1.0 ms; 0.1 ms or more)\n" in done.out
    assert "parameter speed = 0.5 m/s  (0..2 m/s; speed of the robot)\n" in done.out
    assert "parameter cells = 4" in nrp("inspect", folder / "brain.py").out
    assert "parameter speed = 0.5 m/s" in nrp("inspect", folder / "drive.py").out
    data = json.loads(nrp("inspect", folder, "--json").out)
    assert data["parameters"]["brain"]["cells"] == {
        "value": 4, "default": 4, "unit": None, "low": 4, "high": 100, "doc": "number of cells",
        "file": "brain.py", "line": 4, "set_by": None,
    }  # fmt: skip
    wrong = nrp("inspect", folder, "-s", "brain.parameters.cells=3")
    assert (wrong.code, wrong.err.count("NRP202")) == (3, 1)


def test_a_parameter_is_explained_with_its_value_and_who_set_it(nrp, folder, tmp_path):
    file = folder / "experiment.yaml"
    file.write_text(file.read_text().replace("model: brain.py", "model: brain.py, parameters: {cells: 6}"))
    line = 1 + file.read_text()[: file.read_text().index("cells: 6")].count("\n")
    done = nrp("explain", folder, "cells")
    assert done.code == 0, done.err
    assert done.out.splitlines() == [
        "brain.parameters.cells: number of cells", "", "  value: 6", f"  set by: experiment.yaml:{line}",
        "  default: 4", "  valid: a whole number, 4..100", "  declared: brain.py:4, in the brain script",
    ]  # fmt: skip
    assert "set by: nothing; it is the default" in nrp("explain", folder, "brain.parameters.delay").out
    override = "function_parameters.speed=150 cm/s"
    told = nrp("explain", folder, "speed", "-s", override).out
    assert f"value: 1.5 m/s\n  set by: -s {override}\n" in told
    assert told.endswith("declared: drive.py:4, in the transfer functions\n")
    recording = tmp_path / "out"
    run(folder, [override], until_s=0.02, record=recording)
    assert nrp("explain", recording, "speed").out == told
    assert "value: 0.5 m/s" in nrp("explain", folder / "drive.py", "speed").out
    names = [one["name"] for one in json.loads(nrp("explain", folder, "--json").out)["parameters"]]
    assert names == ["cells", "delay", "speed"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("spede",), 2, "has no parameter 'spede'; did you mean 'speed'?"),
        (("brain.parameters.cels",), 2, "did you mean 'brain.parameters.cells'?"),
        (("cells", "-s", "brain.parameters.cells=3"), 3, "cells is 3; it must be 4..100"),
    ],
)
def test_a_missing_or_unsuitable_parameter_is_reported(nrp, folder, arguments, code, message):
    done = nrp("explain", folder, *arguments)
    assert done.code == code
    assert message in " ".join(done.err.split())


def test_a_code_has_no_parameters_and_a_recording_its_own_values(nrp, folder, tmp_path):
    assert nrp("explain", "NRP240", "cells").code == 2
    run(folder, until_s=0.02, record=tmp_path / "out")
    assert nrp("explain", tmp_path / "out", "cells", "-s", "brain.parameters.cells=5").code == 2


def test_inspect_and_explain_report_a_declaration_that_cannot_be_read(nrp, folder):
    file = folder / "brain.py"
    file.write_text(BRAIN.replace('"delay", 1.0', '"delay", 2 * cells'))
    for command in ("inspect", "explain"):
        assert nrp(command, file).err.count("NRP202") == 1


def test_a_script_that_runs_by_itself_has_the_defaults(tmp_path):
    script = tmp_path / "brain.py"
    script.write_text(f"{BRAIN}print(cells, delay)\n")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout == "4 1.0\n"
