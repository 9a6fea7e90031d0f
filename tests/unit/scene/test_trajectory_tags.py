"""Trajectory controllers as the files of Gazebo and ROS have them."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.devices import JointController, Pid, TrajectoryController
from nrp_core.scene.model import Model
from nrp_core.scene.sdf import read_model
from nrp_core.world.drives.wheels import WheelDrive

ARM = """<link name="base"/><link name="upper"/><link name="hand"/><link name="thumb"/>
<joint name="turn" type="revolute"><parent>base</parent><child>upper</child>{axis}</joint>
<joint name="lift" type="prismatic"><parent>upper</parent><child>hand</child>{axis}</joint>
<joint name="hold" type="fixed"><parent>hand</parent><child>thumb</child></joint>""".format(
    axis="<axis><xyz>0 0 1</xyz></axis>"
)


@pytest.fixture
def arm(model: Callable[..., Model]) -> Callable[[str], Model]:
    """Read an arm with plugins, which stand in line 8 of the file."""
    return lambda plugins: model(f"{ARM}\n{plugins}")


def only(model: Model) -> TrajectoryController:
    (found,) = model.trajectory_controllers
    return found


@pytest.mark.parametrize(
    "named",
    [
        'name="gz::sim::systems::JointTrajectoryController" filename="x"',
        'name="follow" filename="gz-sim7-joint-trajectory-controller-system"',
        'name="follow" filename="libignition-gazebo-joint-trajectory-controller-system.so"',
    ],
)
def test_that_of_gz_sim_leads_all_joints_that_move_unless_it_names_some(
    arm: Callable[[str], Model], named: str
) -> None:
    every = only(arm(f"<plugin {named}/>"))
    assert (every.command_topic, every.joints) == ("/model/robot/joint_trajectory", ("turn", "lift"))
    assert (every.gains, every.initial, every.state_topic) == ((), (), None)
    some = only(
        arm(
            f"<plugin {named}><topic>move</topic><joint_name>lift</joint_name><joint_name>turn</joint_name>"
            "<initial_position>0.1</initial_position><position_p_gain>9</position_p_gain>"
            "<position_p_gain>8</position_p_gain><position_d_gain>3</position_d_gain>"
            "<velocity_p_gain>1</velocity_p_gain><velocity_i_gain>2</velocity_i_gain>"
            "<position_i_max>4</position_i_max></plugin>"
        )
    )
    assert (some.command_topic, some.joints, some.initial) == (
        "/robot/move",
        ("lift", "turn"),
        (("lift", 0.1),),
    )
    assert dict(some.gains) == {"lift": Pid(11.0, 0.0, 4.0, 4.0), "turn": Pid(8.0, 0.0, 0.0, inf)}


@pytest.mark.parametrize(
    ("inside", "topic"),
    [
        ("", "/robot/set_joint_trajectory"),
        ("<topicName>go</topicName><robotNamespace>left</robotNamespace>", "/robot/left/go"),
        ("<ros><remapping>set_joint_trajectory:=/go</remapping></ros>", "/go"),
    ],
)
def test_that_of_gazebo_classic_leads_all_joints(
    arm: Callable[[str], Model], inside: str, topic: str
) -> None:
    read = only(arm(f'<plugin name="p" filename="libgazebo_ros_joint_pose_trajectory.so">{inside}</plugin>'))
    assert read == TrajectoryController("p", topic, ("turn", "lift"))


def test_joints_that_cannot_be_commanded_cause_warnings_and_missing_joints_are_refused(
    arm: Callable[[str], Model],
    golden: Golden,
) -> None:
    plugin = '<plugin name="gz::systems::JointTrajectoryController"><joint_name>{}</joint_name></plugin>'
    assert "robot.sdf:8: the joint 'hold' cannot be controlled" in str(arm(plugin.format("hold")).warnings[0])
    with golden.raises(SceneError, match=r"robot\.sdf:8.*'trun'.*'turn'"):
        arm(plugin.format("trun"))


URDF = """<robot name="arm">
<link name="world"/><link name="upper"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
  ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="world"/><child link="upper"/><axis xyz="0 0 1"/></joint>
{}</robot>"""
ROS_1 = """
arm:
  joint_state_controller: {type: joint_state_controller/JointStateController, publish_rate: 50}
  mover:
    type: effort_controllers/JointTrajectoryController
    joints: [turn]
    state_publish_rate: 25
    gains: {turn: {p: 50, i: 2, d: 4, i_clamp: 3}}
  single: {type: velocity_controllers/JointVelocityController, joint: turn}
"""
ROS_2 = """
controller_manager:
  ros__parameters:
    update_rate: 100
    mover: {type: joint_trajectory_controller/JointTrajectoryController}
    soft: {type: admittance_controller/AdmittanceController}
mover:
  ros__parameters:
    joints: [turn]
    command_interfaces: [position]
"""


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[..., Model]:
    """Read a URDF with a file of controllers beside it."""

    def read(body: str, controllers: str = "") -> Model:
        (tmp_path / "arm.urdf").write_text(URDF.format(body))
        (tmp_path / "controllers.yaml").write_text(controllers)
        return read_model(tmp_path / "arm.urdf")

    return read


def plugin(name: str, file: str = "controllers.yaml") -> str:
    return (
        f'<gazebo><plugin name="c" filename="lib{name}.so"><parameters>{file}</parameters></plugin></gazebo>'
    )


def test_controllers_of_ros_1_are_read_from_the_file_that_the_plugin_names(
    urdf: Callable[..., Model],
) -> None:
    read = urdf(plugin("gazebo_ros_control"), ROS_1)
    assert read.trajectory_controllers == (
        TrajectoryController(
            "mover",
            "/arm/mover/command",
            ("turn",),
            (("turn", Pid(50.0, 2.0, 4.0, 3.0)),),
            (),
            "/arm/mover/state",
            25.0,
            holds=True,
        ),
    )
    assert read.controllers == (JointController("turn", "velocity", "/arm/single/command", None),)
    assert read.warnings == ()


def test_controllers_of_ros_2_have_its_topics_and_other_types_are_warned_of(
    urdf: Callable[..., Model],
) -> None:
    read = urdf(plugin("gazebo_ros2_control"), ROS_2)
    topics = "/arm/mover/joint_trajectory", "/arm/mover/controller_state"
    assert read.trajectory_controllers == (
        TrajectoryController("mover", topics[0], ("turn",), state_topic=topics[1], holds=True),
    )
    (warning,) = read.warnings
    assert "controllers of type 'admittance_controller/AdmittanceController' are not supported" in str(
        warning
    )


ONE_KG = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
ROVER = f'<robot name="rover"><link name="base">{ONE_KG}</link>{{}}{{}}</robot>'
WHEEL = f"""<link name="{{0}}">{ONE_KG}</link><joint name="{{0}}_axle" type="continuous">
  <origin xyz="0 {{1}} 0"/><parent link="base"/><child link="{{0}}"/><axis xyz="0 1 0"/></joint>"""
DRIVE_1 = """
mobile:
  type: diff_drive_controller/DiffDriveController
  left_wheel: l_axle
  right_wheel: [r_axle]
  wheel_radius: 0.1
  wheel_separation_multiplier: 1.5
  cmd_vel_timeout: 0.25
"""
DRIVE_2 = """
controller_manager: {ros__parameters: {mobile: {type: diff_drive_controller/DiffDriveController}}}
mobile:
  ros__parameters:
    {left_wheel_names: [l_axle], right_wheel_names: [r_axle], wheel_separation: 0.7, wheel_radius: 0.1}
"""


@pytest.mark.parametrize(
    ("text", "command", "separation", "timeout"),
    [(DRIVE_1, "cmd_vel", 0.9, 0.25), (DRIVE_2, "cmd_vel_unstamped", 0.7, 0.5)],
    ids=["ROS 1", "ROS 2"],
)
def test_the_drive_of_ros_control_is_one_of_wheels(
    tmp_path: Path, text: str, command: str, separation: float, timeout: float
) -> None:
    wheels = WHEEL.format("l", 0.3) + WHEEL.format("r", -0.3)
    (tmp_path / "rover.urdf").write_text(ROVER.format(wheels, plugin("gazebo_ros2_control")))
    (tmp_path / "controllers.yaml").write_text(text)
    (drive,) = read_model(tmp_path / "rover.urdf").drives
    expected = WheelDrive(
        "mobile", f"/rover/mobile/{command}", ("l_axle",), ("r_axle",), pytest.approx(separation), 0.2,
        timeout=timeout, rate_hz=50.0, odometry_topic="/rover/mobile/odom",
    )  # fmt: skip
    assert drive == expected


@pytest.mark.parametrize(
    ("namespace", "rule", "topic"),
    [
        ("", "/mobile/cmd_vel_unstamped:=/base/twist", "/base/twist"),
        ("", "mobile/cmd_vel_unstamped:=twist", "/rover/twist"),
        ("/fleet", "/fleet/mobile/cmd_vel_unstamped:=/base/twist", "/base/twist"),
        ("/fleet", "/mobile/cmd_vel_unstamped:=/base/twist", "/rover/fleet/mobile/cmd_vel_unstamped"),
    ],
)
def test_topics_of_controllers_are_remapped_as_in_ros_2(
    tmp_path: Path, namespace: str, rule: str, topic: str
) -> None:
    wheels = WHEEL.format("l", 0.3) + WHEEL.format("r", -0.3)
    rules = f"<ros><namespace>{namespace}</namespace><remapping>{rule}</remapping></ros>"
    control = plugin("gz_ros2_control-system").replace("</plugin>", f"{rules}</plugin>")
    (tmp_path / "rover.urdf").write_text(ROVER.format(wheels, control))
    (tmp_path / "controllers.yaml").write_text(DRIVE_2)
    (drive,) = read_model(tmp_path / "rover.urdf").drives
    assert drive.command_topic == topic


def test_a_missing_file_of_controllers_causes_a_warning(urdf: Callable[..., Model], golden: Golden) -> None:
    (warning,) = urdf(plugin("gazebo_ros_control", "gone.yaml")).warnings
    assert "'gone.yaml'" in str(warning)
    golden(str(warning))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [", "controllers.yaml:1: not valid YAML"),
        ("- a", "controllers.yaml:1: a controller file must be a mapping"),
        ("m: {type: x/JointTrajectoryController}", "the controller 'm' names no joint that it can control"),
        ("m: {type: x/JointTrajectoryController, joints: [trun]}", "no joint 'trun'; did you mean 'turn'"),
        (
            "m: {type: x/JointTrajectoryController, joints: [turn], gains: {turn: {p: -1}}}",
            "p of 'm/gains/turn'",
        ),
        ("m: {type: x/JointTrajectoryController, joints: [turn], gains: {turn: {p: a}}}", "must be a number"),
        ("m: {type: x/DiffDriveController, left_wheel: turn}", "the drive 'm' needs wheels on both sides"),
        ("m: {type: x/DiffDriveController, left_wheel: turn, right_wheel: turn}", "a wheel_radius"),
    ],
)
def test_a_faulty_controller_is_left_out_and_the_robot_stays(
    urdf: Callable[..., Model], text: str, message: str
) -> None:
    model = urdf(plugin("gazebo_ros_control"), text)
    (warning,) = [str(each) for each in model.warnings if "left out" in str(each)]
    assert message in warning
    assert "controllers.yaml:1" in warning
    assert model.joints
    assert (model.drives, model.controllers, model.trajectory_controllers) == ((), (), ())


def test_a_faulty_controller_leaves_the_others(urdf: Callable[..., Model]) -> None:
    kind = "type: x/JointTrajectoryController"
    model = urdf(plugin("gazebo_ros_control"), f"bad: {{{kind}}}\ngood: {{{kind}, joints: [turn]}}")
    assert only(model).name == "good"
    assert [str(each).partition(": ")[0][-18:] for each in model.warnings] == ["controllers.yaml:1"]


def test_a_key_that_is_there_twice_is_merged_as_in_ros(urdf: Callable[..., Model]) -> None:
    text = """/**:
  controller_manager: {ros__parameters: {update_rate: 100, arm: {type: x/JointTrajectoryController}}}
/**:
  arm: {ros__parameters: {joints: [turn], state_publish_rate: 5.0, state_publish_rate: 7.0}}
"""
    model = urdf(plugin("gazebo_ros_control"), text)
    assert (only(model).joints, only(model).rate_hz) == (("turn",), 7.0)
    (warning,) = model.warnings
    assert "controllers.yaml:4: a second 'state_publish_rate'" in str(warning)


@pytest.mark.parametrize("interface", ["Position", "Effort", "Velocity"])
def test_transmissions_without_such_a_file_take_trajectories_of_positions(
    urdf: Callable[..., Model], interface: str
) -> None:
    read = urdf(
        f'<transmission name="t"><joint name="turn"><hardwareInterface>{interface}JointInterface'
        "</hardwareInterface></joint></transmission>"
    )
    topics = [(each.command_topic, each.state_topic, each.joints) for each in read.trajectory_controllers]
    base = "/arm/joint_trajectory_controller"
    assert topics == ([] if interface == "Velocity" else [(f"{base}/command", f"{base}/state", ("turn",))])
