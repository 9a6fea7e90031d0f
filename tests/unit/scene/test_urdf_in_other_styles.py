"""Robots in URDF and xacro as other people write them: what ROS accepts is read, and what it means holds."""

from __future__ import annotations

from math import inf
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import Mimic
from nrp_core.scene.posture import start_positions
from nrp_core.scene.sdf import read_model

MASS = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
JOINT = """<joint name="{0}" type="revolute"><parent link="base"/><child link="{0}_link"/>
<limit lower="-1" upper="1" effort="5" velocity="1"/>{1}</joint><link name="{0}_link">{2}</link>"""
SYSTEM = """<ros2_control name="hand" type="system"><hardware/>
  <joint name="left"><command_interface name="position"/>
    <state_interface name="position"><param name="initial_value">0.4</param></state_interface></joint>
  <joint name="right"><param name="mimic">left</param><param name="multiplier">-1</param>
    <state_interface name="position"/></joint>
  <joint name="third"><command_interface name="position"/>
    <state_interface name="position"><param name="initial_value">7</param></state_interface></joint>
</ros2_control>"""
CONTROL = '<gazebo><plugin name="c" filename="libgazebo_ros2_control.so"><parameters/></plugin></gazebo>'
HELD = '<joint name="neck" type="fixed"><parent link="base"/><child link="eye"/></joint>'
COUPLED = """<gazebo><plugin name="c" filename="lib{0}.so"><joint>left</joint><mimicJoint>{1}</mimicJoint>
<multiplier>-0.5</multiplier><offset>0.1</offset><sensitiveness>0.0</sensitiveness><maxEffort>1.0</maxEffort>
</plugin></gazebo>"""
XACRO = '<robot name="$(arg name)" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def robot(folder: Path, body: str, *, masses: tuple[str, str, str] = (MASS, MASS, MASS)) -> Path:
    """Write a robot with three joints on one base."""
    joints = "".join(
        JOINT.format(name, "", mass) for name, mass in zip(("left", "right", "third"), masses, strict=True)
    )
    (folder / "hand.urdf").write_text(
        f'<robot name="hand"><link name="base">{MASS}</link>{joints}{body}</robot>'
    )
    return folder / "hand.urdf"


def test_the_parameters_of_ros2_control_say_where_joints_start_and_which_one_they_follow(
    tmp_path: Path,
    golden: Golden,
) -> None:
    model = read_model(robot(tmp_path, SYSTEM + CONTROL))
    left, right, third = model.joints
    assert right.mimic == Mimic("left", -1.0)
    assert (left.mimic, third.mimic) == (None, None)
    assert start_positions(model) == {"left": 0.4, "right": -0.4, "third": 1.0}
    (warning,) = model.warnings
    assert "'third'" in str(warning)
    golden(str(warning))
    # an empty <parameters> names no file: the joints follow trajectories as without it
    assert [each.joints for each in model.trajectory_controllers] == [("left", "third")]


def test_a_joint_that_follows_none_of_the_robot_moves_freely(tmp_path: Path, golden: Golden) -> None:
    file = robot(tmp_path, "")
    file.write_text(file.read_text().replace("</joint>", '<mimic joint="lft"/></joint>', 1))
    model = read_model(file)
    assert [joint.mimic for joint in model.joints] == [None, None, None]
    (warning,) = model.warnings
    assert "'left'" in str(warning)
    golden(str(warning))


def test_a_link_that_weighs_nothing_in_urdf_hardly_weighs_anything_if_it_moves(
    tmp_path: Path, golden: Golden
) -> None:
    model = read_model(robot(tmp_path, "", masses=(MASS, "", MASS)))
    masses = {link.name: link.inertial and link.inertial.mass for link in model.links}
    assert masses == {"base": 2.0, "left_link": 2.0, "right_link": pytest.approx(6e-4), "third_link": 2.0}
    assert "'right_link'" in str(model.warnings[0])
    golden(str(model.warnings[0]))


def test_a_block_of_the_world_is_not_reported(tmp_path: Path) -> None:
    held = '<joint name="held" type="fixed"><parent link="world"/><child link="base"/></joint>'
    model = read_model(robot(tmp_path, f'<link name="world"/>{held}<gazebo reference="world"/>'))
    assert model.warnings == ()


def test_the_name_of_a_robot_may_be_an_argument_that_the_file_declares_later(
    tmp_path: Path, golden: Golden
) -> None:
    file = tmp_path / "arm.xacro"
    body = f'<xacro:arg name="name" default="arm"/><link name="base">{MASS}</link>'
    file.write_text(XACRO.format(body))
    assert read_model(file).name == "arm"
    assert read_model(file, args={"name": "other"}).name == "other"
    file.write_text(XACRO.format(body.replace(' default="arm"', "")))
    with golden.raises(SceneError, match="'name'"):
        read_model(file)


ARM_XACRO = XACRO.replace("$(arg name)", "arm")
INCLUDE = '<xacro:include filename="$(find {0})/urdf/{1}.xacro"/><link name="base">{2}</link><xacro:{1}/>{3}'


def test_a_missing_package_costs_what_it_has_and_not_the_robot(tmp_path: Path, golden: Golden) -> None:
    file = tmp_path / "arm.xacro"
    file.write_text(ARM_XACRO.format(INCLUDE.format("sensors", "lidar", MASS, "")))
    with golden.raises(SceneError, match="'sensors'"):
        read_model(file)
    model = read_model(file, lenient=True)
    assert [link.name for link in model.links] == ["base"]
    texts = [str(warning) for warning in model.warnings]
    assert "there is no package 'sensors' in the search path: its 'urdf/lidar.xacro' is left out" in texts[0]
    assert "<xacro:lidar> is left out: its macro may be in the package 'sensors'" in texts[1]


def test_a_file_of_a_missing_package_is_left_out_alone(tmp_path: Path, golden: Golden) -> None:
    """The only substitution is in a text, not in an attribute."""
    control = CONTROL.replace("<parameters/>", "<parameters>$(find gone)/config/c.yaml</parameters>")
    model = read_model(robot(tmp_path, control))
    assert len(model.joints) == 3
    (warning,) = model.warnings
    assert "'package://gone/config/c.yaml'" in str(warning)
    golden(str(warning))


def test_a_faulty_plugin_of_a_xacro_file_is_left_out_with_its_name(tmp_path: Path, golden: Golden) -> None:
    plugin = '<plugin name="p" filename="libgazebo_ros_p3d.so"><bodyName>${"b"}</bodyName></plugin>'
    model = read_model(
        robot(tmp_path, f"<gazebo>{plugin.replace('<body', '<topicName>t</topicName><body')}</gazebo>")
    )
    assert len(model.joints) == 3
    (warning,) = model.warnings
    assert "'gazebo_ros_p3d'" in str(warning)
    golden(str(warning))


def test_sources_of_a_package_have_its_files_one_folder_deeper(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``install(DIRECTORY description/urdf DESTINATION share/bot)``; the search path may be relative."""
    package = tmp_path / "ws" / "bot"
    (package / "description" / "urdf").mkdir(parents=True)
    (package / "bringup" / "config").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>bot</name></package>")
    macro = f'<xacro:macro name="eye"><link name="eye"/>{HELD}</xacro:macro>'
    (package / "description" / "urdf" / "eye.xacro").write_text(ARM_XACRO.format(macro))
    yaml = "follow: {type: x/JointTrajectoryController, joints: [left]}"
    (package / "bringup" / "config" / "c.yaml").write_text(yaml)
    control = CONTROL.replace("<parameters/>", "<parameters>$(find bot)/config/c.yaml</parameters>")
    body = INCLUDE.format("bot", "eye", MASS, JOINT.format("left", "", MASS) + control)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "arm.xacro").write_text(ARM_XACRO.format(body))
    monkeypatch.chdir(tmp_path)
    model = read_model(Path("elsewhere") / "arm.xacro", search_path=["ws"])
    assert {link.name for link in model.links} == {"base", "eye", "left_link"}
    assert [each.joints for each in model.trajectory_controllers] == [("left",)]


@pytest.mark.parametrize(("value", "told"), [("true", True), ("1", True), ("0", False), ("false", False)])
def test_parts_that_would_collide_in_gazebo_are_reported(tmp_path: Path, value: str, told: bool) -> None:
    block = f'<gazebo reference="left_link"><selfCollide>{value}</selfCollide></gazebo>'
    read = read_model(robot(tmp_path, block))
    assert [f"<self_collide> {value} of a <link> is not" in str(each) for each in read.warnings] == [
        True
    ] * told


@pytest.mark.parametrize("shape", ['<box size="0 0 0"/>', '<cylinder radius="0" length="0.0"/>'])
@pytest.mark.parametrize("tag", ["visual", "collision"])
def test_a_shape_without_a_size_marks_a_frame_and_is_left_out(tmp_path: Path, tag: str, shape: str) -> None:
    point = f"<{tag}><geometry>{shape}</geometry></{tag}>"
    model = read_model(robot(tmp_path, f'<link name="eye">{MASS}{point}</link>' + HELD))
    assert model.link("eye").visuals + model.link("eye").collisions == ()
    (warning,) = model.warnings
    assert f"the {tag} 'eye_{tag}' is a shape without a size: left out" in str(warning)


@pytest.mark.parametrize("inertia", ["", '<inertia ixx="0" iyy="0" izz="0" ixz="2.4e-35"/>'])
def test_a_link_with_a_mass_and_no_inertia_has_that_of_its_shapes(tmp_path: Path, inertia: str) -> None:
    box = '<collision><geometry><box size="0.6 0.3 0.2"/></geometry></collision>'
    eye = f'<link name="eye"><inertial><mass value="12"/>{inertia}</inertial>{box}</link>'
    model = read_model(robot(tmp_path, eye + HELD))
    inertial = model.link("eye").inertial
    assert inertial is not None
    assert inertial.mass == 12
    # of a box: a twelfth of the mass times the squares of two sides
    assert inertial.inertia == pytest.approx((0.09 + 0.04, 0.36 + 0.04, 0.36 + 0.09, 0, 0, 0))
    assert "'eye' has no inertia or one of about 0: the inertia of its collision shapes" in str(
        model.warnings[0]
    )


def test_commas_between_numbers_are_read_as_spaces(tmp_path: Path, golden: Golden) -> None:
    held = HELD.replace("<parent", '<origin xyz="1, -2, 0.5" rpy="0 0, 0"/><parent')
    model = read_model(robot(tmp_path, f'<link name="eye">{MASS}</link>{held}'))
    assert model.link("eye").pose.position == pytest.approx((1, -2, 0.5))
    assert 'xyz="1, -2, 0.5"' in str(model.warnings[0])
    golden(str(model.warnings[0]))


def test_a_comma_within_a_number_is_an_error(tmp_path: Path, golden: Golden) -> None:
    held = HELD.replace("<parent", '<origin xyz="1 0,5 0"/><parent')
    with golden.raises(SceneError, match="<origin>.*'1 0,5 0'"):
        read_model(robot(tmp_path, f'<link name="eye">{MASS}</link>{held}'))


def test_a_colour_with_five_numbers_is_its_first_four(tmp_path: Path, golden: Golden) -> None:
    box = '<geometry><box size="1 1 1"/></geometry>'
    dark = f'<visual>{box}<material name="m"><color rgba="0.1 0.2 0.3 0.5 1"/></material></visual>'
    model = read_model(robot(tmp_path, f'<link name="eye">{MASS}{dark}</link>{HELD}'))
    assert model.link("eye").visuals[0].rgba == (0.1, 0.2, 0.3, 0.5)
    (warning,) = model.warnings
    assert 'rgba="0.1 0.2 0.3 0.5 1"' in str(warning)
    golden(str(warning))


def test_a_joint_of_an_absent_link_is_refused_with_the_word_of_urdf(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(SceneError, match="'eye'"):
        read_model(robot(tmp_path, HELD))


@pytest.mark.parametrize(
    "file",
    [
        "roboticsgroup_gazebo_mimic_joint_plugin",
        "roboticsgroup_upatras_gazebo_mimic_joint_plugin",
        "gazebo_mimic_joint_plugin",
    ],
)
def test_a_plugin_of_gazebo_classic_couples_joints(tmp_path: Path, file: str) -> None:
    model = read_model(robot(tmp_path, COUPLED.format(file, "right")))
    assert [joint.mimic for joint in model.joints] == [None, Mimic("left", -0.5, 0.1), None]
    assert model.warnings == ()


def test_the_mimic_of_a_joint_is_worth_more_than_that_of_a_plugin(tmp_path: Path) -> None:
    file = robot(tmp_path, COUPLED.format("gazebo_mimic_joint_plugin", "left_link"))
    file.write_text(file.read_text().replace("</joint>", '<mimic joint="right"/></joint>', 1))
    file.write_text(file.read_text().replace("<joint>left", "<joint>third").replace("left_link<", "left<"))
    assert read_model(file).joints[0].mimic == Mimic("right")


@pytest.mark.parametrize(("follower", "said"), [("rihgt", "no joint 'rihgt'; did you mean 'right'")])
def test_a_plugin_that_couples_an_absent_joint_is_reported(tmp_path: Path, follower: str, said: str) -> None:
    model = read_model(robot(tmp_path, COUPLED.format("gazebo_mimic_joint_plugin", follower)))
    assert [joint.mimic for joint in model.joints] == [None, None, None]
    assert said in str(model.warnings[0])


def test_a_plugin_that_couples_a_joint_with_itself_is_an_error(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(SceneError, match="'left'"):
        read_model(robot(tmp_path, COUPLED.format("gazebo_mimic_joint_plugin", "left")))


def test_an_origin_may_have_a_quaternion(tmp_path: Path, golden: Golden) -> None:
    """A quarter turn about z takes x to y; the parser of ROS scales it to a length of 1."""
    held = HELD.replace("<parent", '<origin xyz="1 0 0" quat_xyzw="0 0 2 2"/><parent')
    model = read_model(robot(tmp_path, f'<link name="eye">{MASS}</link>{held}'))
    assert model.warnings == ()
    assert model.link("eye").pose.rotate((1.0, 0.0, 0.0)) == pytest.approx((0, 1, 0))
    with golden.raises(SceneError, match="quat_xyzw"):
        read_model(
            robot(tmp_path, f'<link name="eye">{MASS}</link>' + held.replace("quat", 'rpy="0 0 0" quat'))
        )


def test_limits_of_acceleration_are_not_reported(tmp_path: Path) -> None:
    file = robot(tmp_path, "")
    file.write_text(file.read_text().replace('velocity="1"', 'velocity="1" acceleration="4" jerk="9"'))
    assert read_model(file).warnings == ()


@pytest.mark.parametrize(("tag", "told"), [("sensor:camera", True), ("gz:frame_id", False)])
def test_elements_of_the_first_gazebo_are_reported(tmp_path: Path, tag: str, told: bool) -> None:
    prefix = tag.partition(":")[0]
    block = f'<gazebo reference="base" xmlns:{prefix}="http://x"><{tag} name="c"/></gazebo>'
    said = [str(each) for each in read_model(robot(tmp_path, block)).warnings]
    assert ["<sensor:camera> is of Gazebo before its version 1.0" in each for each in said] == [True] * told


@pytest.mark.parametrize(
    ("limits", "ends", "told"),
    [
        ("", (-inf, inf), True),
        ('lower="0"', (0.0, 0.0), False),  # a missing one is 0, as in ROS
        ('upper="0.5"', (0.0, 0.5), False),
    ],
)
def test_a_joint_with_limits_of_effort_and_velocity_only_has_no_ends(
    tmp_path: Path, limits: str, ends: tuple[float, float], told: bool
) -> None:
    """Wheels of robots that are made for PyBullet are such joints."""
    file = robot(tmp_path, "")
    file.write_text(file.read_text().replace('lower="-1" upper="1"', limits, 1))
    model = read_model(file)
    left = model.joints[0]
    assert left.kind == {-inf: "continuous", 0.0: "revolute"}[ends[0]] if ends != (0.0, 0.0) else "fixed"
    assert (left.lower, left.upper) == (ends if left.kind != "fixed" else (-inf, inf))
    said = "the <limit> of the joint 'left' has no lower and no upper: it moves without ends"
    assert [said in str(each) for each in model.warnings] == [True] * told


@pytest.mark.parametrize(("inertial", "joints"), [("", ["turn"]), (MASS, ["turn", "gap"])])
def test_a_joint_of_gazebo_replaces_one_that_holds_a_massless_link(
    tmp_path: Path, inertial: str, joints: list[str]
) -> None:
    ends = "<parent>turn_link</parent><child>base</child>"
    loop = f'<gazebo><joint name="gap" type="revolute">{ends}</joint></gazebo>'
    gap = JOINT.format("gap", "", inertial)
    (tmp_path / "robot.urdf").write_text(
        f'<robot name="r"><link name="base">{MASS}</link>{JOINT.format("turn", "", MASS)}{gap}{loop}</robot>'
    )
    read = read_model(tmp_path / "robot.urdf")
    assert [joint.name for joint in read.joints] == joints
    assert ("gap_link" in {link.name for link in read.links}) == bool(inertial)
    assert "gap" in {warning.subject for warning in read.warnings}


def test_calls_of_unknown_macros_in_a_file_without_macros_are_left_out(
    tmp_path: Path, golden: Golden
) -> None:
    path = tmp_path / "arm.urdf"
    robot = '<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro"><link name="base">{}</link>{}</robot>'
    path.write_text(robot.format(MASS, '<xacro:camera name="eye"/>'))
    (found,) = read_model(path).warnings
    assert (found.code, found.subject) == (Code.NRP260, "xacro:camera")
    path.write_text(robot.format(MASS, '<xacro:camera name="eye"/><xacro:property name="mass" value="1"/>'))
    with golden.raises(SceneError, match="camera"):
        read_model(path)


@pytest.mark.parametrize(
    "name", ["my%20parts/a%20box.stl", r"my parts\a box.stl", "package://my%20parts/a%20box.stl"]
)
def test_names_of_meshes_may_be_quoted_or_of_windows(tmp_path: Path, name: str) -> None:
    (tmp_path / "my parts").mkdir()
    write_stl(tmp_path / "my parts" / "a box.stl", np.eye(3)[None])
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm"><link name="base">{MASS}{shape}</link></robot>')
    assert read_model(tmp_path / "arm.urdf").warnings == ()


def test_meshes_of_types_that_are_not_read_are_one_finding(tmp_path: Path) -> None:
    shape = "<visual><geometry><mesh filename='{}.ply'/></geometry></visual>"
    for name in "ab":
        (tmp_path / f"{name}.ply").write_text("ply")
    (tmp_path / "hand.urdf").write_text(
        f'<robot name="hand"><link name="base">{MASS}{shape.format("a")}{shape.format("b")}</link></robot>'
    )
    (found,) = read_model(tmp_path / "hand.urdf").warnings
    assert "b.ply" in found.message
