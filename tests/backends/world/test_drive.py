"""Wheel drives: the ideal unicycle on free ground, friction against obstacles, alike in both engines."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, degrees, hypot, pi, remainder, sin, tau

import numpy as np
import pytest
from golden import Golden
from hypothesis import example, given, settings
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Box, Scene
from nrp_core.scene.rigid import Pose


def unicycle(commands: list[tuple[float, float]], seconds: float) -> tuple[float, float, float]:
    """Return where the ideal unicycle gets to from the origin, driving on circles."""
    x = y = yaw = 0.0
    for v, w in commands:
        turned = yaw + w * seconds
        if abs(w) < 1e-9:
            x, y = x + v * cos(yaw) * seconds, y + v * sin(yaw) * seconds
        else:
            x, y = x + v / w * (sin(turned) - sin(yaw)), y - v / w * (cos(turned) - cos(yaw))
        yaw = turned
    return x, y, yaw


def off(pose: Pose, other: tuple[float, float, float]) -> tuple[float, float]:
    """Return how far apart two poses are, in m and degrees."""
    x, y, yaw = other
    return hypot(pose.position[0] - x, pose.position[1] - y), abs(degrees(remainder(pose.yaw - yaw, tau)))


@pytest.mark.parametrize(
    ("forward", "turn", "expected"),
    [(0.5, 0.0, (1.0, 0.0, 0.0)), (0.0, 0.5, (0.0, 0.0, 1.0)), (0.5, 0.5, (0.841471, 0.459698, 1.0))],
)
def test_a_command_is_carried_out(open_world, parts, driver, forward, turn, expected):
    world = open_world(parts.floor(), parts.husky())
    pose = driver(world).drive(forward, turn, 2.0)
    assert off(pose, expected) == pytest.approx((0, 0), abs=2e-3)


TOLERANCES = {"1 ms": 2e-3, "2 ms": 2e-3, "5 ms": 6e-3}
"""In m, by the time step."""


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("seed", "timestep"),
    [
        pytest.param(seed, timestep, marks=() if seed == number else pytest.mark.heavy)
        for number, timestep in enumerate(TOLERANCES)
        for seed in range(3)
    ],
)
def test_thirty_seconds_of_random_commands_end_where_the_unicycle_does(
    open_world, parts, driver, seed, timestep
):
    random = np.random.default_rng(seed)
    commands = list(zip(random.uniform(-1, 1, 30), random.uniform(-2, 2, 30), strict=True))
    world = open_world(parts.floor(), parts.husky(), timestep=timestep)
    robot = driver(world)
    for forward, turn in commands:
        pose = robot.drive(forward, turn, 1.0)
    distance, angle = off(pose, unicycle(commands, 1.0))
    assert distance < TOLERANCES[timestep]
    assert angle < 0.02


@settings(max_examples=8, deadline=None)
@given(commands=st.lists(st.tuples(st.floats(-1, 1), st.floats(-3, 3)), min_size=2, max_size=6))
@example(commands=[(0.75, -2.203125), (0.0, 0.0)])  # a hard stop: 0.01 degrees apart
def test_both_engines_end_at_the_same_pose(engines, parts, driver, commands):
    poses = []
    for backend in engines:
        scene = Scene((parts.floor(), parts.husky()))
        with backend.open(scene, seed=1, options=backend.options()) as world:
            robot = driver(world)
            for forward, turn in commands:
                pose = robot.drive(forward, turn, 0.5)
            poses.append(pose)
    first, second = poses
    distance, angle = off(first, (*second.position[:2], second.yaw))
    assert distance < 5e-3
    assert angle < 0.02  # degrees, as against the unicycle


def test_spinning_for_half_a_minute_the_robot_stays_where_it_is(open_world, parts, driver):
    world = open_world(parts.floor(), parts.husky())
    robot = driver(world)
    for _ in range(6):
        pose = robot.drive(0.0, 4.0, 5.0)
        assert hypot(*pose.position[:2]) < 0.005
        assert pose.position[2] == pytest.approx(parts.standing, abs=1e-3)


def test_the_wheels_spin_as_commanded(open_world, parts, driver):
    world = open_world(parts.floor(), parts.husky())
    driver(world).drive(0.5, 0.8, 1.0)
    joints = world.joint_states("husky")
    speeds = dict(zip(joints.names, joints.velocities * 0.17775, strict=True))
    assert speeds["back_left"] == pytest.approx(0.5 - 0.8 * 0.571 / 2, abs=2e-3)
    assert speeds["front_right"] == pytest.approx(0.5 + 0.8 * 0.571 / 2, abs=2e-3)


def test_dampers_of_wheels_brake_neither_the_wheels_nor_the_robot(open_world, parts, driver):
    robot = parts.husky()
    joints = tuple(replace(joint, damping=20.0) for joint in robot.joints)
    world = open_world(parts.floor(), replace(robot, joints=joints))
    pose = driver(world).drive(0.5, 0.8, 1.0)
    assert off(pose, unicycle([(0.5, 0.8)], 1.0)) == pytest.approx((0, 0), abs=0.2)
    speeds = world.joint_states("husky").velocities * 0.17775
    assert sorted(speeds[:2]) == pytest.approx([0.5 - 0.8 * 0.571 / 2, 0.5 + 0.8 * 0.571 / 2], abs=2e-3)


def test_a_wheel_joint_that_points_right_turns_in_the_opposite_direction(open_world, parts, driver):
    robot = parts.husky()
    joints = tuple(
        replace(joint, axis=(0.0, -1.0, 0.0)) if joint.name == "back_left" else joint
        for joint in robot.joints
    )
    world = open_world(parts.floor(), replace(robot, joints=joints))
    driver(world).drive(0.5, 0.0, 1.0)
    states = world.joint_states("husky")
    left, right = states.velocities[0], states.velocities[1]
    assert left == pytest.approx(-right, rel=1e-3)


def test_a_robot_whose_mass_is_off_centre_turns_about_its_wheels(open_world, parts, driver):
    robot = parts.husky()
    base = replace(robot.links[0], inertial=replace(robot.links[0].inertial, pose=Pose((0.1, 0.05, 0.2))))
    world = open_world(parts.floor(), replace(robot, links=(base, *robot.links[1:])))
    pose = driver(world).drive(0.0, 2.0, 10.0)
    assert hypot(*pose.position[:2]) < 0.005


def test_a_command_ends_after_its_timeout(open_world, parts, advance):
    world = open_world(parts.floor(), parts.husky())
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(1.0)))
    advance(world, 1.0)
    motion = world.model_motion("husky")
    assert motion.pose.position[0] == pytest.approx(0.1, abs=2e-3)
    assert motion.linear == pytest.approx((0, 0, 0), abs=1e-3)


def test_a_wall_stops_the_robot_which_neither_climbs_nor_tips(open_world, parts, driver):
    world = open_world(parts.floor(), parts.wall(2.0), parts.husky())
    robot = driver(world)
    robot.drive(1.0, 0.0, 2.0)
    for _ in range(5):
        pose = robot.drive(1.0, 0.0, 1.0)
        assert pose.position[0] == pytest.approx(2.0 - 1.0074 / 2, abs=0.02)
        assert pose.position[2] == pytest.approx(parts.standing, abs=5e-3)
        assert abs(pose.rpy[0]) + abs(pose.rpy[1]) < 0.01


@pytest.mark.parametrize(("heading", "turn"), [(0.0, 3.0), (0.4, -3.0), (0.9, 3.0)])
def test_a_robot_that_pushes_against_a_wall_can_turn_away(open_world, parts, driver, heading, turn):
    place = Pose.from_rpy((0, 0, parts.standing), 0, 0, heading)
    world = open_world(parts.floor(), parts.wall(1.5), parts.husky(pose=place))
    robot = driver(world)
    poses = [robot.drive(1.0, 0.0, 4.0), *(robot.drive(0.1, turn, 0.1) for _ in range(30))]
    turned = sum(remainder(after.yaw - before.yaw, tau) for before, after in pairwise(poses))
    assert abs(turned) > 0.75 * 3.0 * 3.0


def test_a_robot_in_a_corner_gets_out(open_world, parts, driver):
    post = parts.prop("post", Box((2.0, 0.18, 1.4)), Pose((0.0, 1.3, 0.7)))
    place = Pose.from_rpy((1.15, 0.0, parts.standing), 0, 0, pi / 2)
    world = open_world(parts.floor(), post, parts.husky(pose=place))
    robot = driver(world)
    robot.drive(1.0, 0.0, 3.0)
    start = robot.drive(0.0, -3.0, 1.0).yaw
    assert any(abs(remainder(robot.drive(0.0, -3.0, 0.1).yaw - start, tau)) > 2.5 for _ in range(60))


def test_a_pushed_box_moves_and_brakes_the_robot_little(open_world, parts, driver):
    box = parts.prop("box", Box((0.3, 0.3, 0.3)), Pose((1.0, 0, 0.15)), mass=3.0, friction=0.5)
    world = open_world(parts.floor(), box, parts.husky())
    pose = driver(world).drive(0.5, 0.0, 4.0)
    assert pose.position[0] == pytest.approx(2.0, abs=0.05)
    assert world.model_motion("box").pose.position[0] > pose.position[0] + 0.5


def test_weak_motors_push_weakly(open_world, parts, driver):
    strong = parts.husky()
    weak = replace(strong, drives=(replace(strong.drives[0], torque=2.0),))
    heavy = parts.prop("heavy", Box((0.5, 0.5, 0.5)), Pose((0.9, 0, 0.25)), mass=15.0)
    moved = []
    for robot in (strong, weak):
        world = open_world(parts.floor(), heavy, robot)
        driver(world).drive(0.5, 0.0, 3.0)
        moved.append(world.model_motion("heavy").pose.position[0] - 0.9)
    assert moved[0] > 0.8
    assert moved[1] < 0.1


def test_without_weight_there_is_no_traction(open_world, parts, driver):
    world = open_world(Scene((parts.floor(), parts.husky()), gravity=(0.0, 0.0, 0.0)))
    x, y, _ = driver(world).drive(1.0, 1.0, 0.5).position  # the wheels' reaction rocks it a little
    assert hypot(x, y) < 0.02


def test_robots_in_one_world_drive_on_their_own(open_world, parts, driver):
    home = {name: Pose((0, y, parts.standing)) for name, y in (("one", 0.0), ("two", 2.0), ("three", -2.0))}
    world = open_world(parts.floor(), *(parts.husky(name, pose) for name, pose in home.items()))
    one, two = driver(world, "one"), driver(world, "two")
    for _ in range(50):
        one._commands.publish(Twist(Vector3(0.5)))
        two.drive(0.0, 1.0, 0.02)
    at = {name: home[name].inverse() @ world.model_motion(name).pose for name in home}
    assert off(at["one"], (0.5, 0.0, 0.0)) == pytest.approx((0, 0), abs=2e-3)
    assert off(at["two"], (0.0, 0.0, 1.0)) == pytest.approx((0, 0), abs=2e-3)
    assert off(at["three"], (0.0, 0.0, 0.0)) == pytest.approx((0, 0), abs=1e-3)


def test_odometry_starts_at_the_robots_start(open_world, parts, driver):
    world = open_world(parts.floor(), parts.husky(pose=Pose.from_rpy((1, 2, parts.standing), 0, 0, 1.0)))
    odometry = world.subscribe("/husky/odom")
    driver(world).drive(0.5, 0.0, 1.0)
    message = odometry.latest.message
    assert message.pose.pose.position.x == pytest.approx(0.5, abs=2e-3)
    assert message.pose.pose.position.y == pytest.approx(0.0, abs=2e-3)
    assert message.twist.twist.linear.x == pytest.approx(0.5, abs=2e-3)


def test_a_drive_whose_wheels_cannot_turn_is_refused(open_world, parts, golden: Golden):
    robot = parts.husky()
    joints = tuple(replace(joint, kind="fixed") for joint in robot.joints)
    with golden.raises(SceneError, match="'drive'.*'husky'.*'back_left'"):
        open_world(parts.floor(), replace(robot, joints=joints))


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            Twist(Vector3(0.5, 0.3)),
            "moves along x and turns about z; the rest of a command on it has no effect",
        ),
        (
            Twist(Vector3(0.5), Vector3(0.0, 0.0, 90.0)),
            "is commanded 0.5 m/s and 90 rad/s, which no such robot",
        ),
        (Twist(Vector3(0.5), Vector3(0.0, 0.0, 1.0)), ""),
    ],
)
def test_a_command_that_wheels_cannot_follow_is_reported_once(open_world, parts, advance, command, words):
    world = open_world(parts.floor(), parts.husky())
    publisher = world.advertise("/husky/cmd_vel")
    for _ in range(2):
        publisher.publish(command)
        advance(world, 0.02)
    found = [one.message for one in world.warnings if one.code is Code.NRP299]
    assert [words in message for message in found] == [True] * bool(words)
