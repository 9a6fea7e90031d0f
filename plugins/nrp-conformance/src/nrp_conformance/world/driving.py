"""Contract: a robot follows commands, reports its odometry, and stops without commands."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import pytest

from nrp_conformance.world.kit import (
    DRIVE_TIMEOUT_S,
    WHEEL_RADIUS,
    WorldKit,
    at,
    floor,
    prop,
    robot,
    twist,
)
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.rigid import Pose
from nrp_core.world import Box, PlanarMove, World

SLIP = 0.05
"""The share of a commanded distance that may be lost to tyres and acceleration."""


class DrivingTests(WorldKit):
    """Commands and odometry."""

    @pytest.mark.parametrize("yaw", [0.0, pi / 2, -2.0])
    def test_forward_is_along_the_x_axis_of_the_robot(self, yaw: float) -> None:
        world = self.open(floor(), robot(yaw=yaw))
        start = self._pose(world)
        self.drive(world, 0.5, 0.0, 2.0)
        moved = start.inverse() @ self._pose(world)
        assert moved.position[0] == pytest.approx(1.0, rel=SLIP)
        assert moved.position[1] == pytest.approx(0.0, abs=0.02)
        assert moved.yaw == pytest.approx(0.0, abs=0.02)

    @pytest.mark.parametrize("speed", [-0.5, 0.1, 1.0])
    def test_the_commanded_speed_is_reached(self, speed: float) -> None:
        world = self.open(floor(), robot())
        self.drive(world, speed, 0.0, 1.0)
        assert world.model_motion("robot").linear[0] == pytest.approx(speed, rel=SLIP)

    @pytest.mark.parametrize("turn", [0.8, -0.8])
    def test_a_positive_turn_is_to_the_left(self, turn: float) -> None:
        world = self.open(floor(), robot())
        self.drive(world, 0.0, turn, 2.0)
        assert self._pose(world).yaw == pytest.approx(2.0 * turn, rel=2 * SLIP)
        assert world.model_motion("robot").angular[2] == pytest.approx(turn, rel=2 * SLIP)

    def test_a_curve_is_a_circle_of_speed_over_turn(self) -> None:
        world = self.open(floor(), robot())
        self.drive(world, 0.5, 0.5, 2.0)
        x, y, _ = self._pose(world).position
        assert (x, y) == pytest.approx((sin(1.0), 1 - cos(1.0)), abs=0.08)

    def test_odometry_reports_the_displacement_since_the_start(self) -> None:
        world = self.open(floor(), robot(x=1.0, y=2.0, yaw=pi / 2))
        start = self._pose(world)
        subscription = world.subscribe("/robot/odom")
        self.drive(world, 0.5, 0.4, 1.0)
        assert subscription.latest is not None
        reported, moved = subscription.latest.message.pose.pose, start.inverse() @ self._pose(world)
        position = (reported.position.x, reported.position.y, reported.position.z)
        assert position == pytest.approx(moved.position, abs=0.01)
        orientation = reported.orientation
        found = Pose(position, (orientation.x, orientation.y, orientation.z, orientation.w))
        assert found.yaw == pytest.approx(moved.yaw, abs=0.01)

    def test_odometry_reports_the_velocity_in_the_robots_own_frame(self) -> None:
        world = self.open(floor(), robot(yaw=pi / 2))
        subscription = world.subscribe("/robot/odom")
        self.drive(world, 0.5, 0.3, 1.0)
        assert subscription.latest is not None
        moving = subscription.latest.message.twist.twist
        assert moving.linear.x == pytest.approx(0.5, rel=SLIP)
        assert moving.linear.y == pytest.approx(0.0, abs=0.05)
        assert moving.angular.z == pytest.approx(0.3, rel=2 * SLIP)

    def test_a_velocity_is_the_change_of_the_position(self) -> None:
        world = self.open(floor(), robot(yaw=2.0))
        self.drive(world, 0.5, 0.3, 1.0)
        before, start_ns = world.model_motion("robot"), world.now_ns
        self.run(world, start_ns * 1e-9 + 5 * self.step_s)
        after, dt = world.model_motion("robot"), (world.now_ns - start_ns) * 1e-9
        pairs = zip(after.pose.position, before.pose.position, strict=True)
        assert [(a - b) / dt for a, b in pairs] == pytest.approx(before.linear, abs=0.03)
        turned = (before.pose.inverse() @ after.pose).yaw
        assert turned / dt == pytest.approx(before.angular[2], abs=0.03)

    def test_wheels_turn_in_the_direction_in_which_they_roll(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), robot())
        subscription = world.subscribe("/robot/wheel_speeds")
        self.drive(world, 0.5, 0.6, 1.0)
        assert subscription.latest is not None
        speeds = subscription.latest.message
        assert speeds.front_left == pytest.approx(speeds.back_left, abs=0.05)
        assert speeds.front_left < 0.5 < speeds.front_right
        self.drive(world, 0.5, 0.0, 1.0)
        joints = world.joint_states("robot")
        assert joints.velocities == pytest.approx([0.5 / WHEEL_RADIUS] * 4, rel=2 * SLIP)

    def test_a_command_holds_until_the_timeout_and_then_the_robot_stops(self) -> None:
        world = self.open(floor(), robot())
        world.advertise("/robot/cmd_vel").publish(twist(0.5, 0.0))
        self.run(world, DRIVE_TIMEOUT_S - 0.02)
        assert world.model_motion("robot").linear[0] == pytest.approx(0.5, rel=3 * SLIP)
        self.run(world, DRIVE_TIMEOUT_S + 1.0)
        assert world.model_motion("robot").linear[0] == pytest.approx(0.0, abs=0.02)

    def test_a_command_of_zero_stops(self) -> None:
        world = self.open(floor(), robot())
        self.drive(world, 0.5, 0.0, 0.5)
        self.drive(world, 0.0, 0.0, 1.0)
        assert world.model_motion("robot").linear[0] == pytest.approx(0.0, abs=0.02)

    def test_several_robots_each_follow_their_own_commands(self) -> None:
        world = self.open(floor(), robot("a"), robot("b", y=3.0), robot("c", y=-3.0))
        commands = {name: world.advertise(f"/{name}/cmd_vel") for name in ("a", "b", "c")}
        odometries = {name: world.subscribe(f"/{name}/odom") for name in commands}
        for step in range(50):
            commands["a"].publish(twist(0.5, 0.0))
            commands["b"].publish(twist(0.0, 0.8))
            self.run(world, (step + 1) / 50)
        still, moved, turned = (world.model_motion(name).pose for name in ("c", "a", "b"))
        assert still.position[:2] == pytest.approx((0.0, -3.0), abs=0.01)
        assert moved.position[:2] == pytest.approx((0.5, 0.0), abs=0.06)
        assert turned.position[:2] == pytest.approx((0.0, 3.0), abs=0.06)
        assert turned.yaw == pytest.approx(0.8, abs=0.12)
        reported = {
            name: odometry.latest.message.twist.twist
            for name, odometry in odometries.items()
            if odometry.latest
        }
        assert [reported[name].linear.x for name in "abc"] == pytest.approx([0.5, 0.0, 0.0], abs=0.05)
        assert [reported[name].angular.z for name in "abc"] == pytest.approx([0.0, 0.8, 0.0], abs=0.08)
        if self.capabilities.dynamics:
            rolling = [float(world.joint_states(name).velocities.mean()) for name in "abc"]
            assert rolling == pytest.approx([0.5 / WHEEL_RADIUS, 0.0, 0.0], abs=0.3)

    def test_a_planar_drive_can_move_sideways(self) -> None:
        base = prop("robot", Box((0.6, 0.4, 0.2)), at(0, 0, 0.1, yaw=pi / 2), mass=5.0)
        world = self.open(floor(), replace(base, drives=(PlanarMove("drive", "/robot/cmd_vel"),)))
        world.advertise("/robot/cmd_vel").publish(Twist(Vector3(0.3, 0.2)))
        self.run(world, 1.0)
        x, y, _ = self._pose(world).position
        assert (x, y) == pytest.approx((-0.2, 0.3), abs=0.03)

    def _pose(self, world: World) -> Pose:
        return world.model_motion("robot").pose
