"""Dry friction in joints, and joints that follow others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from chains import GRAVITY, chain
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Box, Collision, Inertial, Joint, Link, Mimic, Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.sensors.contact import ForceTorque

MASS = 2.0
MOMENTS = (1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0)


def sliding(parts, friction, pull):
    """Return a mass on a rail along x, which is pulled along it."""
    model = parts.hanging("prismatic", (1, 0, 0), com=(0, 0, 0))
    joints = tuple(replace(joint, friction=friction) for joint in model.joints)
    return Scene((replace(model, joints=joints),), gravity=(pull / MASS, 0.0, 0.0))


def gripper(*followers: Mimic) -> Model:
    """Return a hand in the air whose first finger takes commands; the others follow."""
    finger = Inertial(0.05, inertia=MOMENTS)
    names = ["thumb", *(f"finger_{number}" for number in range(len(followers)))]
    links = [Link("palm", inertial=Inertial(1.0, inertia=(0.01,) * 3 + (0.0,) * 3))]
    links += [Link(name, Pose((0.0, 0.1 * n, 0.0)), inertial=finger) for n, name in enumerate(names)]
    joints = [Joint("mount", "fixed", "world", "palm")]
    joints += [
        Joint(f"{name}_joint", "prismatic", "palm", name, links[n + 1].pose, (1.0, 0.0, 0.0), mimic=mimic)
        for n, (name, mimic) in enumerate(zip(names, (None, *followers), strict=True))
    ]
    control = JointController("thumb_joint", "position", "/hand/thumb", gains=None)
    topic = "/hand/joint_states"
    return Model("hand", tuple(links), tuple(joints), controllers=(control,), joint_states_topic=topic)


def test_friction_holds_a_joint_until_it_is_pulled_harder(open_world, parts, advance):
    held, moved = (open_world(sliding(parts, 5.0, pull)) for pull in (4.5, 7.0))
    for world in (held, moved):
        advance(world, 2.0)
    assert held.joint_states("hanging").positions == pytest.approx([0.0], abs=2e-3)
    states = moved.joint_states("hanging")
    assert states.velocities == pytest.approx([(7.0 - 5.0) / MASS * 2.0], rel=5e-3)
    assert states.efforts == pytest.approx([0.0])  # what a motor does, and there is none


def test_a_load_cell_feels_what_friction_holds(open_world, parts, advance):
    model = parts.hanging("revolute", (0, 1, 0), com=(0.5, 0, 0))
    joints = tuple(replace(joint, friction=20.0) for joint in model.joints)
    bob = replace(model.links[0], sensors=(ForceTorque("cell", "/cell", 50.0, "joint"),))
    world = open_world(replace(model, links=(bob,), joints=joints))
    advance(world, 0.5)
    load = world.engine.joint_wrench("hanging", "joint")
    assert load.force == pytest.approx((0.0, 0.0, -MASS * 9.8), abs=0.02)
    assert load.torque == pytest.approx((0.0, MASS * 9.8 * 0.5, 0.0), abs=0.02)


def test_joints_follow_the_one_they_mimic(open_world, advance):
    world = open_world(gripper(Mimic("thumb_joint"), Mimic("thumb_joint", -2.0, 0.01)))
    world.advertise("/hand/thumb").publish(Float64(0.03))
    advance(world, 2.0)
    assert world.joint_states("hand").positions == pytest.approx([0.03, 0.03, -0.05], abs=2e-4)


def test_joints_that_follow_are_set_with_the_one_they_mimic(open_world, advance):
    """One follows a follower; no momentum of a correction moves them afterwards."""
    hand = replace(gripper(Mimic("thumb_joint", -1.0, 0.2), Mimic("finger_0_joint", 2.0)), controllers=())
    world = open_world(Scene((hand,), gravity=(0.0, 0.0, 0.0)))
    world.set_joints("hand", {"thumb_joint": 0.5})
    for _ in range(2):
        states = world.joint_states("hand")
        assert states.positions == pytest.approx([0.5, -0.3, -0.6], abs=1e-6)
        assert states.velocities == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
        advance(world, 0.2)
    world.set_joints("hand", {"finger_0_joint": 0.1})
    assert world.joint_states("hand").positions[1:] == pytest.approx([0.1, 0.2], abs=1e-6)


def test_a_leader_joint_feels_the_obstacles_of_its_follower(open_world, parts, advance):
    hand = gripper(Mimic("thumb_joint"))
    finger = replace(hand.links[2], collisions=(Collision("tip", Box((0.02, 0.02, 0.02))),))
    wall = parts.prop("wall", Box((0.1, 0.5, 0.5)), Pose((0.075, 0.1, 0.0)))  # 15 mm from the tip
    world = open_world(replace(hand, links=(*hand.links[:2], finger)), wall)
    world.advertise("/hand/thumb").publish(Float64(0.1))
    advance(world, 1.0)
    assert world.joint_states("hand").positions == pytest.approx([0.015, 0.015], abs=2e-3)


def test_a_snapshot_goes_on_bit_for_bit_with_followers_and_friction(open_world, advance):
    hand = gripper(Mimic("thumb_joint", 0.5))
    joints = tuple(replace(joint, friction=0.01) for joint in hand.joints)
    world = open_world(replace(hand, joints=joints))
    world.advertise("/hand/thumb").publish(Float64(0.04))
    advance(world, 0.05)
    kept = world.snapshot()
    ends = []
    for _ in range(2):
        advance(world, 0.1)
        ends.append(world.joint_states("hand"))
        world.restore(kept)
    assert np.array_equal(ends[0].positions, ends[1].positions)
    assert np.array_equal(ends[0].velocities, ends[1].velocities)
    assert np.array_equal(ends[0].efforts, ends[1].efforts)


def test_the_leader_of_a_joint_must_be_there(open_world, golden: Golden):
    with golden.raises(SceneError, match="'thum_joint'"):
        open_world(gripper(Mimic("thum_joint")))


def test_limp_joints_in_series_keep_to_the_one_they_mimic(open_world, advance):
    """Rods that fall together, like the links of a finger."""
    arm = chain()
    joints = [
        replace(joint, mimic=Mimic(arm.joints[0].name, 1.0) if number else None)
        for number, joint in enumerate(arm.joints)
    ]
    limp = replace(arm, joints=tuple(joints), controllers=(), trajectory_controllers=())
    world = open_world(Scene((limp,), gravity=(0.0, 0.0, -GRAVITY)))
    furthest, gap = 0.0, 0.0
    for _ in range(30):
        advance(world, 0.02)
        first, *others = world.joint_states(arm.name).positions.tolist()
        furthest, gap = max(furthest, abs(first)), max(gap, *(abs(each - first) for each in others))
    assert furthest > 0.3
    assert gap < 0.005
