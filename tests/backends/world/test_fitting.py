"""Robots whose file leaves the control of their joints open, in both engines."""

from __future__ import annotations

import pytest
from jointed import MOMENT, axis, command, joint, limit, link

from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.merged_bodies import joint_inertias
from nrp_core.world import parts
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot

ARM = (
    link("base", at=(0, 0, 1))
    + link("bob", com=(0.2, 0, 0), at=(0, 0, 1))
    + joint("revolute", axis("0 1 0", limit(0.2, 2.0)), parent="base")
    + link("wheel", at=(0.4, 0, 1))
    + joint("continuous", axis("1 0 0"), name="spin", parent="bob", child="wheel")
)


def test_a_robot_without_controllers_is_held_starts_and_obeys_as_the_experiment_says(
    open_world, read, advance
):
    control = (("j", JointControl("position")), ("spin", JointControl("velocity")))
    world = open_world(set_up_robot(read(ARM), RobotSetup(True, (("j", 0.5),), control)))
    assert world.joint_states("robot").positions.tolist() == pytest.approx([0.5, 0.0])
    command(world, "j", "pos", 1.2)
    command(world, "spin", "vel", 3.0)
    advance(world, 0.6)
    states = world.joint_states("robot")
    assert states.positions[0] == pytest.approx(1.2, abs=1e-3)
    assert states.velocities[1] == pytest.approx(3.0, rel=0.01)
    assert world.engine.link_motion("robot", "base").pose.position == pytest.approx((0, 0, 1), abs=1e-9)


@pytest.mark.parametrize(("mode", "expected"), [("position", [0.9, 1.5]), ("velocity", [0.9, 0.9])])
def test_a_group_of_joints_obeys_one_message(open_world, read, advance, mode, expected) -> None:
    """Positions are reached; velocities turn the joints from 0.5 and 0 for 0.6 s."""
    control = ((".*", JointControl(mode, group="all")),)
    world = open_world(set_up_robot(read(ARM), RobotSetup(True, (("j", 0.5),), control)))
    together = world.advertise("/robot/all/commands")
    together.publish(Float64MultiArray(data=[0.9, 1.5] if mode == "position" else [0.4 / 0.6, 1.5]))
    advance(world, 0.6)
    states = world.joint_states("robot")
    reached = states.positions.tolist()
    assert reached == pytest.approx(expected, abs=2e-3 if mode == "position" else 0.08)
    if mode == "velocity":
        assert states.velocities.tolist() == pytest.approx([0.4 / 0.6, 1.5], rel=0.01)


def test_the_inertias_of_a_robot_are_computed_once_for_all_its_joints(open_world, read, monkeypatch):
    """They took most of the time in which a humanoid opens."""
    computed = []
    monkeypatch.setattr(parts, "joint_inertias", lambda bodies: computed.append(1) or joint_inertias(bodies))
    control = ((".*", JointControl("position")), ("spin", JointControl("velocity")))
    open_world(set_up_robot(read(ARM), RobotSetup(True, control=control)))
    assert len(computed) == 1


WRIST = (
    link("upper", moments=(1e-3, 1e-3, 1e-3), mass=0.2)
    + joint("continuous", axis("0 1 0"), name="first", child="upper")
    + link("heavy", com=(0.1, 0, 0), moments=(MOMENT, MOMENT, MOMENT))
    + joint("continuous", axis("0 1 0"), name="second", parent="upper", child="heavy")
)
"""A light link that turns a heavy one about the same axis: each motor undoes what the other does."""


def test_a_light_wrist_obeys_beneath_a_heavy_hand(open_world, read, advance) -> None:
    """Commands of velocity come within 1 % after 0.2 s: an exponential of 40 ms leaves 0.7 %."""
    world = open_world(set_up_robot(read(WRIST), RobotSetup(None, (), ((".*", JointControl("velocity")),))))
    command(world, "first", "vel", 0.5)
    command(world, "second", "vel", 0.5)
    for _ in range(4):
        advance(world, 0.2)
        assert world.joint_states("robot").velocities.tolist() == pytest.approx([0.5, 0.5], rel=0.01)
