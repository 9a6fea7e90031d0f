"""Wheels on rockers and suspensions, as rovers and vacuum cleaners have them, move the robot as others do."""

from __future__ import annotations

from math import cos, pi, sin

import pytest

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Collision, Cylinder, Inertial, Joint, Link, Mimic, Model, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.wheels import WheelDrive

RADIUS, TRACK = 0.1, 0.6
LYING = Pose.from_rpy((0.0, 0.0, 0.0), pi / 2, 0.0, 0.0)
LIGHT = (0.01, 0.01, 0.01, 0.0, 0.0, 0.0)
FORWARD, TURN, LASTS = 0.3, 0.5, 1.5


def wheel(name: str, x: float, y: float, held_by: str) -> tuple[Link, Joint]:
    place = Pose((x, y, RADIUS))
    tyre = (Collision("tyre", Cylinder(RADIUS, 0.04), LYING),)
    link = Link(name, place, Inertial(1.0, inertia=(3e-3, 5e-3, 3e-3, 0.0, 0.0, 0.0)), collisions=tyre)
    return link, Joint(f"{name}_axle", "continuous", held_by, name, place, (0.0, 1.0, 0.0))


def rover(links, joints, base: Link, left, right) -> Model:
    drive = WheelDrive(
        "drive", "/cmd_vel", left, right, TRACK, 2 * RADIUS, timeout=1.0, odometry_topic="/odom"
    )
    return Model("rover", (base, *links), tuple(joints), drives=(drive,))


def rockers() -> Model:
    """Return a body on two rockers with two wheels each; one rocker turns against the other one."""
    base = Link("base", Pose((0.0, 0.0, 0.3)), Inertial(10.0, inertia=(0.3, 0.3, 0.3, 0.0, 0.0, 0.0)))
    links, joints = [], []
    for side, y, mimic in (("left", TRACK / 2, None), ("right", -TRACK / 2, Mimic("left_rock", -1.0))):
        place = Pose((0.0, y * 0.8, 0.3))
        links.append(Link(f"{side}_rocker", place, Inertial(1.0, inertia=LIGHT)))
        joints.append(
            Joint(
                f"{side}_rock", "revolute", "base", f"{side}_rocker", place, (0, 1, 0), -0.4, 0.4, mimic=mimic
            )
        )
        for end, x in (("front", 0.3), ("rear", -0.3)):
            link, joint = wheel(f"{side}_{end}", x, y, f"{side}_rocker")
            links.append(link)
            joints.append(joint)
    names = [joint.name for joint in joints if joint.kind == "continuous"]
    return rover(links, joints, base, tuple(names[:2]), tuple(names[2:]))


def drops() -> Model:
    """Return a body on two casters, with two wheels that springs push down."""
    casters = tuple(
        Collision(f"c{x}", Sphere(0.05), Pose((x, 0.0, 0.05)), friction=0.0) for x in (-0.25, 0.25)
    )
    mass = Inertial(4.0, Pose((0.0, 0.0, 0.1)), (0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    links, joints = [], []
    for side, y in (("left", TRACK / 2), ("right", -TRACK / 2)):
        place = Pose((0.0, y, RADIUS))
        links.append(Link(f"{side}_drop", place, Inertial(0.2, inertia=(1e-3, 1e-3, 1e-3, 0, 0, 0))))
        joints.append(
            Joint(f"{side}_spring", "prismatic", "base", f"{side}_drop", place, (0, 0, 1), -0.02, 0.02,
                  damping=20.0, stiffness=500.0, rest=-0.02)
        )  # fmt: skip
        link, joint = wheel(side, 0.0, y, f"{side}_drop")
        links.append(link)
        joints.append(joint)
    return rover(
        links, joints, Link("base", inertial=mass, collisions=casters), ("left_axle",), ("right_axle",)
    )


@pytest.mark.parametrize("robot", [rockers, drops])
def test_a_robot_on_suspended_wheels_drives_along_the_commanded_arc(
    open_world, advance, parts, robot
) -> None:
    """After a curve of radius v / w by the angle w t it is where the formula of a circle has it."""
    world = open_world(parts.floor(), robot())
    advance(world, 0.3)
    command = world.advertise("/cmd_vel")
    for _ in range(round(LASTS / 0.1)):
        command.publish(Twist(Vector3(x=FORWARD), Vector3(z=TURN)))
        advance(world, 0.1)
    pose = world.model_motion("rover").pose
    angle, radius = TURN * LASTS, FORWARD / TURN
    assert pose.position[:2] == pytest.approx((radius * sin(angle), radius * (1 - cos(angle))), abs=0.01)
    assert pose.rotate((1.0, 0.0, 0.0)) == pytest.approx((cos(angle), sin(angle), 0.0), abs=0.02)
    states = world.joint_states("rover")
    turning = dict(zip(states.names, states.velocities.tolist(), strict=True))
    side = next(name for name in turning if name.startswith("right") and name.endswith("axle"))
    assert turning[side] == pytest.approx((FORWARD + TURN * TRACK / 2) / RADIUS, rel=0.02)
