"""The planar servo's layout and numbers."""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Collision, Inertial, Joint, Link, Model, Sphere
from nrp_core.scene.rigid import BodyVelocity, ModelMotion, Pose
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.engine_kit.planar_servo import TIME_CONSTANT_S, TRACTION, servo_of, without_wheel_friction

EARTH = (0.0, 0.0, -9.8)
RADIUS, TRACK = 0.1, 0.4


def robot(com: tuple[float, float, float] = (0.0, 0.0, 0.0), torque: float = inf) -> Model:
    """Return a robot of 12 kg with two wheels at x = 0.2."""
    base = Link("base", inertial=Inertial(10.0, Pose(com), (0.4, 0.4, 0.5, 0, 0, 0)))
    places = {"left": Pose((0.2, TRACK / 2, 0.0)), "right": Pose((0.2, -TRACK / 2, 0.0))}
    wheels = [
        Link(
            n,
            p,
            Inertial(1.0, inertia=(0.01, 0.02, 0.01, 0, 0, 0)),
            collisions=(Collision("c", Sphere(RADIUS)),),
        )
        for n, p in places.items()
    ]
    joints = tuple(Joint(n, "continuous", "base", n, p, (0.0, 1.0, 0.0)) for n, p in places.items())
    drive = WheelDrive("drive", "/cmd_vel", ("left",), ("right",), TRACK, 2 * RADIUS, torque)
    return Model("robot", (base, *wheels), joints, (drive,))


def servo(model: Model, gravity: tuple[float, float, float] = EARTH):
    return servo_of(model, model.drives[0], bodies_of(model), gravity)


def test_gain_lever_and_limit_follow_from_the_mass():
    layout = servo(robot())
    mass, centre_x = 12.0, 2 * 0.2 / 12
    moment = 0.5 + 2 * 0.01 + 10 * centre_x**2 + 2 * ((0.2 - centre_x) ** 2 + (TRACK / 2) ** 2)
    assert layout.centre == pytest.approx((centre_x, 0, 0))
    assert layout.to_centre == pytest.approx((centre_x - 0.2, 0))
    assert layout.gain == pytest.approx(mass / 2 / TIME_CONSTANT_S)
    assert layout.lever == pytest.approx(sqrt(moment / mass / 2))
    assert layout.limit == pytest.approx(TRACTION * mass * 9.8 / 2)


def test_weak_motors_limit_the_force():
    assert servo(robot(torque=2.0)).limit == pytest.approx(2.0 / RADIUS)
    assert servo(robot(), (0, 0, 0)).limit == 0


def test_wheels_spin_with_the_ground_below_them():
    left, right = servo(robot()).spins(BodyVelocity(forward=0.3, turn=1.0))
    assert left == pytest.approx((0.3 - TRACK / 2) / RADIUS)
    assert right == pytest.approx((0.3 + TRACK / 2) / RADIUS)


def test_the_aims_are_the_velocities_of_the_points_when_the_robot_goes_straight():
    assert servo(robot()).aims(BodyVelocity(forward=0.7), 0.002) == (0.7, 0.7, 0.0, 0.0)


def test_turning_about_the_axle_swings_the_centre_of_mass():
    layout = servo(robot())
    _, _, front, rear = layout.aims(BodyVelocity(turn=2.0), 0.0)
    assert (front + rear) / 2 == pytest.approx(2.0 * (layout.centre[0] - 0.2))


speeds = st.floats(-2, 2)
velocities = st.builds(BodyVelocity, forward=speeds, turn=speeds)


def at_drive(layout, motion: ModelMotion) -> tuple[float, float, float]:
    """Return how the middle of the wheels moves, in the robot's frame."""
    middle = motion.at(Pose((layout.centre[0] - layout.to_centre[0], 0.0, 0.0)))
    ahead, aside, _ = motion.pose.inverse().rotate(middle.linear)
    return ahead, aside, motion.pose.inverse().rotate(middle.angular)[2]


@given(before=velocities, after=velocities, yaw=speeds)
def test_a_robot_that_follows_its_command_follows_the_next_one_at_once(before, after, yaw):
    layout = servo(robot((0.05, 0.02, 0.1)))
    motion = ModelMotion(Pose.from_rpy((0, 0, 0), 0, 0, yaw))
    for old, new in ((BodyVelocity(), before), (before, after)):
        motion = layout.changed(motion, old, new)
        assert at_drive(layout, motion) == pytest.approx((new.forward, 0.0, new.turn), abs=1e-9)


@given(before=velocities, after=velocities)
def test_a_robot_that_is_held_is_not_thrown_beyond_its_command(before, after):
    layout = servo(robot())
    forward, _, turn = at_drive(layout, layout.changed(ModelMotion(Pose()), before, after))
    for got, wanted in ((turn, after.turn), (forward, after.forward)):
        assert abs(got) <= abs(wanted) + 1e-9
        assert got * wanted >= -1e-12


def test_a_command_to_push_less_does_not_throw_a_held_robot_back():
    layout = servo(robot())
    held = ModelMotion(Pose())
    assert layout.changed(held, BodyVelocity(forward=1.0), BodyVelocity(forward=0.5)) == held


def test_wheels_lose_their_friction_and_nothing_else_does():
    model = robot()
    base = replace(model.links[0], collisions=(Collision("c", Sphere(0.1), friction=0.7),))
    bodies = without_wheel_friction(model, bodies_of(replace(model, links=(base, *model.links[1:]))))
    frictions = {link.name: link.collisions[0].friction for body in bodies for link in body.links}
    assert frictions == {"base": 0.7, "left": 0.0, "right": 0.0}


def test_a_drive_needs_a_base_that_floats(golden: Golden):
    model = robot()
    held = replace(model, joints=(*model.joints, Joint("anchor", "fixed", "world", "base")))
    with golden.raises(SceneError, match="'drive'.*'robot'"):
        servo(held)


def test_wheels_on_two_bodies_are_refused(golden: Golden):
    model = robot()
    left, right = model.joints
    chained = replace(model, joints=(left, replace(right, parent="left")))
    with golden.raises(SceneError):
        servo(chained)
