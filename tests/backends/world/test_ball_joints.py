"""Ball joints of SDF move as the closed forms of mechanics say."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from golden import Golden
from jointed import (
    ARM,
    FREE,
    GRAVITY,
    HANGING,
    MASS,
    MOMENT,
    ROUND,
    axis,
    command,
    controlled,
    joint,
    link,
    push,
    told,
    weightless,
)
from scipy.special import ellipk

from nrp_core.errors import SceneError, TopicError
from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Quaternion, Twist, Vector3
from nrp_core.scene.devices import Pid
from nrp_core.scene.rigid import Pose, multiply, rotation_by, rotation_vector
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot


def test_a_bob_on_a_ball_swings_in_any_plane_with_the_period_of_a_pendulum(open_world, read, advance):
    """From 0.8 rad, in the plane between x and y; the period by the complete elliptic integral."""
    world = open_world(read(HANGING + joint("ball")))
    lean = 0.8 / sqrt(2)
    world.set_joints("robot", {"j_x": -lean, "j_y": lean})
    assert told(world)[0] == pytest.approx({"j_x": -lean, "j_y": lean, "j_z": 0.0})
    period = 4 * sqrt(ROUND / (MASS * GRAVITY * ARM)) * ellipk(sin(0.4) ** 2)
    advance(world, 0.02 * round(period / 4 / 0.02))
    early = period / 4 - world.now_ns * 1e-9
    positions, velocities = told(world)
    fastest = sqrt(2 * MASS * GRAVITY * ARM * (1 - cos(0.8)) / ROUND)
    assert velocities["j_y"] == pytest.approx(-fastest / sqrt(2), rel=0.01)
    assert velocities["j_x"] == pytest.approx(fastest / sqrt(2), rel=0.01)
    assert positions["j_y"] - early * fastest / sqrt(2) == pytest.approx(0.0, abs=0.01)
    assert positions["j_z"] == pytest.approx(0.0, abs=1e-6)


def test_a_bob_on_a_ball_goes_round_in_a_cone(open_world, read, advance):
    """As fast as carries it at 0.6 rad: ``omega^2 = g / (l cos 0.6)`` with the length of the pendulum."""
    lean = 0.6
    length = ROUND / (MASS * ARM)
    rate = sqrt(GRAVITY / (length * cos(lean)))
    world = open_world(read(HANGING + joint("ball")))
    world.set_joints("robot", {"j_y": -lean})  # towards x
    impulse = rate * sin(lean) * ROUND / ARM  # N s at the bob, to the left
    push(world, "bob", force=(0.0, impulse / 0.002, 0.0), lasts_ns=2_000_000)
    for turns in (0.5, 1.0, 1.5):
        advance(world, 0.02 * round(turns * 2 * pi / rate / 0.02) - world.now_ns * 1e-9)
        bob = world.link_motion("robot", "bob").pose @ Pose((0.0, 0.0, -ARM))
        x, y, z = bob.position
        angle = rate * world.now_ns * 1e-9
        assert (x, y) == pytest.approx(
            (ARM * sin(lean) * cos(angle), ARM * sin(lean) * sin(angle)), abs=0.015
        )
        assert z == pytest.approx(-ARM * cos(lean), abs=0.01)


def test_a_ball_turns_over_without_a_pole(open_world, read, advance):
    """Three turns about an oblique axis: Euler angles would have failed on the way."""
    oblique = np.array([0.48, 0.6, 0.64])
    world = open_world(weightless(read(link("bob") + joint("ball"))))
    push(world, "bob", torque=(MOMENT * 6 * pi * oblique).tolist(), lasts_ns=200_000_000)
    advance(world, 2.1)  # 1.2 pi rad/s after 0.2 s
    assert world.link_motion("robot", "bob").angular == pytest.approx(1.2 * pi * oblique, rel=1e-3)
    assert list(told(world)[1].values()) == pytest.approx(1.2 * pi * oblique, rel=1e-3)
    angle = 1.2 * pi * 2.0 % (2 * pi)
    assert list(told(world)[0].values()) == pytest.approx((angle - 2 * pi * (angle > pi)) * oblique, abs=0.02)


def test_the_coordinates_of_a_ball_are_along_the_axes_of_its_joint(open_world, read):
    """The frame of the joint is turned about z: its x is the y of the model."""
    turned = f"<pose>0 0 0 0 0 {pi / 2}</pose>"
    world = open_world(read(HANGING + joint("ball", turned)))
    world.set_joints("robot", {"j_x": 0.5, "j_z": 0.0})
    assert world.link_motion("robot", "bob").pose.rpy == pytest.approx((0.0, 0.5, 0.0), abs=1e-6)
    world.set_joints("robot", {"j_y": 1.1, "j_z": -0.7})
    expected = Pose.from_rpy(FREE, 0, 0, pi / 2) @ Pose(orientation=rotation_by((0.5, 1.1, -0.7)))
    expected = expected @ Pose.from_rpy(FREE, 0, 0, -pi / 2)
    found = world.link_motion("robot", "bob").pose.orientation
    assert abs(np.dot(found, expected.orientation)) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("dynamics", "kept"), [("damping", "exp"), ("friction", "dry")])
def test_a_ball_is_slowed_about_every_axis(open_world, read, advance, dynamics, kept):
    damped = f"<axis><xyz>0 0 1</xyz><dynamics><{dynamics}>0.02</{dynamics}></dynamics></axis>"
    world = open_world(weightless(read(link("bob") + joint("ball", damped))))
    push(world, "bob", torque=(0.0, 0.2, 0.0), lasts_ns=500_000_000)
    advance(world, 1.0)
    if kept == "exp":
        expected = 10.0 * (1 - np.exp(-0.5)) * np.exp(-0.5)
    else:
        expected = (0.2 - 0.02) / MOMENT * 0.5 - 0.02 / MOMENT * 0.5
    assert world.link_motion("robot", "bob").angular == pytest.approx((0.0, expected, 0.0), rel=0.01)


def test_an_effort_on_a_ball_acts_about_one_axis_of_it(open_world, read, advance):
    world = open_world(weightless(read(link("bob") + joint("ball"))))
    world.call("/gazebo/apply_joint_effort", "robot::j_y", 0.01, duration=Duration(-1))
    advance(world, 1.0)
    assert told(world)[1] == pytest.approx({"j_x": 0.0, "j_y": 0.01 / MOMENT, "j_z": 0.0}, rel=2e-3)
    states = world.joint_states("robot")
    assert states.efforts == pytest.approx([0.0, 0.01, 0.0])
    answer = world.call("/gazebo/get_joint_properties", "robot::j_y")
    assert (answer.success, answer.type) == (True, answer.BALL)
    assert answer.rate == pytest.approx([0.01 / MOMENT], rel=2e-3)


def led(read):
    """Return a bob on a ball joint that takes orientations, and rubs."""
    rubs = (
        "<axis><xyz>0 0 1</xyz><dynamics><damping>0.05</damping><friction>0.01</friction></dynamics></axis>"
    )
    return set_up_robot(
        read(HANGING + joint("ball", rubs)), RobotSetup(control=((".*", JointControl("position")),))
    )


def lead(world, turn):
    world.advertise("/robot/j/cmd_pos").publish(Quaternion(*rotation_by(turn)))


def distance(world, turn):
    """Return the angle from an orientation to that of the bob, rad."""
    x, y, z, w = rotation_by(turn)
    now = rotation_by(tuple(told(world)[0].values()))
    return np.linalg.norm(rotation_vector(multiply((-x, -y, -z, w), now)))


def test_a_ball_reaches_the_orientations_it_is_commanded_and_is_held_there(open_world, read, advance):
    """By the shorter way, also where two lie more than half a turn apart; against gravity and friction."""
    world = open_world(led(read))
    for turn in ((0.5, 0.3, -0.2), (-1.0, 1.2, 0.8), (2.0, -1.5, 0.3)):
        away = distance(world, turn)
        lead(world, turn)
        advance(world, 0.5)
        assert distance(world, turn) < 0.01 * away
        advance(world, 0.5)
        assert distance(world, turn) < 1e-4
    down = Pose(orientation=rotation_by(turn)).rotate_back((0.0, 0.0, -GRAVITY * MASS))
    held = -np.cross((0.0, 0.0, -ARM), down)
    assert world.joint_states("robot").efforts == pytest.approx(held, rel=1e-3, abs=1e-3)


def test_a_ball_is_held_where_it_starts_and_where_it_is_put(open_world, read, advance):
    """Level and oblique, against the weight of the bob; the effort is its moment."""
    world = open_world(led(read))
    for turn in ((0.0, 0.0, 0.0), (0.0, -pi / 2, 0.0), (0.4, 0.9, -0.6)):
        world.set_joints("robot", dict(zip(("j_x", "j_y", "j_z"), turn, strict=True)))
        advance(world, 0.5)
        assert distance(world, turn) < 1e-4
        down = Pose(orientation=rotation_by(turn)).rotate_back((0.0, 0.0, -GRAVITY * MASS))
        held = -np.cross((0.0, 0.0, -ARM), down)
        assert world.joint_states("robot").efforts == pytest.approx(held, rel=1e-3, abs=1e-3)
    lead(world, (0.2, 0.3, 0.0))
    advance(world, 1.0)
    world.set_joints("robot", {"j_y": 1.0})
    advance(world, 1.0)
    assert distance(world, (0.2, 0.3, 0.0)) < 1e-4


def test_a_led_ball_goes_on_from_a_snapshot_and_is_held_again_after_a_reset(open_world, read, advance):
    world = open_world(led(read))
    world.set_joints("robot", {"j_y": 0.7})
    advance(world, 0.3)
    held = world.snapshot()
    lead(world, (0.2, 0.9, 0.4))
    advance(world, 0.1)
    before = world.snapshot()
    advance(world, 0.1)
    expected = told(world)
    lead(world, (-1.0, 0.0, 0.0))
    advance(world, 0.5)
    world.restore(before)
    advance(world, 0.1)
    assert told(world) == expected
    world.restore(held)
    world.set_joints("robot", {"j_y": -0.3})
    advance(world, 0.3)
    assert distance(world, (0.0, -0.3, 0.0)) < 1e-4
    world.reset()
    advance(world, 0.3)
    assert distance(world, (0.0, 0.0, 0.0)) < 1e-4


def test_a_ball_takes_nothing_but_unit_quaternions(open_world, read, golden: Golden):
    world = open_world(led(read))
    with golden.raises(TopicError, match=r"/robot/j/cmd_pos: \(0, 0, 0, 0.5\)"):
        world.advertise("/robot/j/cmd_pos").publish(Quaternion(0.0, 0.0, 0.0, 0.5))


@pytest.mark.parametrize("control", [JointControl("velocity"), JointControl("position", Pid(100.0))])
def test_a_ball_takes_no_other_mode_and_no_gains(read, control, golden: Golden):
    with golden.raises(SceneError, match=r"'j'.*'robot'.*\{mode: position\}"):
        set_up_robot(read(HANGING + joint("ball")), RobotSetup(control=(("j", control),)))


def test_a_servo_beside_a_ball_gets_what_its_stiffness_gives(open_world, read, advance):
    """An arm with a bob on a ball at its end, which comes to rest: what hangs on the arm is carried."""
    parts = (
        link("base", 5.0, (0.1,) * 3)
        + link("arm", com=(0.25, 0.0, 0.0))
        + link("bob", com=(0.0, 0.0, -0.2), at=(0.5, 0.0, 0.0))
        + joint("revolute", axis("0 1 0"), name="hinge", parent="base", child="arm")
        + joint(
            "ball", "<axis><xyz>0 0 1</xyz><dynamics><damping>1</damping></dynamics></axis>", parent="arm"
        )
    )
    held = joint("fixed", name="mount", child="base")
    world = open_world(read(parts + held + controlled(("hinge", "position", "<pid>2000 0 100</pid>"))))
    world.set_joints("robot", {"j_x": 0.7, "j_z": 0.9})
    command(world, "hinge", "pos", 0.4)
    advance(world, 10.0)
    positions, _ = told(world)
    load = (MASS * 0.25 + MASS * 0.5) * GRAVITY * cos(positions["hinge"])
    assert 2000.0 * (positions["hinge"] - 0.4) == pytest.approx(load, rel=2e-3)
    assert world.link_motion("robot", "bob").pose.rotate((0, 0, 1)) == pytest.approx((0, 0, 1), abs=5e-3)


# -- casters

WHEEL = 0.1
BALL = 0.04


def cart() -> str:
    """Return a cart on two wheels, with a ball of 4 cm behind."""
    base = link("base", 6.0, (0.1, 0.1, 0.1), com=(-0.05, 0.0, 0.0), at=(0.0, 0.0, 0.15))
    tyre = f"<cylinder><radius>{WHEEL}</radius><length>0.04</length></cylinder>"
    lying = (
        f"<collision name='c'><pose>0 0 0 {pi / 2} 0 0</pose><geometry>{tyre}</geometry></collision></link>"
    )
    wheels = "".join(
        link(side, 0.5, (2e-3, 2.5e-3, 2e-3), at=(0.0, y, WHEEL)).replace("</link>", lying)
        + joint("continuous", axis("0 1 0"), name=f"{side}_joint", parent="base", child=side)
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    sphere = f"<geometry><sphere><radius>{BALL}</radius></sphere></geometry>"
    round_ = f"<collision name='c'>{sphere}</collision></link>"
    ball = link("ball", 0.1, (6.4e-5,) * 3, at=(-0.2, 0.0, BALL)).replace("</link>", round_)
    names = "<leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint>"
    sizes = "<wheelSeparation>0.4</wheelSeparation><wheelDiameter>0.2</wheelDiameter><torque>5</torque>"
    drive = f'<plugin name="d" filename="libgazebo_ros_diff_drive.so">{names}{sizes}</plugin>'
    return base + wheels + ball + joint("ball", name="caster", parent="base", child="ball") + drive


@pytest.mark.parametrize("drive", ["planar", "physical"])
def test_the_ball_of_a_caster_rolls(open_world, read, advance, parts, drive):
    """Where it touches the ground it stands still, ahead and in a turn."""
    world = open_world(parts.floor(), read(cart()), drive=drive)
    world.advertise("/robot/cmd_vel").publish(Twist(Vector3(0.5), Vector3(0.0, 0.0, 0.6)))
    advance(world, 2.0)
    base, ball = world.model_motion("robot"), world.link_motion("robot", "ball")
    assert np.hypot(*base.linear[:2]) == pytest.approx(0.5, rel=0.12)
    touching = np.add(ball.linear, np.cross(ball.angular, (0.0, 0.0, -BALL)))
    assert touching == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    assert np.hypot(*ball.angular[:2]) == pytest.approx(0.5 / BALL, rel=0.12)
