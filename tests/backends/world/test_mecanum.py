"""Bases on mecanum wheels, read from a file as gz-sim's plugin and its controller in ROS 2 have them."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path

import pytest

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Model
from nrp_core.scene.sdf import read_model
from nrp_core.world.drives.mecanum import MecanumDrive

TRACK, BASE, RADIUS = 0.36, 0.3, 0.05
CORNERS = {"fl": (1, 1), "fr": (1, -1), "bl": (-1, 1), "br": (-1, -1)}
INERTIA = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
PLUGIN = f"""<plugin filename="libignition-gazebo-mecanum-drive-system.so" name="{{0}}">
  <front_left_joint>fl_axle</front_left_joint><front_right_joint>fr_axle</front_right_joint>
  <back_left_joint>bl_axle</back_left_joint><back_right_joint>br_axle</back_right_joint>
  <wheel_separation>{TRACK}</wheel_separation><wheelbase>{BASE}</wheelbase>
  <wheel_radius>{RADIUS}</wheel_radius><topic>cmd_vel</topic></plugin>"""
CONTROLLER = f"""
controller_manager: {{ros__parameters: {{base: {{type: mecanum_drive_controller/MecanumDriveController}}}}}}
base:
  ros__parameters:
    front_left_wheel_command_joint_name: fl_axle
    front_right_wheel_command_joint_name: fr_axle
    rear_left_wheel_command_joint_name: bl_axle
    rear_right_wheel_command_joint_name: br_axle
    kinematics:
      wheels_radius: {RADIUS}
      sum_of_robot_center_projection_on_X_Y_axis: {(TRACK + BASE) / 2}
"""


def rover(folder: Path, plugin: str) -> Model:
    """Return a base with four wheels; the axes of the right ones point right, as some files have them."""
    parts = []
    for name, (end, side) in CORNERS.items():
        place = f"{end * BASE / 2} {side * TRACK / 2} {RADIUS}"
        parts.append(
            f'<link name="{name}"><inertial><mass value="0.4"/>{INERTIA.format(0.0005)}</inertial>'
            f'<collision><geometry><sphere radius="{RADIUS}"/></geometry></collision></link>'
            f'<joint name="{name}_axle" type="continuous"><origin xyz="{place}"/><parent link="base"/>'
            f'<child link="{name}"/><axis xyz="0 {side} 0"/></joint>'
        )
    base = f'<inertial><origin xyz="0 0 0.1"/><mass value="6"/>{INERTIA.format(0.1)}</inertial>'
    body = f'<link name="base">{base}</link>{"".join(parts)}<gazebo>{plugin}</gazebo>'
    (folder / "rover.urdf").write_text(f'<robot name="rover">{body}</robot>')
    return read_model(folder / "rover.urdf")


@pytest.mark.parametrize("drive", ["planar", "physical"])
def test_a_base_on_mecanum_wheels_goes_sideways_and_its_wheels_spin_as_rollers_make_them(
    open_world, parts, advance, tmp_path: Path, drive: str
) -> None:
    model = rover(tmp_path, PLUGIN.format("ignition::gazebo::systems::MecanumDrive"))
    world = open_world(parts.floor(), model, drive=drive)
    forward, left, turn = 0.3, -0.2, 0.5
    for _ in range(50):
        world.advertise("/rover/cmd_vel").publish(Twist(Vector3(forward, left), Vector3(0.0, 0.0, turn)))
        advance(world, 0.02)
    pose = world.model_motion("rover").pose
    x = (forward * sin(turn) + left * (cos(turn) - 1)) / turn
    y = (forward * (1 - cos(turn)) + left * sin(turn)) / turn
    assert pose.position[:2] == pytest.approx((x, y), abs=5e-3)
    assert pose.yaw == pytest.approx(turn, abs=3e-3)
    joints = world.joint_states("rover")
    spins = dict(zip(joints.names, joints.velocities, strict=True))
    reach = (TRACK + BASE) / 2 * turn
    # what each wheel rolls, Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 3.2
    rolled = {
        "fl": forward - left - reach,
        "fr": forward + left + reach,
        "bl": forward + left - reach,
        "br": forward - left + reach,
    }
    expected = {f"{name}_axle": CORNERS[name][1] * way / RADIUS for name, way in rolled.items()}
    assert spins == pytest.approx(expected, abs=0.1)


def test_the_controller_of_ros_2_is_the_same_drive(tmp_path: Path) -> None:
    (tmp_path / "controllers.yaml").write_text(CONTROLLER)
    asked = "<parameters>controllers.yaml</parameters>"
    plugin = f'<plugin name="c" filename="libgz_ros2_control-system.so">{asked}</plugin>'
    (of_ros,) = rover(tmp_path, plugin).drives
    (of_gazebo,) = rover(tmp_path, PLUGIN.format("gz::sim::systems::MecanumDrive")).drives
    assert isinstance(of_ros, MecanumDrive)
    assert isinstance(of_gazebo, MecanumDrive)
    assert of_ros.joints == of_gazebo.joints
    assert (of_ros.separation, of_ros.wheel_diameter) == (of_gazebo.separation, of_gazebo.wheel_diameter)
    assert of_ros.command_topic == "/rover/base/reference_unstamped"


def test_a_controller_without_its_sizes_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "controllers.yaml").write_text(CONTROLLER.partition("    kinematics")[0])
    plugin = '<plugin name="c" filename="libgz_ros2_control-system.so"><parameters>controllers.yaml'
    model = rover(tmp_path, f"{plugin}</parameters></plugin>")
    assert model.drives == ()
    assert "the drive 'base' needs four wheels and its kinematics" in str(model.warnings)
