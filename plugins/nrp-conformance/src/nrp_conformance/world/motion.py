"""Contract: SI units, x forward, y left, z up, quaternions x, y, z, w; bodies fall, rest and push.

Robots move exactly as they are commanded, as far as there is room. The tolerances follow from the
declaration: a command acts from the next step on and an engine integrates with its step, so a robot may be
displaced by its way in two steps, and a freely falling body by ``g t step``. Tyres may lose the declared
``slip``. Bodies in contact may penetrate by a hundredth of their size, where forces hold them apart.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin, sqrt

import pytest

from nrp_conformance.world.kit import (
    GRAVITY,
    LENGTH,
    TRACK,
    WHEEL_WIDTH,
    WorldKit,
    at,
    floor,
    pendulum,
    prop,
    robot,
    states,
    twist,
)
from nrp_core.clock import seconds
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world import Box, PlanarMove, Sphere

PENETRATION = 0.01
"""The share of a body's size by which forces may let it penetrate another one."""
HALF = sqrt(0.5)
AXES: list[tuple[Vector, Vector]] = [
    ((pi / 2, 0.0, 0.0), (1, 0, 0)), ((0.0, pi / 2, 0.0), (0, 1, 0)), ((0.0, 0.0, pi / 2), (0, 0, 1)),
]  # fmt: skip


class ExactMotionTests(WorldKit):
    """The motion of robots against the motion that was commanded."""

    def allowed_loss(self, velocity: float, t_s: float) -> float:
        """Return the part of a way (m, rad) that steps and tyres may lose."""
        return abs(velocity) * (2 * self.step_s + self.capabilities.slip * t_s)

    @pytest.mark.parametrize(
        ("forward", "turn"), [(0.5, 0.4), (-0.5, 0.4), (0.4, -1.2), (2.5, 0.5), (0.02, 0.02)]
    )
    def test_a_curve_is_exactly_the_commanded_arc(self, forward: float, turn: float) -> None:
        world = self.open(floor(), robot())
        self.drive(world, forward, turn, 2.0)
        pose, t_s = world.model_motion("robot").pose, seconds(world.now_ns)
        angle = turn * t_s
        arc = forward / turn * sin(angle), forward / turn * (1 - cos(angle))
        assert pose.position[:2] == pytest.approx(arc, abs=self.allowed_loss(forward, t_s))
        assert pose.yaw == pytest.approx(angle, abs=self.allowed_loss(turn, t_s))

    def test_a_planar_drive_moves_exactly_as_commanded(self) -> None:
        base = prop("robot", Box((0.6, 0.4, 0.2)), at(0, 0, 0.1, yaw=pi / 2), mass=5.0)
        world = self.open(floor(), replace(base, drives=(PlanarMove("drive", "/robot/cmd_vel"),)))
        world.advertise("/robot/cmd_vel").publish(Twist(Vector3(0.3, 0.2)))
        self.run(world, 1.0)
        t_s, (x, y, _) = seconds(world.now_ns), world.model_motion("robot").pose.position
        assert y == pytest.approx(0.3 * t_s, abs=self.allowed_loss(0.3, t_s))
        assert x == pytest.approx(-0.2 * t_s, abs=self.allowed_loss(0.2, t_s))

    def test_velocities_are_those_of_the_arc(self) -> None:
        world = self.open(floor(), robot(yaw=1.0))
        self.drive(world, 0.5, 0.4, 1.0)
        motion = world.model_motion("robot")
        allowed = 2 * self.step_s + self.capabilities.slip
        assert hypot(*motion.linear[:2]) == pytest.approx(0.5, rel=allowed)
        assert motion.angular[2] == pytest.approx(0.4, rel=allowed)

    def test_a_robot_keeps_its_roll_and_pitch_on_level_ground(self) -> None:
        tilted = replace(robot(), pose=Pose.from_rpy((0.0, 0.0, 1.0), 0.2, -0.1, 0.5))
        world = self.open(floor(), tilted, gravity=(0.0, 0.0, 0.0))
        self.run(world, 0.2)
        assert world.model_motion("robot").pose.rpy == pytest.approx((0.2, -0.1, 0.5), abs=1e-6)

    def test_robots_do_not_pass_through_each_other(self) -> None:
        """The second robot is at rest; it stops the first one, or is pushed."""
        world = self.open(floor(), robot("robot"), robot("other", x=2.0))
        self.drive(world, 0.5, 0.0, 4.0)
        here, there = (world.model_motion(name).pose.position[0] for name in ("robot", "other"))
        assert here > 0.5
        assert there - here > LENGTH - self._deep(LENGTH)

    def test_the_velocity_at_a_wall_is_the_real_one(self) -> None:
        world = self.open(floor(), robot(), prop("wall", Box((0.2, 6.0, 2.0)), at(1.1, 0, 1)))
        self.drive(world, 0.5, 0.0, 2.0)
        before, start_ns = world.model_motion("robot"), world.now_ns
        self.drive(world, 0.5, 0.0, 0.1)
        after, dt = world.model_motion("robot"), seconds(world.now_ns - start_ns)
        real = (after.pose.position[0] - before.pose.position[0]) / dt
        assert after.linear[0] == pytest.approx(real, abs=0.01)

    @pytest.mark.parametrize(("bottom", "height", "stops"), [(0.0, 0.15, True), (3.0, 1.0, False)])
    def test_a_low_wall_stops_a_robot_and_a_bridge_does_not(
        self, bottom: float, height: float, stops: bool
    ) -> None:
        wall = prop("wall", Box((0.2, 6.0, height)), at(1.5, 0, bottom + height / 2))
        world = self.open(floor(), robot(), wall)
        self.drive(world, 0.5, 0.0, 4.5)
        x = world.model_motion("robot").pose.position[0]
        assert x < 1.5 if stops else x > 2.0

    @pytest.mark.parametrize("yaw", [0.0, pi / 2])
    def test_a_robot_ends_at_half_its_length_in_every_heading(self, yaw: float) -> None:
        place = at(1.5 * cos(yaw), 1.5 * sin(yaw), 1.0, yaw=yaw)
        world = self.open(floor(), robot(yaw=yaw), prop("wall", Box((0.2, 6.0, 2.0)), place))
        world.advertise("/robot/cmd_vel").publish(twist(0.5, 0.0))
        self.drive(world, 0.5, 0.0, 3.0)
        x, y, _ = world.model_motion("robot").pose.position
        expected = 1.4 - LENGTH / 2
        assert hypot(x, y) == pytest.approx(expected, abs=0.5 * self.step_s + self._deep(LENGTH / 2))

    def test_a_wall_at_an_angle_leaves_the_room_beside_it(self) -> None:
        """The robot drives past the middle of a wall, through the corner of the box around the wall."""
        wall = prop("wall", Box((6.0, 0.1, 2.0)), at(0, 3, 1, yaw=pi / 4))
        world = self.open(floor(), robot(x=1.8, yaw=pi / 2), wall)
        self.drive(world, 0.5, 0.0, 4.0)
        x, y, _ = world.model_motion("robot").pose.position
        assert (x, y) == pytest.approx((1.8, 0.5 * seconds(world.now_ns)), abs=self.allowed_loss(0.5, 4.0))

    def test_a_robot_in_a_corner_is_inside_neither_wall(self) -> None:
        walls = (
            prop("east", Box((0.2, 6.0, 2.0)), at(2, 0, 1)),
            prop("north", Box((6.0, 0.2, 2.0)), at(0, 2, 1)),
        )
        world = self.open(floor(), robot(yaw=pi / 4), *walls)
        self.drive(world, 0.5, 0.0, 5.0)
        pose = world.model_motion("robot").pose
        (x, y, _), across = pose.position, TRACK / 2 + WHEEL_WIDTH / 2
        c, s = abs(cos(pose.yaw)), abs(sin(pose.yaw))
        assert x + LENGTH / 2 * c + across * s <= 1.9 + self._deep(LENGTH)
        assert y + LENGTH / 2 * s + across * c <= 1.9 + self._deep(LENGTH)

    def _deep(self, size: float) -> float:
        """Return the allowed penetration of bodies of a size, m."""
        return PENETRATION * size if self.capabilities.dynamics else 1e-9


class MotionTests(WorldKit):
    """The motion of bodies."""

    @pytest.mark.parametrize("direction", [(0, 0, -1), (1, 0, 0), (0, -1, 0)])
    def test_a_body_falls_along_gravity_by_half_g_t_squared(self, direction: Vector) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.1), at(0, 0, 10), mass=1.0)
        world = self.open(ball, gravity=tuple(GRAVITY * d for d in direction))  # type: ignore[arg-type]
        self.run(world, 0.5)
        t = world.now_ns * 1e-9
        motion = world.model_motion("ball")
        fallen = [GRAVITY * t * t / 2 * d for d in direction]
        moved = [p - q for p, q in zip(motion.pose.position, (0, 0, 10), strict=True)]
        assert moved == pytest.approx(fallen, abs=GRAVITY * t * self.step_s)
        speed = [GRAVITY * t * d for d in direction]
        assert motion.linear == pytest.approx(speed, abs=GRAVITY * self.step_s)

    def test_without_gravity_nothing_moves(self) -> None:
        self.require("dynamics")
        world = self.open(prop("ball", Sphere(0.1), at(0, 0, 1), mass=1.0), gravity=(0.0, 0.0, 0.0))
        self.run(world, 0.5)
        assert world.model_motion("ball").pose.position == pytest.approx((0, 0, 1), abs=1e-9)

    def test_a_body_at_rest_stays_at_rest(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), prop("box", Box((0.4, 0.4, 0.4)), at(1, -2, 0.2), mass=5.0))
        self.run(world, 1.0)
        motion = world.model_motion("box")
        assert motion.pose.position == pytest.approx((1, -2, 0.2), abs=4e-3)
        assert motion.linear == pytest.approx((0, 0, 0), abs=0.01)

    def test_a_static_body_does_not_fall(self) -> None:
        self.require("dynamics")
        world = self.open(
            prop("shelf", Box((1, 1, 0.1)), at(0, 0, 3)), prop("b", Sphere(0.1), at(5, 5, 9), mass=1)
        )
        self.run(world, 0.5)
        assert world.model_motion("shelf").pose.position == pytest.approx((0, 0, 3), abs=1e-9)

    @pytest.mark.parametrize(("rpy", "axis"), AXES)
    def test_a_quarter_turn_is_reported_as_x_y_z_w(self, rpy: Vector, axis: Vector) -> None:
        self.require("dynamics")
        turned = prop("box", Box((0.2, 0.3, 0.4)), Pose.from_rpy((0, 0, 5), *rpy), mass=1.0)
        world = self.open(turned, gravity=(0.0, 0.0, 0.0))
        expected = (*(HALF * a for a in axis), HALF)
        for _ in range(2):
            x, y, z, w = world.model_motion("box").pose.orientation
            sign = 1 if w > 0 else -1
            assert (sign * x, sign * y, sign * z, sign * w) == pytest.approx(expected, abs=1e-6)
            self.run(world, 0.02)

    def test_a_rotated_box_has_its_sides_in_the_right_places(self) -> None:
        """A long box, rotated upright, stands on its end: the height of its centre is half its length."""
        self.require("dynamics")
        upright = Pose.from_rpy((0, 0, 0.52), 0.0, pi / 2, 0.0)
        world = self.open(floor(), prop("box", Box((1.0, 0.5, 0.5)), upright, mass=4.0))
        self.run(world, 1.0)
        assert world.model_motion("box").pose.position[2] == pytest.approx(0.5, abs=0.01)

    def test_a_robot_pushes_obstacles(self) -> None:
        self.require("dynamics")
        box = prop("box", Box((0.3, 0.3, 0.3)), at(0.8, 0, 0.15), mass=0.5)
        world = self.open(floor(), robot(), box)
        self.drive(world, 0.5, 0.0, 1.5)
        x, y, _ = world.model_motion("box").pose.position
        robot_x = world.model_motion("robot").pose.position[0]
        assert x - robot_x == pytest.approx(0.55, abs=0.1)
        assert x > 0.95
        assert abs(y) < 0.15

    def test_a_wall_stops_a_robot(self) -> None:
        world = self.open(floor(), robot(), prop("wall", Box((0.2, 6, 2)), at(1.1, 0, 1)))
        self.drive(world, 0.6, 0.0, 2.0)
        assert world.model_motion("wall").pose.position == pytest.approx((1.1, 0, 1), abs=1e-9)
        assert 0.4 < world.model_motion("robot").pose.position[0] < 0.65

    def test_an_object_without_collision_shapes_does_not_stop_a_robot(self) -> None:
        ghost = prop("ghost", Box((0.2, 6, 2)), at(1.1, 0, 1), solid=False)
        world = self.open(floor(), robot(), ghost)
        self.drive(world, 0.6, 0.0, 2.0)
        assert world.model_motion("robot").pose.position[0] > 0.9

    def test_a_joint_turns_by_the_right_hand_about_its_axis_until_its_limit(self) -> None:
        """The mass is ahead of the joint; falling from x to -z is a positive rotation about y."""
        self.require("dynamics")
        world = self.open(pendulum())
        self.run(world, 0.1)
        falling = world.joint_states("pendulum")
        assert float(falling.positions[0]) > 0.01
        assert float(falling.velocities[0]) > 0.1
        pitch = world.model_motion("pendulum").pose.rpy[1]
        assert pitch == pytest.approx(float(falling.positions[0]), abs=1e-6)
        self.run(world, 3.0)
        assert world.joint_states("pendulum").positions == pytest.approx([0.6], abs=0.03)

    def test_distant_bodies_do_not_disturb_each_other(self) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.2), at(0, 0, 0.5), mass=1.0)
        alone = self.open(floor(), ball)
        together = self.open(floor(), ball, robot("robot", 9.0, 9.0))
        self.run(alone, 0.6)
        self.drive(together, 0.5, 1.0, 0.6)
        expected = alone.model_motion("ball").pose.position
        assert states(together)["ball"].pose.position == pytest.approx(expected, abs=5e-3)
