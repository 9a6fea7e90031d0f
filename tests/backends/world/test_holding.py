"""Controllers of positions hold the start of their joints until the first command, as in ros2_control."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import pytest
from jointed import MOMENT, axis, command, joint, link

from nrp_core.messages.base import Duration
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.messages.trajectory_msgs import JointTrajectory, JointTrajectoryPoint
from nrp_core.scene.devices import Pid
from nrp_core.scene.sdf import read_model
from nrp_core.world import Model, World
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot

ARM = (
    link("base", at=(0, 0, 1))
    + link("bob", com=(0.3, 0, 0), at=(0, 0, 1), mass=2, moments=(MOMENT, MOMENT, MOMENT))
    + joint("revolute", axis("0 1 0"), parent="base")
)
"""A mass of 2 kg, 0.3 m beside the axis that holds it."""


def angle(world: World) -> float:
    return float(world.joint_states("robot").positions[0])


def fitted(read: Callable[..., Model], mode: str, start: float = 0.0, **more: object) -> Model:
    control = ((".*", JointControl(mode, **more)),)  # type: ignore[arg-type]
    return set_up_robot(read(ARM), RobotSetup(True, (("j", start),), control))


@pytest.mark.parametrize("start", [0.0, 0.7])
@pytest.mark.parametrize(
    ("mode", "more"), [("position", {}), ("trajectory", {}), ("position", {"group": "all"})]
)
def test_a_joint_is_held_where_it_starts(open_world, read, advance, mode, more, start) -> None:
    world = open_world(fitted(read, mode, start, **more))
    advance(world, 1.0)
    assert angle(world) == pytest.approx(start, abs=1e-3)
    assert world.joint_states("robot").velocities[0] == pytest.approx(0.0, abs=1e-3)
    world.reset()
    advance(world, 0.5)
    assert angle(world) == pytest.approx(start, abs=1e-3)


@pytest.mark.parametrize("mode", ["velocity", "effort"])
def test_commands_of_velocity_and_effort_leave_it_free(open_world, read, advance, mode) -> None:
    world = open_world(fitted(read, mode))
    advance(world, 0.5)
    assert angle(world) > 0.5


def test_a_spring_of_gains_holds_at_its_equilibrium(open_world, read, advance) -> None:
    """100 N m/rad against 2 kg at 0.3 m: 100 q = 2 * 9.8 * 0.3 * cos(q)."""
    world = open_world(fitted(read, "position", gains=Pid(100.0, 0.0, 10.0)))
    advance(world, 3.0)
    assert angle(world) == pytest.approx(0.0587, abs=1e-3)


def test_the_first_command_ends_it(open_world, read, advance) -> None:
    world = open_world(fitted(read, "position"))
    advance(world, 0.2)
    command(world, "j", "pos", 0.8)
    advance(world, 0.6)
    assert angle(world) == pytest.approx(0.8, abs=1e-3)
    world.set_joints("robot", {"j": 0.1})
    advance(world, 0.6)
    assert angle(world) == pytest.approx(0.8, abs=1e-3)


def test_a_joint_that_is_put_elsewhere_is_held_there(open_world, read, advance) -> None:
    world = open_world(fitted(read, "position"))
    for position in (0.4, -0.9):
        world.set_joints("robot", {"j": position})
        advance(world, 0.5)
        assert angle(world) == pytest.approx(position, abs=1e-3)


def test_a_snapshot_has_what_is_held(open_world, read, advance, require_to_go_on) -> None:
    worlds = [open_world(fitted(read, "position", 0.3)) for _ in range(2)]
    world, fresh = worlds
    world.set_joints("robot", {"j": 0.5})
    advance(world, 0.1)
    require_to_go_on(world, fresh, 0.2, angle)
    fresh.set_joints("robot", {"j": -0.2})
    advance(fresh, 0.2)
    assert angle(fresh) == pytest.approx(-0.2, abs=1e-3)


URDF = """<robot name="robot"><link name="world"/>
<link name="bob"><inertial><mass value="2"/><origin xyz="0.3 0 0"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><origin xyz="0 0 1"/><parent link="world"/><child link="bob"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="5"/></joint>
<gazebo>{plugin}</gazebo></robot>"""
CONTROL = '<plugin name="c" filename="libgz_ros2_control-system.so"><parameters>c.yaml</parameters></plugin>'
YAML = "{{controller_manager: {{ros__parameters: {{arm: {{type: {}}}}}}}, arm: {{ros__parameters: {{{}}}}}}}"
TRAJECTORY = YAML.format("joint_trajectory_controller/JointTrajectoryController", "joints: [j]")
FORWARD = YAML.format(
    "forward_command_controller/ForwardCommandController", "joints: [j], interface_name: position"
)
SINGLE = "arm: {type: effort_controllers/JointPositionController, joint: j, pid: {p: 900, d: 60}}"


@pytest.fixture
def robot(tmp_path):
    def robot(plugin: str, parameters: str = "") -> Model:
        (tmp_path / "c.yaml").write_text(parameters)
        (tmp_path / "r.urdf").write_text(URDF.format(plugin=plugin))
        return read_model(tmp_path / "r.urdf")

    return robot


@pytest.mark.parametrize("parameters", [TRAJECTORY, FORWARD, SINGLE])
def test_controllers_of_ros_hold(open_world, robot, advance, parameters) -> None:
    world = open_world(robot(CONTROL, parameters))
    advance(world, 1.0)
    assert angle(world) == pytest.approx(0.0, abs=1e-3 if parameters is not SINGLE else 0.0066)


def test_a_first_trajectory_begins_where_the_joint_is_held(open_world, robot, advance) -> None:
    world = open_world(robot(CONTROL, TRAJECTORY))
    advance(world, 0.2)
    target = JointTrajectoryPoint(positions=[0.8], time_from_start=Duration(1))
    world.advertise("/robot/arm/joint_trajectory").publish(
        JointTrajectory(joint_names=["j"], points=[target])
    )
    advance(world, 0.5)
    assert angle(world) == pytest.approx(0.4, abs=0.01)
    advance(world, 1.0)
    assert angle(world) == pytest.approx(0.8, abs=1e-3)


def test_one_number_of_a_group_that_is_held_moves_it(open_world, robot, advance) -> None:
    world = open_world(robot(CONTROL, FORWARD))
    advance(world, 0.2)
    world.advertise("/robot/arm/commands").publish(Float64MultiArray(data=[-0.5]))
    advance(world, 0.6)
    assert angle(world) == pytest.approx(-0.5, abs=1e-3)


def test_plugins_of_gazebo_leave_it_free(open_world, robot, advance) -> None:
    """The pendulum swings as without the plugin: it hangs down at a right angle."""
    plugin = '<plugin name="p" filename="libgazebo_ros_joint_pose_trajectory.so"/>'
    angles = []
    for each in (plugin, ""):
        world = open_world(robot(each))
        advance(world, 0.4)
        angles.append(angle(world))
    assert angles[0] == angles[1]
    assert 0.5 < angles[0] < pi


MJCF = """<mujoco><worldbody><body name="robot" pos="0 0 1"><body name="bob">
  <inertial mass="2" pos="0.3 0 0" diaginertia="0.01 0.01 0.01"/><joint name="j" axis="0 1 0"/>
  </body></body></worldbody>
  <actuator><motor name="m" joint="j"/><velocity name="v" joint="j" kv="1"/></actuator></mujoco>"""


def test_a_position_is_held_beside_motors_of_the_file(open_world, tmp_path, advance) -> None:
    """In MJCF a motor of speed 0 acts from the start, unless the experiment adds a controller that holds."""
    pytest.importorskip("nrp_world_mujoco")
    (tmp_path / "arm.xml").write_text(MJCF)
    model = read_model(tmp_path / "arm.xml")
    world = open_world(model)
    advance(world, 0.5)
    assert angle(world) > 0.5
    world = open_world(set_up_robot(model, RobotSetup(control=(("j", JointControl("position")),))))
    for _ in range(2):
        advance(world, 0.5)
        assert angle(world) == pytest.approx(0.0, abs=1e-3)
        world.reset()
