"""`nrp inspect` on robots and rooms."""

import json
import zipfile
from importlib.resources import files
from pathlib import Path

import cv2
import pytest
from golden import Golden

from nrp_core.cli.options import overrides_of

HUSKY = Path(str(files("nrp_experiments.braitenberg_husky"))) / "husky.sdf"


def test_inspect_prints_the_tree(nrp):
    done = nrp("inspect", HUSKY)
    assert done.code == 0
    assert "joint front_left_joint, continuous about 0 1 0" in done.out
    assert "◀ /husky/cmd_vel" in done.out
    assert done.err == ""


def test_an_experiment_is_shown_by_its_name(nrp):
    assert "husky (husky.sdf)" in nrp("inspect", "braitenberg_husky").out


def test_warnings_go_to_standard_error(nrp, tmp_path):
    robot = tmp_path / "robot.urdf"
    robot.write_text('<robot name="r"><link name="base"/><wheels/></robot>')
    done = nrp("inspect", robot, "-v")
    assert done.code == 0
    assert "robot.urdf:1: the <wheels>" in done.err
    assert "wheels" not in done.out


@pytest.mark.parametrize(
    ("name", "flow", "told"),
    [
        ("listing1.py", "Neuron2Robot", "returns to /husky/cmd_vel (geometry_msgs/msg/Twist)"),
        ("listing2.bibi", "Robot2Neuron", "red_left_eye: poisson on brain.sensors[0, 2]"),
    ],
)
def test_transfer_functions_are_listed_with_their_inputs_and_outputs(nrp, name, flow, told):
    done = nrp("inspect", HUSKY.parent / name)
    assert done.code == 0
    assert done.out.startswith(f"{flow} ")
    assert f"  {told}\n" in done.out
    (function,) = json.loads(nrp("inspect", HUSKY.parent / name, "--json").out)["functions"]
    assert function["flow"] == flow
    assert done.out.split()[1].rstrip(",") == function["name"]


def test_nothing_of_a_file_of_transfer_functions_is_run(nrp, tmp_path):
    file = tmp_path / "harm.py"
    file.write_text("import os\nos.remove(__file__)\n")
    done = nrp("inspect", file)
    assert (done.code, done.err) == (3, f"error: {file}: declares no transfer function and no parameter\n")
    assert file.is_file()


def test_a_parameter_without_a_mapping_is_listed_as_not_mapped(nrp, tmp_path):
    file = tmp_path / "wrong.py"
    file.write_text('@nrp.Neuron2Robot(Topic("/x", geometry_msgs.msg.Twist))\ndef f(t, what):\n    pass\n')
    done = nrp("inspect", file)
    assert "Neuron2Robot f, " in done.out
    assert "what: not mapped" in done.out


def test_inspect_json_has_the_same_contents(nrp):
    done = nrp("inspect", HUSKY, "--json")
    data = json.loads(done.out)
    (husky,) = data["models"]
    assert data["warnings"] == []
    assert husky["links"][0]["inertial"]["mass"] == 33.855
    assert husky["joints"][0]["lower"] is None
    listens = [each["topic"] for each in husky["topics"] if each["direction"] == "listens"]
    assert listens == ["/husky/cmd_vel"]


def test_it_draws_an_image(nrp, tmp_path):
    assert nrp("inspect", HUSKY, "--image", tmp_path / "husky.png").code == 0
    image = cv2.imread(str(tmp_path / "husky.png"))
    assert image.shape == (720, 960, 3)
    yellow = (image[:, :, 2] > 150) & (image[:, :, 0] < 60)
    assert yellow.mean() > 0.05


def test_a_room_without_one_of_its_models_is_reported(nrp, tmp_path):
    room = tmp_path / "room.world"
    models = "".join(f"<include><uri>model://{name}</uri></include>" for name in ("gone", "ground_plane"))
    room.write_text(f"<sdf version='1.6'><world name='w'>{models}</world></sdf>")
    done = nrp("inspect", room)
    assert done.code == 0
    assert "ground_plane" in done.out
    assert f"{room}:1: there is no 'model://gone': left out [NRP260]\n" in done.err


def test_an_archive_is_looked_into(nrp, tmp_path):
    with zipfile.ZipFile(tmp_path / "husky.zip", "w") as archive:
        archive.write(HUSKY, "husky/model.sdf")
    assert nrp("inspect", tmp_path / "husky.zip").out.startswith("husky.zip: 1 model that moves")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("notes.txt", "hello", "not an experiment, an SDF or URDF file"),
        (
            "robot.sdf",
            "<sdf version='1.9'><model name='m'></sdf>",
            "robot.sdf:1: this is not well-formed XML",
        ),
        ("robot.urdf", "<robot name='r'/>", "robot.urdf:1: the model 'r' has no <link>"),
    ],
)
def test_an_unreadable_file_is_one_error(nrp, tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    done = nrp("inspect", tmp_path / name)
    assert done.code == 3
    assert message in done.err
    assert done.err.count("\n") == 1


def test_an_image_of_another_kind_is_refused_before_anything_is_read(nrp, tmp_path, golden: Golden):
    done = nrp("inspect", HUSKY, "--image", tmp_path / "husky.gif")
    assert done.code == 2
    golden(done.err)


@pytest.mark.parametrize("file", ["listing1.py", "experiment.yaml"])
def test_an_image_of_a_file_that_is_not_drawn_is_refused(nrp, tmp_path, file, golden: Golden):
    done = nrp("inspect", HUSKY.parent / file, "--image", tmp_path / "husky.png")
    assert done.code == 2
    golden(done.err)


def test_a_setting_that_another_option_sets_is_noted(capsys):
    given = ["seed=4", "brain.backend=event", "duration=1 s"]
    found = overrides_of(given, brain="event", world=None, seed=3)
    assert found == [*given, "brain.backend=event", "seed=3"]
    noted = capsys.readouterr().err
    assert "'-s seed=4' has no effect: another option sets seed=3" in noted
    assert noted.count("has no effect") == 1


def test_a_setting_that_is_given_twice_is_noted(capsys):
    overrides_of(["seed=3", "pace=max", "seed=4", "pace=max"], brain=None, world=None)
    (noted,) = capsys.readouterr().err.splitlines()
    assert noted.endswith("'-s seed=3' has no effect: a later -s sets seed=4")


def test_a_robot_with_an_element_that_a_run_would_leave_out_is_described_without_it(nrp, tmp_path):
    robot = tmp_path / "robot.sdf"
    joint = '<joint name="{}" type="prismatic"><parent>a</parent><child>b</child></joint>'
    links = '<link name="a"/><link name="b"/>' + "\n".join(map(joint.format, ("first", "second")))
    robot.write_text(f'<sdf version="1.6"><model name="m">\n{links}\n</model></sdf>')
    done = nrp("inspect", robot)
    assert done.code == 0
    assert "joint first, prismatic" in done.out
    assert "joint second" not in done.out
    assert "robot.sdf:3: the joint 'second'" in done.err


def test_a_xacro_file_is_given_its_arguments(nrp, tmp_path, golden: Golden):
    robot = tmp_path / "arm.xacro"
    named = '<xacro:arg name="name" default="arm"/><link name="base"/>'
    robot.write_text(f'<robot name="$(arg name)" xmlns:xacro="http://ros.org/wiki/xacro">{named}</robot>')
    shown = nrp("inspect", robot, "--json", "-s", "args.name=left")
    assert [model["name"] for model in json.loads(shown.out)["models"]] == ["left"]
    refused = nrp("inspect", robot, "-s", "seed=1")
    assert refused.code == 2
    golden(refused.err)


FUNCTION = "@nrp.Neuron2Robot()\ndef drive(t):\n    pass\n"


def test_settings_of_an_experiment_are_refused_for_a_file_of_functions(nrp, tmp_path, golden: Golden):
    functions = tmp_path / "functions.py"
    functions.write_text("import hbp_nrp_client.tf_framework as nrp\n" + FUNCTION)
    assert nrp("inspect", functions).code == 0
    for option in (["-s", "seed=1"], ["--models", tmp_path]):
        refused = nrp("inspect", functions, *option)
        assert refused.code == 2
        golden(refused.err)


def test_an_experiment_is_listed_with_its_events_and_criteria(nrp):
    assert "events: left_red, right_red, all_blue" in nrp("inspect", "braitenberg_husky").out
    data = json.loads(nrp("inspect", "following_head", "--json").out)
    assert (data["events"], data["criteria"]) == ([], ["keeps_the_ball_in_the_middle"])
