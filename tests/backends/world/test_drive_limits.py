"""Limits of the velocity and acceleration of drives, and the covariances of their odometry."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import pytest

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.sdf import read_model
from nrp_core.world.drives.wheels import SpeedLimits

WHEEL = """<link name="{0}"><inertial><mass value="0.5"/><inertia ixx=".002" iyy=".002" izz=".002"
ixy="0" ixz="0" iyz="0"/></inertial><collision><origin rpy="1.5708 0 0"/><geometry>
<cylinder radius="0.1" length="0.04"/></geometry></collision></link>
<joint name="{0}_wheel" type="continuous"><parent link="base"/><child link="{0}"/><origin xyz="0 {1} 0"/>
<axis xyz="0 1 0"/></joint>"""
ROBOT = (
    """<robot name="r"><link name="base"><inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1"
ixy="0" ixz="0" iyz="0"/></inertial></link>"""
    + WHEEL.format("left", 0.2)
    + WHEEL.format("right", -0.2)
    + "<gazebo>{}</gazebo></robot>"
)
GZ = """<plugin name="gz::sim::systems::DiffDrive" filename="gz-sim-diff-drive-system">
<left_joint>left_wheel</left_joint><right_joint>right_wheel</right_joint><wheel_separation>0.4</wheel_separation>
<wheel_radius>0.1</wheel_radius><topic>cmd_vel</topic><odom_topic>odom</odom_topic>{}</plugin>"""
CONTROL = '<plugin name="c" filename="libgz_ros2_control-system.so"><parameters>c.yaml</parameters></plugin>'
YAML = """base:
  ros__parameters:
    type: diff_drive_controller/DiffDriveController
    left_wheel_names: [left_wheel]
    right_wheel_names: [right_wheel]
    wheel_separation: 0.4
    wheel_radius: 0.1
    cmd_vel_timeout: 9.0
    {}
"""
LIMITS = (
    "<max_linear_velocity>0.4</max_linear_velocity><min_linear_velocity>-0.1</min_linear_velocity>"
    "<max_linear_acceleration>2</max_linear_acceleration><min_linear_acceleration>-2</min_linear_acceleration>"
)
DOTTED = "linear.x.max_velocity: 0.4\n    linear.x.min_velocity: -0.1\n    linear.x.max_acceleration: 2.0"
NESTED = "linear: {x: {max_velocity: 0.4, min_velocity: -0.1, max_acceleration: 2.0}}"
EXPECTED = SpeedLimits(-0.1, 0.4, -2.0, 2.0)


@pytest.fixture
def robot(tmp_path):
    def robot(plugin: str, parameters: str = ""):
        (tmp_path / "c.yaml").write_text(YAML.format(parameters))
        (tmp_path / "r.urdf").write_text(ROBOT.format(plugin))
        return read_model(tmp_path / "r.urdf")

    return robot


def drive(model):
    (found,) = model.drives
    return found


@pytest.mark.parametrize(
    ("plugin", "parameters"), [(GZ.format(LIMITS), ""), (CONTROL, DOTTED), (CONTROL, NESTED)]
)
def test_the_limits_of_files_are_read(robot, plugin, parameters) -> None:
    model = robot(plugin, parameters)
    assert (drive(model).linear, drive(model).angular) == (EXPECTED, SpeedLimits())
    assert model.warnings == ()


def test_limits_of_both_directions_are_replaced_by_those_of_one(robot) -> None:
    both = "<max_velocity>0.3</max_velocity><max_angular_velocity>0.5</max_angular_velocity>"
    model = robot(GZ.format(both))
    assert drive(model).linear == SpeedLimits(max_velocity=0.3)
    assert drive(model).angular == SpeedLimits(max_velocity=0.5)


def test_limits_that_are_switched_off_have_no_effect(robot) -> None:
    off = "linear: {x: {has_velocity_limits: false, max_velocity: 0.4, max_acceleration: .nan}}"
    assert drive(robot(CONTROL, off)).linear == SpeedLimits()


@pytest.fixture
def limited(parts, open_world):
    """Open a world with a robot on a floor whose drive has limits."""

    def limited(**limits):
        husky = parts.husky("r")
        held = replace(husky.drives[0], timeout=9.0, **limits)
        return open_world(parts.floor(), replace(husky, drives=(held,)))

    return limited


def test_a_drive_accelerates_and_is_as_fast_as_its_limits(limited, advance) -> None:
    """In 0.5 s: 0.2 s with 2 m/s^2, which is 0.04 m, then 0.3 s with 0.4 m/s."""
    world = limited(linear=EXPECTED)
    publication = world.advertise("/r/cmd_vel")
    publication.publish(Twist(Vector3(5.0)))
    advance(world, 0.1)
    assert world.model_motion("r").linear[0] == pytest.approx(0.2, abs=0.01)
    advance(world, 0.4)
    assert world.model_motion("r").pose.position[0] == pytest.approx(0.16, abs=0.004)
    publication.publish(Twist(Vector3(-5.0)))
    advance(world, 0.5)
    assert world.model_motion("r").linear[0] == pytest.approx(-0.1, abs=0.003)


def test_a_drive_turns_no_faster_than_its_limit(limited, advance) -> None:
    world = limited(angular=SpeedLimits(-0.5, 0.5))
    world.advertise("/r/cmd_vel").publish(Twist(Vector3(), Vector3(z=2.0)))
    advance(world, 0.4)
    assert world.model_motion("r").angular[2] == pytest.approx(0.5, rel=0.03)


def test_each_wheel_accelerates_no_more_than_its_limit(limited, advance) -> None:
    """In 0.4 s each rim reaches 0.4 m/s with 1 m/s^2; rims of a robot that turns differ by twice that."""
    world = limited(wheel=SpeedLimits(min_acceleration=-1.0, max_acceleration=1.0))
    publication = world.advertise("/r/cmd_vel")
    publication.publish(Twist(Vector3(5.0)))
    advance(world, 0.4)
    assert world.model_motion("r").linear[0] == pytest.approx(0.4, abs=0.01)
    publication.publish(Twist())
    advance(world, 0.6)
    assert world.model_motion("r").linear[0] == pytest.approx(0.0, abs=0.01)
    publication.publish(Twist(Vector3(), Vector3(z=9.0)))
    advance(world, 0.4)
    turn = 2 * 0.4 / world.scene.models[1].drives[0].separation
    assert world.model_motion("r").angular[2] == pytest.approx(turn, rel=0.05)


def test_several_commands_at_one_time_do_not_accelerate_more(limited, advance) -> None:
    speeds = []
    for times in (1, 5):
        world = limited(linear=EXPECTED)
        publication = world.advertise("/r/cmd_vel")
        for _ in range(5):
            for _ in range(times):
                publication.publish(Twist(Vector3(5.0)))
            advance(world, 0.02)
        speeds.append(world.model_motion("r").linear[0])
    assert speeds[0] == speeds[1]


def test_a_command_that_times_out_brakes_within_the_limit(limited, advance) -> None:
    world = limited(linear=SpeedLimits(-0.4, 0.4, -1.0, 2.0))
    world.advertise("/r/cmd_vel").publish(Twist(Vector3(5.0)))
    advance(world, 9.0)
    assert world.model_motion("r").linear[0] == pytest.approx(0.4, abs=0.01)
    advance(world, 0.2)
    assert world.model_motion("r").linear[0] == pytest.approx(0.2, abs=0.01)
    advance(world, 0.4)
    assert world.model_motion("r").linear[0] == pytest.approx(0.0, abs=0.01)


def test_a_snapshot_on_the_way_goes_on(limited, advance, require_to_go_on) -> None:
    world, fresh = (limited(linear=EXPECTED) for _ in range(2))
    world.advertise("/r/cmd_vel").publish(Twist(Vector3(5.0)))
    advance(world, 0.1)
    require_to_go_on(world, fresh, 0.2, lambda each: each.model_motion("r"))


def test_odometry_has_the_covariances_of_the_file(robot, open_world, advance) -> None:
    model = robot(CONTROL, "pose_covariance_diagonal: [0.1, 0.2, 0, 0, 0, 0.3]")
    world = open_world(model)
    odometry = world.subscribe(drive(model).odometry_topic)
    advance(world, 0.1)
    pose, twist = odometry.latest.message.pose.covariance, odometry.latest.message.twist.covariance
    assert [pose[7 * row] for row in range(6)] == [0.1, 0.2, 0.0, 0.0, 0.0, 0.3]
    assert sum(pose) == pytest.approx(0.6)
    assert set(twist) == {0.0}


SDF_ROBOT = """<sdf version="1.9"><model name="r"><link name="base"><inertial><mass>5</mass></inertial></link>
{wheels}<plugin name="d" filename="lib{file}.so">{joints}<wheelSeparation>0.4</wheelSeparation>
<wheelDiameter>0.2</wheelDiameter>{more}</plugin></model></sdf>"""


def ros_robot(folder, file, more):
    """Return a robot with a plugin of gazebo_ros_pkgs."""
    sides = {"left": 0.2, "right": -0.2}
    ends = ("Front", "Rear") if "skid" in file else ("",)
    names = {f"{side}{end}Joint": y for side, y in sides.items() for end in ends}
    wheels = "".join(
        f'<link name="{name}_w"><pose>0 {y} 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>'
        f'<joint name="{name}" type="revolute"><parent>base</parent><child>{name}_w</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
        for name, y in names.items()
    )
    joints = "".join(f"<{name}>{name}</{name}>" for name in names)
    (folder / "r.sdf").write_text(SDF_ROBOT.format(wheels=wheels, file=file, joints=joints, more=more))
    return read_model(folder / "r.sdf")


@pytest.mark.parametrize(
    ("more", "largest"),
    [
        ("", inf),
        ("<wheelAcceleration>0</wheelAcceleration>", inf),
        ("<wheelAcceleration>1.8</wheelAcceleration>", 1.8),
    ],
)
def test_the_acceleration_of_wheels_is_read(more, largest, tmp_path) -> None:
    assert drive(ros_robot(tmp_path, "gazebo_ros_diff_drive", more)).wheel.max_acceleration == largest


@pytest.mark.parametrize(
    ("file", "more", "variances"),
    [
        ("gazebo_ros_diff_drive", "", (1e-5, 1e-5, 1e-3)),
        ("gazebo_ros_diff_drive", "<covariance_yaw>0.2</covariance_yaw>", (1e-5, 1e-5, 0.2)),
        ("gazebo_ros_skid_steer_drive", "", (1e-4, 1e-4, 1e-2)),
    ],
)
def test_drives_of_ros_have_the_usual_covariances_of_their_plugins(
    file, more, variances, open_world, advance, tmp_path
) -> None:
    world = open_world(model := ros_robot(tmp_path, file, more))
    odometry = world.subscribe(drive(model).odometry_topic)
    advance(world, 0.1)
    message = odometry.latest.message
    for covariance in (message.pose.covariance, message.twist.covariance):
        assert [covariance[7 * row] for row in (0, 1, 5)] == list(variances)
        assert {covariance[7 * row] for row in (2, 3, 4)} == {1e12}
