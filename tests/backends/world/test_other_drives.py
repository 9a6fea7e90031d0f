"""Drives beside the differential one: bases that go sideways, and cars."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, inf, pi, sin, tan

import numpy as np
import pytest

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Box, Collision, Cylinder, Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.ackermann import Ackermann, ackermann_velocity, wheel_angles
from nrp_core.world.drives.mecanum import PlanarMove

WHEEL, BASE, TRACK = 0.2, 1.2, 0.8


def platform() -> Model:
    """Return a box that slides on the floor."""
    shape = Box((0.6, 0.4, 0.2))
    body = Link(
        "body",
        inertial=Inertial(10.0, inertia=(0.2, 0.3, 0.4, 0.0, 0.0, 0.0)),
        collisions=(Collision("c", shape),),
    )
    drive = PlanarMove("move", "/cmd_vel", timeout=0.5, odometry_topic="/odom")
    return Model("platform", (body,), drives=(drive,), pose=Pose((0.0, 0.0, 0.1)))


def car(**options) -> Model:
    """Return a car with the middle of its rear axle at the origin of its frame."""
    lying, tyre = Pose.from_rpy((0, 0, 0), pi / 2, 0, 0), Cylinder(WHEEL, 0.1)
    base = Link("base", inertial=Inertial(40.0, Pose((BASE / 2, 0, 0)), (2.0, 5.0, 6.0, 0, 0, 0)))
    links, joints = [base], []
    for side, y in (("left", TRACK / 2), ("right", -TRACK / 2)):
        for end, x in (("rear", 0.0), ("front", BASE)):
            place, parent = Pose((x, y, 0.0)), "base"
            if end == "front":
                parent = f"{side}_knuckle"
                links.append(Link(parent, place, Inertial(0.5, inertia=(0.01, 0.01, 0.01, 0, 0, 0))))
                joints.append(
                    Joint(f"{side}_steering", "revolute", "base", parent, place, lower=-0.8, upper=0.8)
                )
            name = f"{end}_{side}"
            links.append(
                Link(
                    name,
                    place,
                    Inertial(2.0, inertia=(0.02, 0.04, 0.02, 0, 0, 0)),
                    (),
                    (Collision("tyre", tyre, lying),),
                )
            )
            joints.append(Joint(f"{name}_wheel", "continuous", parent, name, place, (0.0, 1.0, 0.0)))
    drive = Ackermann(
        "drive", "/cmd_vel",
        left=("rear_left_wheel", "front_left_wheel"), right=("rear_right_wheel", "front_right_wheel"),
        steering=("left_steering", "right_steering"), separation=TRACK, wheel_base=BASE,
        wheel_diameter=2 * WHEEL, odometry_topic="/odom", wheel_speeds_topic="/wheels", **options,
    )  # fmt: skip
    return Model(
        "car", tuple(links), tuple(joints), (drive,), Pose((0.0, 0.0, WHEEL)), joint_states_topic="/joints"
    )


def command(world, x: float, y: float, turn: float) -> None:
    world.advertise("/cmd_vel").publish(Twist(Vector3(x, y), Vector3(0.0, 0.0, turn)))


def test_a_platform_goes_forward_sideways_and_turns(open_world, parts, advance):
    world = open_world(parts.floor(), platform())
    for _ in range(50):
        command(world, 0.3, -0.2, 0.5)
        advance(world, 0.02)
    pose = world.model_motion("platform").pose
    # an arc whose centre is seen from the body at (vy, -vx) / -turn
    x = (0.3 * sin(0.5) + -0.2 * (cos(0.5) - 1)) / 0.5
    y = (0.3 * (1 - cos(0.5)) + -0.2 * sin(0.5)) / 0.5
    assert pose.position == pytest.approx((x, y, 0.1), abs=3e-3)
    assert pose.yaw == pytest.approx(0.5, abs=2e-3)
    assert "/odom" in world.topics


def test_a_platform_stops_at_its_time_out(open_world, parts, advance):
    world = open_world(parts.floor(), platform())
    command(world, 0.4, 0.0, 0.0)
    advance(world, 1.0)
    assert world.model_motion("platform").pose.position[0] == pytest.approx(0.2, abs=2e-3)


def test_a_platform_does_not_push_through_a_wall(open_world, parts, advance):
    world = open_world(parts.floor(), parts.wall(1.0), platform())
    for _ in range(150):
        command(world, 0.5, 0.0, 0.0)
        advance(world, 0.02)
    assert world.model_motion("platform").pose.position[0] == pytest.approx(0.7, abs=0.02)


@pytest.mark.parametrize(("steers", "turn"), [(True, 0.3), (False, 0.5 * tan(0.3) / BASE)])
def test_a_car_drives_the_circle_of_its_steering_angle(open_world, parts, advance, steers, turn):
    world = open_world(parts.floor(), car(steers=steers))
    command(world, 0.5, 0.0, turn)
    advance(world, 2.0)
    radius = BASE / tan(0.3)
    angle = 2.0 * 0.5 / radius
    pose = world.model_motion("car").pose
    assert pose.position[:2] == pytest.approx((radius * sin(angle), radius * (1 - cos(angle))), abs=0.01)
    assert pose.yaw == pytest.approx(angle, abs=0.01)
    joints = world.joint_states("car")
    angles = dict(zip(joints.names, joints.positions, strict=True))
    assert angles["left_steering"] == pytest.approx(atan(BASE / (radius - TRACK / 2)), abs=0.01)
    assert angles["right_steering"] == pytest.approx(atan(BASE / (radius + TRACK / 2)), abs=0.01)


def test_a_car_that_stands_does_not_turn_and_steers_no_further_than_it_can(open_world, parts, advance):
    world = open_world(parts.floor(), car(steers=True, max_steer=0.4))
    command(world, 0.0, 0.0, 5.0)
    advance(world, 0.5)
    assert world.model_motion("car").pose.yaw == pytest.approx(0.0, abs=2e-3)
    expected = wheel_angles(replace(car().drives[0], max_steer=0.4), 0.4)  # type: ignore[type-var]
    joints = world.joint_states("car")
    angles = dict(zip(joints.names, joints.positions, strict=True))
    assert (angles["left_steering"], angles["right_steering"]) == pytest.approx(expected, abs=0.01)


def test_a_car_that_is_steered_goes_to_the_same_side_in_reverse():
    there, back = (ackermann_velocity(car(steers=True).drives[0], v, 0.3) for v in (0.5, -0.5))
    assert back.steer == -there.steer
    assert back.turn == there.turn > 0


def test_a_car_is_no_faster_than_its_limit_in_both_directions():
    slow = replace(car(steers=True).drives[0], max_speed=0.4)
    speeds = [ackermann_velocity(slow, v, 0.3).forward for v in (0.5, 0.3, -0.5)]
    assert speeds == [0.4, 0.3, -0.4]


def test_wheel_angles_meet_in_one_point():
    drive = car().drives[0]
    assert isinstance(drive, Ackermann)
    assert wheel_angles(drive, 0.0) == (0.0, 0.0)
    for steer in np.linspace(-0.7, 0.7, 15):
        left, right = wheel_angles(drive, float(steer))
        if left and right:
            assert BASE / tan(right) - BASE / tan(left) == pytest.approx(TRACK)
    assert inf > left > 0


def test_many_robots_each_have_their_own_topics(open_world, parts, advance):
    robots = [parts.husky(f"husky{n}", Pose((0.0, 2.0 * n, parts.standing))) for n in range(4)]
    world = open_world(parts.floor(), *robots)
    for n in range(4):
        world.advertise(f"/husky{n}/cmd_vel").publish(Twist(Vector3(0.1 * n)))
    advance(world, 0.08)
    speeds = [world.model_motion(f"husky{n}").linear[0] for n in range(4)]
    assert speeds == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=0.01)
