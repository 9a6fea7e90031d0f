"""Robots to which an experiment adds how they stand and how their joints are commanded."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

import pytest
from golden import Golden
from pydantic import ValidationError
from ruamel.yaml import YAML

from nrp_core.cli import app
from nrp_core.errors import SceneError
from nrp_core.experiment.making.maker import Maker
from nrp_core.experiment.model.experiment import RobotSection
from nrp_core.experiment.model.section import Place
from nrp_core.scene.devices import Pid
from nrp_core.scene.model import Model
from nrp_core.scene.sdf import read_model
from nrp_core.world.robot_setup import section_for

LINK = '<link name="{}"><inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
ENDS = '<parent link="{}"/><child link="{}"/><limit lower="{}" upper="{}" effort="9" velocity="2"/>'
ARM = f"""<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro">
<xacro:arg name="tool" default="1.0"/>
{LINK.format("base", 1)}{LINK.format("upper", 1)}{LINK.format("fore", 1)}{LINK.format("tool", "$(arg tool)")}
<joint name="shoulder" type="revolute">{ENDS.format("base", "upper", -2, 2)}</joint>
<joint name="elbow" type="revolute">{ENDS.format("upper", "fore", 0.5, 2)}</joint>
<joint name="slide" type="prismatic">{ENDS.format("fore", "tool", 0, 0.2)}</joint>
</robot>"""


@pytest.fixture
def arm(tmp_path: Path):
    """Make the robot of an experiment from the keys of its section."""
    path = tmp_path / "arm.xacro"
    path.write_text(ARM)

    def make(**keys: object) -> Model:
        section = RobotSection.model_validate({"model": path, **keys})
        world = SimpleNamespace(robots={"arm": section})
        experiment = SimpleNamespace(world=world, models=(), strict=True, place=lambda *_: Place(path))
        return Maker().robot(experiment, "arm")

    return make


def test_every_joint_can_be_given_commands_by_patterns(arm):
    model = arm(
        control={
            "s.*": {"mode": "position", "p": 5, "d": 0.5},
            "elbow": {"mode": "velocity"},
            "elbow|slide": {"mode": "effort"},
            ".*": {"mode": "trajectory"},
        }
    )
    told = {(each.joint, each.kind): (each.topic, each.gains) for each in model.controllers}
    assert told == {
        ("shoulder", "position"): ("/arm/shoulder/cmd_pos", Pid(5, 0, 0.5)),
        ("slide", "position"): ("/arm/slide/cmd_pos", Pid(5, 0, 0.5)),
        ("elbow", "velocity"): ("/arm/elbow/cmd_vel", None),
        ("elbow", "effort"): ("/arm/elbow/cmd_effort", Pid()),
        ("slide", "effort"): ("/arm/slide/cmd_effort", Pid()),
    }
    (leader,) = model.trajectory_controllers
    assert leader.joints == ("shoulder", "elbow", "slide")
    assert leader.command_topic == "/arm/joint_trajectory_controller/command"
    assert leader.gains == ()


def test_joints_of_a_group_take_one_message(arm):
    model = arm(
        control={
            "slide": {"mode": "position", "group": "both"},
            "shoulder": {"mode": "position", "p": 5, "group": "both"},
            "elbow|slide": {"mode": "effort", "group": "strong"},
            "elbow": {"mode": "velocity"},
        }
    )
    assert [(each.joint, each.topic) for each in model.controllers] == [("elbow", "/arm/elbow/cmd_vel")]
    both, strong = model.group_controllers
    assert (both.name, both.joints, both.kind, both.topic) == (
        "both", ("shoulder", "slide"), "position", "/arm/both/commands",
    )  # fmt: skip
    assert both.gains == (("shoulder", Pid(5)),)
    assert (strong.joints, strong.kind, strong.gains) == (
        ("elbow", "slide"), "effort", (("elbow", Pid()), ("slide", Pid())),
    )  # fmt: skip


def test_the_root_of_a_robot_is_held_wherever_its_file_has_it(arm, tmp_path):
    base, rest = ARM.split(LINK.format("upper", 1))[0].splitlines()[-1], LINK.format("upper", 1)
    (tmp_path / "arm.xacro").write_text(ARM.replace(base + rest, rest + base))
    assert {joint.parent: joint.child for joint in arm(fixed=True).joints}["world"] == "base"


def test_a_robot_stands_as_the_experiment_says(arm):
    model = arm(fixed=True, joints={"elbow": "90 deg", "slide": "5 cm"}, args={"tool": 2.5})
    assert {joint.parent: joint.child for joint in model.joints}["world"] == "base"
    assert dict(model.starts) == pytest.approx({"elbow": 1.5707963, "slide": 0.05})
    assert {link.name: link.inertial.mass for link in model.links}["tool"] == 2.5
    assert arm() == arm(joints={}, control={})


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"joints": {"elbw": 1}}, "has no joint 'elbw' that takes commands; did you mean 'elbow'"),
        ({"joints": {"elbow": 0.2}}, "'elbow' of 'arm' cannot start at 0.2: its limits are 0.5 to 2"),
        ({"control": {"elbw": {}}}, "no joint of 'arm' that can be commanded matches 'elbw'; did you mean"),
        ({"control": {"(": {}}}, "is not a regular expression for joints"),
        ({"control": {"elbow": {}, "e.*": {}}}, "two patterns give the joint 'elbow' of 'arm' a position"),
        (
            {"control": {"elbow": {"group": "g"}, "slide": {"mode": "velocity", "group": "g"}}},
            "the group 'g' of 'arm' mixes position and velocity",
        ),
        ({"args": {"tol": 1}}, "this file has no argument 'tol'; did you mean 'tool'"),
    ],
)
def test_a_part_that_does_not_fit_the_robot_is_refused(arm, keys, message):
    with pytest.raises(SceneError, match=message.replace("(", r"\(")):
        arm(**keys)


@pytest.mark.parametrize(
    "control",
    [
        {"d": 1},
        {"mode": "effort", "p": 1},
        {"mode": "trajectory", "group": "g"},
        {"group": "a b"},
        {"mode": "positon"},
    ],
)
def test_control_that_makes_no_sense_is_refused(arm, control, golden: Golden):
    with golden.raises(ValidationError):
        arm(control={".*": control})


def test_a_file_without_arguments_gets_none(arm, tmp_path, golden: Golden):
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{LINK.format("base", 1)}</robot>')
    with golden.raises(SceneError):
        arm(model=tmp_path / "arm.urdf", args={"tool": 1})


def test_the_section_that_inspect_prints_gives_every_joint_commands(arm, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    assert app.run_app(["inspect", str(tmp_path / "arm.xacro")]) == 0
    head, section = capsys.readouterr().out.split("in the section 'world' of an experiment:\n")
    assert "3 joints take no commands" in head
    ((name, keys),) = YAML(typ="safe").load(section)["robots"].items()
    assert name == "arm"
    assert {each.joint for each in arm(**keys).controllers} == {"shoulder", "elbow", "slide"}


def test_joints_of_a_robot_with_muscles_are_offered_efforts():
    """A servo would hold them against the muscles."""
    legs = read_model(Path(str(files("nrp_experiments"))) / "bodies/legs.sdf")
    ((_, keys),) = YAML(typ="safe").load("\n".join(section_for(legs, "legs.sdf")))["robots"].items()
    assert keys["control"]
    assert {each["mode"] for each in keys["control"].values()} == {"effort"}
