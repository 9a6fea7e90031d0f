"""Contract: robots move exactly as they are commanded, as far as there is room.

The tolerances follow from the declaration: a command acts from the next step on and an engine integrates with
its step, so a robot may be displaced by its way in two steps; tyres may lose the declared ``slip``. Bodies in
contact may penetrate by a hundredth of their size, where forces hold them apart.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin

import pytest

from nrp_core.clock import seconds
from nrp_core.conformance.world.kit import WorldKit, twist
from nrp_core.conformance.world.scenes import LENGTH, TRACK, WHEEL_WIDTH, at, floor, prop, robot
from nrp_core.world.drives.mecanum import PlanarMove
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Box

PENETRATION = 0.01
"""The share of a body's size by which forces may let it penetrate another one."""


class ExactMotionTests(WorldKit):
    """The motion of robots against the motion that was commanded."""

    def lost(self, velocity: float, t_s: float) -> float:
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
        assert pose.position[:2] == pytest.approx(arc, abs=self.lost(forward, t_s))
        assert pose.yaw == pytest.approx(angle, abs=self.lost(turn, t_s))

    def test_a_planar_drive_moves_exactly_as_commanded(self) -> None:
        base = prop("robot", Box((0.6, 0.4, 0.2)), at(0, 0, 0.1, yaw=pi / 2), mass=5.0)
        world = self.open(floor(), replace(base, drives=(PlanarMove("drive", "/robot/cmd_vel"),)))
        world.advertise("/robot/cmd_vel").publish(Twist(Vector3(0.3, 0.2)))
        self.run(world, 1.0)
        t_s, (x, y, _) = seconds(world.now_ns), world.model_motion("robot").pose.position
        assert y == pytest.approx(0.3 * t_s, abs=self.lost(0.3, t_s))
        assert x == pytest.approx(-0.2 * t_s, abs=self.lost(0.2, t_s))

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
        assert (x, y) == pytest.approx((1.8, 0.5 * seconds(world.now_ns)), abs=self.lost(0.5, 4.0))

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
