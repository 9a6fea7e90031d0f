"""Capability: each body has the shapes, poses, masses and joints that the scene defines."""

from __future__ import annotations

from dataclasses import replace
from math import exp, pi

import pytest

from nrp_core.conformance.world.changing import INERTIA, arm
from nrp_core.conformance.world.kit import GRAVITY, WorldKit
from nrp_core.conformance.world.scenes import at, floor, pendulum, prop, rubbing
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.rigid import Pose, Vector, Wrench
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Link,
    Model,
    Sphere,
)  # fmt: skip

LYING = Pose.from_rpy((0.1, 0.0, -0.2), pi / 2, 0.0, 0.0)
SHAPES: list[tuple[Geometry, Pose, float]] = [
    (Box((0.2, 0.3, 0.6)), Pose(), 0.3),
    (Cylinder(0.1, 0.6), Pose(), 0.3),
    (Capsule(0.1, 0.4), Pose(), 0.3),
    (Sphere(0.3), Pose(), 0.3),
    (Cylinder(0.1, 0.6), LYING, 0.3),
    (Box((0.6, 0.3, 0.2)), LYING, 0.35),
]
"""Shapes, their pose in the link, and the height of the link when they stand on the ground."""
MOMENTS = (0.2, 0.3, 0.4)


class BodyTests(WorldKit):
    """The engine moves the bodies that the file describes."""

    level = "capability"

    @pytest.mark.parametrize(("geometry", "pose", "height"), SHAPES)
    def test_a_shape_has_its_size_and_place(self, geometry: Geometry, pose: Pose, height: float) -> None:
        """The body is lowered along a rail until it touches the ground."""
        self.require("dynamics")
        link = Link("link", inertial=Inertial(1.0), collisions=(Collision("shape", geometry, pose),))
        rail = Joint("rail", "prismatic", "world", "link", axis=(0.0, 0.0, 1.0), damping=20.0)
        world = self.open(floor(), Model("lift", (link,), (rail,), pose=at(0, 0, height + 0.1)))
        self.run(world, 1.0)
        assert 0.1 + float(world.joint_states("lift").positions[0]) == pytest.approx(0.0, abs=0.01)

    def test_a_sliding_joint_is_held_by_its_friction(self) -> None:
        """Gravity is tilted so that one box holds and the other one slides."""
        self.require("dynamics")
        boxes = [
            rubbing(prop(name, Box((0.4, 0.4, 0.2)), at(0, y, 0.1), mass=1.0), friction)
            for name, y, friction in (("rough", 1.0, 0.8), ("smooth", -1.0, 0.1))
        ]
        ground = rubbing(floor(), 1.0)
        pull = 0.4 * GRAVITY
        world = self.open(ground, *boxes, gravity=(pull, 0.0, -GRAVITY))
        self.run(world, 1.0)
        rough, smooth = (world.model_motion(name) for name in ("rough", "smooth"))
        assert rough.pose.position[0] == pytest.approx(0.0, abs=0.05)
        assert smooth.linear[0] == pytest.approx(pull - 0.1 * GRAVITY, rel=0.1)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_a_torque_turns_by_the_moment_about_its_axis_of_the_world(self, axis: int) -> None:
        """The body is rotated by 90 degrees, so that its x axis points along the world's y axis."""
        self.require("joint_control")
        box = prop("box", Box((0.2, 0.2, 0.2)), at(0, 0, 5, yaw=pi / 2), mass=2.0)
        inertial = Inertial(2.0, inertia=(*MOMENTS, 0.0, 0.0, 0.0))
        link = replace(box.links[0], inertial=inertial)
        world = self.open(replace(box, links=(link,)), gravity=(0.0, 0.0, 0.0))
        along: Vector = tuple(0.1 * (i == axis) for i in range(3))  # type: ignore[assignment]
        world.engine.set_wrench("box", "link", Wrench(force=along, torque=along))
        self.run(world, 0.2)
        moment = (MOMENTS[1], MOMENTS[0], MOMENTS[2])[axis]
        motion, t_s = world.model_motion("box"), world.now_ns * 1e-9
        assert motion.angular == pytest.approx([a * t_s / moment for a in along], abs=2e-3)
        assert motion.linear == pytest.approx([a * t_s / 2.0 for a in along], abs=2e-3)

    def test_a_joint_is_slowed_by_its_damping(self) -> None:
        self.require("joint_control")
        model = arm("effort")
        joint = replace(model.joints[0], kind="continuous", damping=1.0)
        world = self.open(replace(model, joints=(joint,)), gravity=(0.0, 0.0, 0.0))
        world.advertise("/arm/cmd").publish(Float64(0.5))
        self.run(world, 1.0)
        expected = 0.5 * (1 - exp(-1.0 / INERTIA))
        assert world.joint_states("arm").velocities[0] == pytest.approx(expected, rel=0.03)

    def test_a_joint_limits_the_effort_of_commands(self) -> None:
        self.require("joint_control")
        model = arm("effort")
        world = self.open(
            replace(model, joints=(replace(model.joints[0], effort=0.5),)), gravity=(0.0, 0.0, 0.0)
        )
        world.advertise("/arm/cmd").publish(Float64(-5.0))
        self.run(world, 0.5)
        assert world.joint_states("arm").velocities[0] == pytest.approx(-0.25 / INERTIA, rel=0.02)

    def test_a_joint_stops_at_its_lower_limit(self) -> None:
        self.require("dynamics")
        world = self.open(pendulum(), gravity=(0.0, 0.0, GRAVITY))
        self.run(world, 3.0)
        assert world.joint_states("pendulum").positions == pytest.approx([-0.5], abs=0.03)

    def test_an_axis_is_given_in_the_frame_of_its_joint(self) -> None:
        """The joint's frame is rotated about z: its x axis is the model's y axis."""
        self.require("dynamics")
        model = pendulum()
        turned = replace(model.joints[0], pose=Pose.from_rpy((0, 0, 0), 0.0, 0.0, pi / 2), axis=(1, 0, 0))
        world = self.open(replace(model, joints=(turned,)))
        self.run(world, 0.2)
        angle = float(world.joint_states("pendulum").positions[0])
        assert angle > 0.05
        assert world.model_motion("pendulum").pose.rpy[1] == pytest.approx(angle, abs=1e-6)

    def test_a_link_turns_about_axes_of_the_world(self) -> None:
        """The link is rotated about x in its model: the axis of its joint is its own -z axis."""
        self.require("dynamics")
        self.require("links")
        model = pendulum()
        (bob,) = model.links
        assert bob.inertial is not None
        lying = Pose.from_rpy((0, 0, 0), pi / 2, 0.0, 0.0)
        inertial = replace(bob.inertial, pose=lying.inverse() @ bob.inertial.pose)
        world = self.open(replace(model, links=(replace(bob, pose=lying, inertial=inertial),)))
        self.run(world, 0.2)
        velocity = float(world.joint_states("pendulum").velocities[0])
        assert velocity > 0.5
        assert world.link_motion("pendulum", "bob").angular == pytest.approx((0, velocity, 0), abs=1e-3)
