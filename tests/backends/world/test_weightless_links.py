"""Links that gravity does not pull (``<gravity>0</gravity>``), on both engines."""

from __future__ import annotations

import pytest

from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.scene.model import Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose

GRAVITY = 9.8
INERTIA = (0.1, 0.1, 0.1, 0.0, 0.0, 0.0)


def body(name: str, mass: float, *, gravity: bool, at: Pose = Pose()) -> Link:
    return Link(name, at, Inertial(mass, Pose((0.2, 0.0, 0.0)), INERTIA), gravity=gravity)


@pytest.mark.parametrize(("light", "heavy"), [(1.0, 0.0), (2.0, 2.0), (3.0, 1.0), (0.0, 1.0)])
def test_a_body_falls_by_the_share_of_its_mass_that_gravity_pulls(open_world, advance, light, heavy):
    links = [body(name, mass, gravity=pulled) for name, mass, pulled in
             (("light", light, False), ("heavy", heavy, True)) if mass]  # fmt: skip
    joints = [Joint("held", "fixed", links[0].name, each.name) for each in links[1:]]
    world = open_world(Model("thing", tuple(links), tuple(joints), pose=Pose((0.0, 0.0, 5.0))))
    advance(world, 0.5)
    motion = world.link_motion("thing", links[0].name)
    share = heavy / (light + heavy)
    assert motion.linear[2] == pytest.approx(-GRAVITY * share * 0.5, abs=1e-6)
    assert motion.pose.position[2] == pytest.approx(5.0 - GRAVITY * share * 0.125, abs=0.01)
    assert motion.angular == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("held", [False, True])
def test_gravity_pulls_at_the_centre_of_the_links_that_it_pulls(open_world, advance, held):
    """A dumbbell, one end of which is weightless: ``torque / inertia`` about its middle."""
    ends = (body("heavy", 1.0, gravity=True), body("light", 1.0, gravity=False, at=Pose((-0.4, 0.0, 0.0))))
    joints = [Joint("bar", "fixed", "heavy", "light")]
    if held:
        joints.append(Joint("j", "continuous", "world", "heavy", axis=(0.0, 1.0, 0.0)))
    world = open_world(Model("dumbbell", ends, tuple(joints), pose=Pose((0.0, 0.0, 5.0))))
    advance(world, 0.02)
    rate = 1.0 * GRAVITY * 0.2 / (2 * 0.1 + 2 * 1.0 * 0.2**2)
    assert world.link_motion("dumbbell", "heavy").angular[1] == pytest.approx(rate * 0.02, rel=1e-3)


def test_a_weightless_arm_stays_where_it_is_and_another_one_falls(open_world, advance):
    def arm(name: str, y: float, *, gravity: bool) -> Model:
        joint = Joint("j", "continuous", "world", "rod", axis=(0.0, 1.0, 0.0))
        rod = body("rod", 1.0, gravity=gravity)
        return Model(name, (rod,), (joint,), pose=Pose((0.0, y, 2.0)), joint_states_topic=f"/{name}")

    world = open_world(arm("light", 0.0, gravity=False), arm("heavy", 1.0, gravity=True))
    advance(world, 0.3)
    assert world.joint_states("light").positions[0] == pytest.approx(0.0, abs=1e-6)
    assert world.joint_states("heavy").positions[0] > 0.1


def test_gravity_that_changes_does_not_pull_it_either(open_world, advance):
    world = open_world(Model("thing", (body("link", 2.0, gravity=False),), pose=Pose((0.0, 0.0, 5.0))))
    world.call("/gazebo/set_physics_properties", gravity=Vector3(0.0, 0.0, -3.0))
    advance(world, 0.2)
    assert world.link_motion("thing", "link").pose.position == pytest.approx((0.0, 0.0, 5.0), abs=1e-9)
