"""Capability: bodies have the shapes, masses and joints of the scene, and joints move by mechanics."""

from __future__ import annotations

from dataclasses import replace
from math import exp, pi, sqrt

import numpy as np
import pytest

from nrp_conformance.world.capability import INERTIA, arm
from nrp_conformance.world.kit import GRAVITY, WorldKit, at, floor, pendulum, prop, rubbing
from nrp_core.errors import CapabilityError
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.rigid import Pose, Vector, Wrench, rotation_by
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    JointController,
    Link,
    Mimic,
    Model,
    Sphere,
    World,
)

BOB_KG, ROD_M, MOMENT = 2.0, 0.5, 0.02
BOB_INERTIA = MOMENT + BOB_KG * ROD_M**2
BOB = Inertial(BOB_KG, Pose((0.0, 0.0, -ROD_M)), (MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0))
WHILE_S = 0.2
CARRIER = Inertial(1e-9, inertia=(1e-12, 1e-12, 1e-12, 0.0, 0.0, 0.0))
SIDEWAYS = (0.6, -0.4, 0.0)
"""A gravity, m/s^2, that accelerates a hanging bob towards x and to the right."""
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


def hanging(*joints: Joint, between: tuple[Link, ...] = ()) -> Model:
    """Return a bob that hangs on joints at height 2."""
    return Model("bob", (Link("bob", inertial=BOB), *between), joints, pose=at(0, 0, 2))


def ball() -> Model:
    """Return a bob that hangs on a ball joint."""
    return hanging(Joint("hip", "ball", "world", "bob"))


def gears() -> Model:
    """Return two masses on rails along x; the second moves back twice as far as the first moves ahead."""
    links = [Link(name, inertial=Inertial(mass)) for name, mass in (("first", 1.0), ("second", 0.1))]
    rails = [Joint(f"{link.name}_rail", "prismatic", "world", link.name, axis=(1, 0, 0)) for link in links]
    rails[1] = replace(rails[1], mimic=Mimic("first_rail", -2.0, 0.05))
    return Model("gears", tuple(links), tuple(rails), pose=at(0, 0, 1))


class JointTests(WorldKit):
    """The motion that joints allow, and the loads that they carry."""

    level = "capability"

    def test_a_light_link_between_two_joints_lets_its_child_turn_about_both(self) -> None:
        """A universal joint: the link between its axes has almost no mass."""
        self.require("dynamics")
        first = Joint("first", "continuous", "world", "cross", axis=(1, 0, 0))
        second = Joint("second", "continuous", "cross", "bob", axis=(0, 1, 0))
        world = self.open(
            hanging(first, second, between=(Link("cross", inertial=CARRIER),)), gravity=SIDEWAYS
        )
        _, rates = self._after_a_while(world, "bob")
        assert rates == pytest.approx({"first": -self._rate(0.4), "second": -self._rate(0.6)}, rel=0.05)

    def test_a_spring_swings_about_its_equilibrium(self) -> None:
        """After half a period its displacement from equilibrium is the opposite of the initial one.

        A first-order method damps a swing of the frequency w like a damping ratio of ``w step / 2``.
        """
        self.require("dynamics")
        stiffness, rest = 50.0, 0.1
        spring = Joint("rail", "prismatic", "world", "bob", axis=(0, 0, 1), stiffness=stiffness, rest=rest)
        world = self.open(hanging(spring))
        frequency = sqrt(stiffness / BOB_KG)
        self.run(world, pi / frequency)
        carries = rest - BOB_KG * GRAVITY / stiffness
        damped = abs(carries) * pi * frequency * self.step_s / 2
        assert world.joint_states("bob").positions == pytest.approx([2 * carries], abs=damped)

    def test_a_ball_joint_turns_about_any_axis(self) -> None:
        self._require_balls()
        world = self.open(ball(), gravity=SIDEWAYS)
        angles, rates = self._after_a_while(world, "bob")
        expected = {"hip_x": -self._rate(0.4), "hip_y": -self._rate(0.6), "hip_z": 0.0}
        assert rates == pytest.approx(expected, rel=0.05, abs=1e-4)
        half_s = world.now_ns * 1e-9 / 2
        assert angles == pytest.approx({name: rate * half_s for name, rate in rates.items()}, abs=2e-3)

    def test_the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child(self) -> None:
        """The bob is first rotated about the vertical, by a fifth of a turn."""
        self._require_balls()
        self.require("changes")
        world = self.open(ball(), gravity=SIDEWAYS)
        world.set_joints("bob", {"hip_z": 0.4 * pi})
        states = world.joint_states("bob")
        angles = dict(zip(states.names, states.positions.tolist(), strict=True))
        assert angles == pytest.approx({"hip_x": 0.0, "hip_y": 0.0, "hip_z": 0.4 * pi}, abs=1e-6)
        _, rates = self._after_a_while(world, "bob")
        motion = world.model_motion("bob")
        assert motion.angular == pytest.approx((-self._rate(0.4), -self._rate(0.6), 0.0), rel=0.03, abs=1e-3)
        along = zip(("hip_x", "hip_y", "hip_z"), motion.pose.rotate_back(motion.angular), strict=True)
        assert rates == pytest.approx(dict(along), abs=1e-6)

    def test_a_ball_joint_follows_orientations(self) -> None:
        """It arrives within half a second and holds its pose: the torque equals that of gravity."""
        self._require_balls()
        self.require("ball_control")
        turn = (0.8, -0.6, 0.5)
        led = replace(ball(), controllers=(JointController("hip", "position", "/bob/hip", None),))
        world = self.open(led)
        world.advertise("/bob/hip").publish(Quaternion(*rotation_by(turn)))
        angles, _ = self._after_a_while(world, "bob", 0.5)
        assert list(angles.values()) == pytest.approx(turn, abs=0.01)
        self.run(world, 0.5)
        assert world.joint_states("bob").positions == pytest.approx(turn, abs=1e-3)
        centre = BOB.pose.position
        down = Pose(orientation=rotation_by(turn)).rotate_back((0.0, 0.0, -GRAVITY * BOB_KG))
        held = -np.cross(centre, down)
        assert world.joint_states("bob").efforts == pytest.approx(held, rel=0.02, abs=0.02)

    def test_a_mimic_joint_follows_its_leader(self) -> None:
        """By the law of the lever, the first mass carries four times the second one."""
        self._require_coupled()
        pull = 1.4
        world = self.open(gears(), gravity=(pull, 0.0, 0.0))
        places, rates = self._after_a_while(world, "gears", 0.5)
        t_s = world.now_ns * 1e-9
        assert rates["first_rail"] == pytest.approx(pull * (1.0 - 2 * 0.1) / (1.0 + 4 * 0.1) * t_s, rel=0.05)
        assert rates["second_rail"] == pytest.approx(-2 * rates["first_rail"], rel=0.02)
        assert places["second_rail"] == pytest.approx(0.05 - 2 * places["first_rail"], abs=2e-3)

    def test_undeclared_ball_joints_are_refused(self) -> None:
        self.require("dynamics")
        if self.capabilities.ball_joints:
            assert set(self.open(ball()).joint_states("bob").names) == {"hip_x", "hip_y", "hip_z"}
            return
        with pytest.raises(CapabilityError, match="bob/hip"):
            self.open(ball())

    def test_undeclared_mimic_joints_are_refused(self) -> None:
        self.require("dynamics")
        if self.capabilities.coupled_joints:
            assert self.open(gears()).capabilities.coupled_joints
            return
        with pytest.raises(CapabilityError, match="gears/second_rail"):
            self.open(gears())

    def _after_a_while(
        self, world: World, model: str, t_s: float = WHILE_S
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Return the positions and velocities of a model's joints at a time, by name."""
        self.run(world, t_s)
        states = world.joint_states(model)
        positions, velocities = (
            dict(zip(states.names, values.tolist(), strict=True))
            for values in (states.positions, states.velocities)
        )
        return positions, velocities

    def _rate(self, pull: float) -> float:
        """Return the bob's angular velocity after ``WHILE_S`` of the acceleration ``pull``, rad/s."""
        return BOB_KG * pull * ROD_M / BOB_INERTIA * self.grid_ns(WHILE_S) * 1e-9

    def _require_balls(self) -> None:
        self.require("dynamics")
        self.require("ball_joints")

    def _require_coupled(self) -> None:
        self.require("dynamics")
        self.require("coupled_joints")


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
        """Tilted gravity lets one box hold and the other one slide."""
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
