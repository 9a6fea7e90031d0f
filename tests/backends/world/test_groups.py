"""Groups of joints that one message commands, as a forward_command_controller has them."""

from __future__ import annotations

import numpy as np
import pytest

from nrp_core.errors import TopicError
from nrp_core.world.messages.std_msgs import Float64MultiArray
from nrp_core.world.scene.sdf import read_model

LINK = """<link name="l{0}"><inertial><mass value="1"/><origin xyz="0.2 0 0"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j{0}" type="revolute"><origin xyz="{0} 0 1"/><parent link="world"/><child link="l{0}"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="5"/></joint>"""
PLUGIN = (
    '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so"><parameters>c.yaml</parameters>'
    "</plugin></gazebo>"
)
FILE = """
controller_manager:
  ros__parameters:
    arm: {{type: {kind}}}
arm:
  ros__parameters: {{{parameters}}}
"""
FORWARD = "forward_command_controller/ForwardCommandController"


@pytest.fixture
def robot(tmp_path):
    def robot(kind: str, parameters: str):
        (tmp_path / "c.yaml").write_text(FILE.format(kind=kind, parameters=parameters))
        links = "".join(LINK.format(number) for number in (1, 2, 3))
        (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="world"/>{links}{PLUGIN}</robot>')
        return read_model(tmp_path / "r.urdf")

    return robot


def command(world, *numbers: float) -> None:
    world.advertise("/r/arm/commands").publish(Float64MultiArray(data=np.array(numbers)))


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        (FORWARD, "joints: [j3, j1], interface_name: position"),
        ("position_controllers/JointGroupPositionController", "joints: [j3, j1]"),
    ],
)
def test_each_number_goes_to_the_joint_at_its_place(robot, open_world, advance, kind, parameters):
    world = open_world(robot(kind, parameters))
    command(world, 0.3, -0.4)
    advance(world, 1.0)
    states = world.engine.joint_states("r")
    found = dict(zip(states.names, states.positions, strict=True))
    assert (found["j3"], found["j1"]) == pytest.approx((0.3, -0.4), abs=1e-3)
    assert abs(found["j2"]) > 0.5  # nobody holds it


def test_a_group_commands_velocities(robot, open_world, advance):
    world = open_world(robot("velocity_controllers/JointGroupVelocityController", "joints: [j1, j2, j3]"))
    command(world, 0.5, -0.5, 1.0)
    advance(world, 0.5)
    assert world.engine.joint_states("r").velocities == pytest.approx([0.5, -0.5, 1.0], rel=0.01)


def test_too_few_numbers_are_refused(robot, open_world):
    world = open_world(robot(FORWARD, "joints: [j3, j1], interface_name: effort"))
    with pytest.raises(TopicError, match="'arm' has 2 joints; 1 numbers came"):
        command(world, 0.3)


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ("interface_name: position", "it names no joints"),
        ("joints: [j1], interface_name: torque", "its interface_name is 'torque' and not one of position,"),
        ("joints: [j1]", "its interface_name is None and not one of position, velocity, effort"),
    ],
)
def test_an_incomplete_group_is_left_out_with_the_reason(robot, parameters, why):
    model = robot(FORWARD, parameters)
    assert model.group_controllers == ()
    (warning,) = (each for each in model.warnings if "'arm'" in each.message)
    assert why in warning.message
