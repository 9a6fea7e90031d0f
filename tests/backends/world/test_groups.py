"""Groups of joints that one message commands, as a forward_command_controller has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import TopicError
from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.devices import JointController
from nrp_core.scene.sdf import read_model
from nrp_core.world.engine_kit.jointed import JointedEngine

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


def test_a_number_that_is_not_finite_is_refused(robot, open_world, golden: Golden):
    world = open_world(robot(FORWARD, "joints: [j3, j1], interface_name: position"))
    with golden.raises(TopicError):
        command(world, 0.3, np.nan)


def test_too_few_numbers_are_refused(robot, open_world, golden: Golden):
    world = open_world(robot(FORWARD, "joints: [j3, j1], interface_name: effort"))
    with golden.raises(TopicError, match="'arm'"):
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


def group_of_three(robot, monkeypatch):
    """Return a firm group of three joints, and a counter of the calls for a single joint."""
    calls = []
    plain = JointedEngine._do_set_servo_target

    def counted(engine, model, joint, aim):
        calls.append(joint)
        plain(engine, model, joint, aim)

    monkeypatch.setattr(JointedEngine, "_do_set_servo_target", counted)
    return robot(FORWARD, "joints: [j1, j2, j3], interface_name: position"), calls


def test_the_targets_of_a_group_go_to_the_engine_in_one_call(robot, open_world, advance, monkeypatch):
    model, calls = group_of_three(robot, monkeypatch)
    world = open_world(model)
    command(world, 0.1, 0.1, 0.1)
    assert calls == ["j1", "j2", "j3"]
    for aim in (0.2, 0.3, -0.2):
        command(world, aim, -aim, 0.0)
    assert len(calls) == 3
    advance(world, 1.0)
    assert world.joint_states("r").positions == pytest.approx([-0.2, 0.2, 0.0], abs=1e-3)


def test_numbers_beyond_the_limits_of_a_group_are_bounded_and_reported_once(
    robot, open_world, advance, monkeypatch
):
    model, calls = group_of_three(robot, monkeypatch)
    world = open_world(model)
    for aim in (1.0, 2.5, 3.0):
        command(world, aim, 0.0, 0.0)
    assert len(calls) == 6  # the first beyond the limit goes its own way, to be reported
    (told,) = (each.message for each in world.warnings if "beyond" in each.message)
    assert "is 2.5, beyond the limit of the joint 'j1': 2 is used" in told
    advance(world, 1.5)
    assert world.joint_states("r").positions[0] == pytest.approx(2.0, abs=1e-3)


def test_a_joint_that_gets_another_command_leaves_the_group_until_its_next_one(robot, open_world, advance):
    model = robot(FORWARD, "joints: [j1, j2, j3], interface_name: position")
    single = JointController("j2", "position", "/r/j2", None)
    world = open_world(replace(model, controllers=(*model.controllers, single)))
    command(world, 0.1, 0.1, 0.1)
    command(world, 0.4, 0.4, 0.4)
    world.advertise("/r/j2").publish(Float64(-0.3))
    before = world.snapshot()
    advance(world, 1.0)
    assert world.joint_states("r").positions == pytest.approx([0.4, -0.3, 0.4], abs=1e-3)
    command(world, 0.2, 0.2, 0.2)
    command(world, 0.5, 0.6, 0.7)
    advance(world, 1.0)
    assert world.joint_states("r").positions == pytest.approx([0.5, 0.6, 0.7], abs=1e-3)
    world.restore(before)
    advance(world, 1.0)
    assert world.joint_states("r").positions == pytest.approx([0.4, -0.3, 0.4], abs=1e-3)
