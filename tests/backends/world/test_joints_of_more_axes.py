"""Universal, screw, planar and geared joints of SDF move as the closed forms of mechanics say."""

from __future__ import annotations

from math import atan, cos, pi, sin, sqrt, tan

import numpy as np
import pytest
from jointed import (
    ARM,
    CROSS,
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
    limit,
    link,
    push,
    told,
    weightless,
)

from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import Pose

# -- two axes


def test_a_universal_joint_bends_about_its_two_axes(open_world, read):
    world = open_world(read(HANGING + joint("universal", CROSS)))
    world.set_joints("robot", {"j": 0.5, "j_axis2": -0.8})
    expected = Pose.from_rpy(FREE, 0.5, 0.0, 0.0) @ Pose.from_rpy(FREE, 0.0, -0.8, 0.0)
    found = world.link_motion("robot", "bob").pose.orientation
    assert abs(np.dot(found, expected.orientation)) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize(("name", "pull"), [("j", (0.0, 0.3, 0.0)), ("j_axis2", (0.3, 0.0, 0.0))])
def test_a_universal_joint_swings_about_each_axis_as_a_pendulum(open_world, read, advance, name, pull):
    world = open_world(read(HANGING + joint("universal", CROSS)))
    world.set_joints("robot", {name: 0.1})
    period = 2 * pi * sqrt(ROUND / (MASS * GRAVITY * ARM)) * (1 + 0.1**2 / 16)
    advance(world, 0.02 * round(3.25 * period / 0.02))
    late = world.now_ns * 1e-9 - 3.25 * period
    positions, _ = told(world)
    rate = 2 * pi / period
    assert positions.pop(name) == pytest.approx(-0.1 * sin(rate * late), abs=4e-3)
    assert list(positions.values()) == pytest.approx([0.0], abs=1e-6)
    push(world, "bob", force=pull)  # and the other one is not locked
    advance(world, 0.1)
    assert max(map(abs, told(world)[1].values())) > 0.02


@pytest.mark.parametrize(("kind", "turns_as_one"), [("universal", True), ("ball", False)])
def test_a_universal_joint_transmits_a_twist_and_a_ball_does_not(
    open_world, read, advance, kind, turns_as_one
):
    shaft = link("shaft", moments=(0.1, 0.1, 0.03)) + link("bob", moments=(0.1, 0.1, 0.01))
    held = joint("continuous", axis("0 0 1"), name="bearing", child="shaft")
    world = open_world(weightless(read(shaft + held + joint(kind, CROSS, parent="shaft"))))
    push(world, "bob", torque=(0.0, 0.0, 0.08))
    advance(world, 0.5)
    shaft_rate, bob_rate = (world.link_motion("robot", name).angular[2] for name in ("shaft", "bob"))
    assert bob_rate == pytest.approx(0.08 / (0.04 if turns_as_one else 0.01) * 0.5, rel=2e-3)
    assert shaft_rate == pytest.approx(bob_rate if turns_as_one else 0.0, abs=1e-3)


def test_each_axis_has_its_own_limits_and_damping(open_world, read, advance):
    first = axis("1 0 0", limit(-0.3, 0.3))
    other = axis("0 1 0", limit(-0.5, 0.1) + "<dynamics><damping>0.5</damping></dynamics>", tag="axis2")
    world = open_world(weightless(read(HANGING + joint("universal", first + other))))
    push(world, "bob", torque=(0.2, 0.0, 0.0))
    advance(world, 3.0)
    assert told(world)[0]["j"] == pytest.approx(0.3, abs=0.01)
    world.reset()
    world.call("/gazebo/apply_joint_effort", "robot::j_axis2", -0.1, duration=Duration(-1))
    advance(world, 1.0)
    slowed = -0.1 / 0.5 * (1 - np.exp(-0.5 / ROUND))
    assert told(world)[1]["j_axis2"] == pytest.approx(slowed, rel=0.01)
    advance(world, 5.0)
    assert told(world)[0]["j_axis2"] == pytest.approx(-0.5, abs=0.01)


def test_a_wheel_on_two_axes_is_steered_and_spins(open_world, read, advance):
    """The front wheel of a car: it spins about an axle that turns with the steering."""
    wheel = link("bob", moments=(0.01, 0.02, 0.01), at=(0.4, 0.3, 0.1))
    steering = axis("0 0 1", limit(-0.5, 0.5)) + axis("0 1 0", tag="axis2")
    led = controlled(("j", "position", ""), ("j_axis2", "velocity", ""))
    world = open_world(read(wheel + joint("revolute2", steering) + led))
    command(world, "j", "pos", 0.4)
    command(world, "j_axis2", "vel", 6.0)
    advance(world, 2.0)
    positions, velocities = told(world)
    assert positions["j"] == pytest.approx(0.4, abs=2e-3)
    assert velocities["j_axis2"] == pytest.approx(6.0, rel=2e-3)
    motion = world.link_motion("robot", "bob")
    assert motion.angular == pytest.approx((-6.0 * sin(0.4), 6.0 * cos(0.4), 0.0), abs=0.05)
    assert motion.pose.position == pytest.approx((0.4, 0.3, 0.1), abs=1e-6)


def car() -> str:
    """Return a car whose front wheels are held by one ``revolute2`` joint each; 0.6 m long, 0.4 m wide."""
    tyre = "<cylinder><radius>0.1</radius><length>0.05</length></cylinder>"
    lying = (
        f"<collision name='c'><pose>0 0 0 {pi / 2} 0 0</pose><geometry>{tyre}</geometry></collision></link>"
    )
    parts = link("base", 8.0, (0.2, 0.3, 0.4), at=(0.0, 0.0, 0.1))
    for end, x in (("front", 0.3), ("rear", -0.3)):
        for side, y in (("left", 0.2), ("right", -0.2)):
            name = f"{end}_{side}"
            parts += link(f"{name}_wheel", 0.5, (2e-3, 2.5e-3, 2e-3), at=(x, y, 0.1)).replace(
                "</link>", lying
            )
            axes = axis("0 0 1", limit(-0.6, 0.6)) + axis("0 1 0", tag="axis2")
            kind, more = ("revolute2", axes) if end == "front" else ("continuous", axis("0 1 0"))
            parts += joint(kind, more, name=name, parent="base", child=f"{name}_wheel")
    named = "".join(
        f"<{side}_joint>front_{side}_axis2</{side}_joint><{side}_joint>rear_{side}</{side}_joint>"
        f"<{side}_steering_joint>front_{side}</{side}_steering_joint>"
        for side in ("left", "right")
    )
    sizes = "<wheel_separation>0.4</wheel_separation><wheel_base>0.6</wheel_base>"
    sizes += "<kingpin_width>0.4</kingpin_width><wheel_radius>0.1</wheel_radius>"
    sizes += "<steering_limit>0.5</steering_limit>"
    return f"{parts}<plugin name='gz::sim::systems::AckermannSteering' filename='a'>{named}{sizes}</plugin>"


def test_a_car_drives_in_a_circle_on_wheels_of_two_axes(open_world, read, advance, parts):
    """At 0.8 m/s and 0.4 rad/s the middle of its rear axle goes round at 2 m."""
    world = open_world(parts.floor(), read(car()))
    world.advertise("/model/robot/cmd_vel").publish(Twist(Vector3(0.8), Vector3(0.0, 0.0, 0.4)))
    advance(world, 3.0)
    motion = world.model_motion("robot").at(Pose((-0.3, 0.0, 0.0)))
    assert motion.angular[2] == pytest.approx(0.4, rel=0.05)
    assert np.hypot(*motion.linear[:2]) == pytest.approx(0.8, rel=0.03)
    positions, velocities = told(world)
    for side, y in (("left", 0.2), ("right", -0.2)):
        assert positions[f"front_{side}"] == pytest.approx(atan(0.6 / (2.0 - y)), abs=0.01)
        assert velocities[f"front_{side}_axis2"] == pytest.approx(8.0, rel=0.15)


# -- screws


@pytest.mark.parametrize(
    ("pitch", "travel_a_turn"),
    [
        ("<screw_thread_pitch>0.2</screw_thread_pitch>", 0.2),
        (f"<thread_pitch>{2 * pi / 0.2}</thread_pitch>", -0.2),  # rad/m, to the left
    ],
)
def test_a_nut_travels_its_pitch_in_each_turn(open_world, read, advance, pitch, travel_a_turn):
    """Its weight turns the screw with ``(J + m p^2) alpha = m g p``, p the travel per radian."""
    world = open_world(read(link("bob") + joint("screw", pitch + axis("0 0 1"))))
    advance(world, 1.0)
    positions, velocities = told(world)
    lead = travel_a_turn / 2 / pi
    alpha = -MASS * GRAVITY * lead / (MOMENT + MASS * lead**2)
    assert velocities["j"] == pytest.approx(alpha, rel=5e-3)
    assert positions["j"] == pytest.approx(alpha / 2, rel=0.01)
    assert positions["j_travel"] == pytest.approx(lead * positions["j"], abs=2e-3)
    motion = world.link_motion("robot", "bob")
    assert motion.pose.position[2] == pytest.approx(positions["j_travel"], abs=1e-6)
    assert motion.angular[2] == pytest.approx(velocities["j"], rel=1e-6)


def test_a_fine_thread_lifts_what_turns_it(open_world, read, advance):
    """A motor at 10 rad/s on 2 mm a turn."""
    fine = "<screw_thread_pitch>0.002</screw_thread_pitch>" + axis("0 0 1", limit(-50, 50))
    world = open_world(read(link("bob") + joint("screw", fine) + controlled(("j", "velocity", ""))))
    command(world, "j", "vel", 10.0)
    advance(world, 2.0)
    positions, _ = told(world)
    assert positions["j"] == pytest.approx(20.0, abs=1.0)
    assert positions["j_travel"] == pytest.approx(0.002 * positions["j"] / 2 / pi, abs=3e-5)
    advance(world, 8.0)
    assert told(world)[0]["j"] == pytest.approx(50.0, abs=0.05)


# -- gearboxes, planes


def gears(ratio: float) -> str:
    bodies = link("frame", 5.0, (0.1,) * 3) + link("small", 0.5, (0.01,) * 3) + link("bob", 1.0, (0.02,) * 3)
    body = f"<gearbox_reference_body>frame</gearbox_reference_body><gearbox_ratio>{ratio}</gearbox_ratio>"
    return (
        bodies
        + joint("fixed", name="mount", child="frame")
        + joint("continuous", axis("0 0 1"), name="first", parent="frame", child="small")
        + joint("continuous", axis("0 0 -1"), name="second", parent="frame")
        + joint("gearbox", body + axis("0 0 1") + axis("0 0 1", tag="axis2"), name="gears", parent="small")
    )


def test_a_gearbox_turns_by_its_ratio_and_carries_what_hangs_on_it(open_world, read, advance):
    """``theta_2 = -ratio theta_1`` about the gears' axes; the joint of the second turns the other way."""
    world = open_world(weightless(read(gears(3.0))))
    push(world, "small", torque=(0.0, 0.0, 0.19))
    advance(world, 1.0)
    _, velocities = told(world)
    assert velocities["first"] == pytest.approx(0.19 / (0.01 + 3.0**2 * 0.02), rel=5e-3)
    assert velocities["second"] == pytest.approx(3.0 * velocities["first"], rel=5e-3)
    assert world.link_motion("robot", "bob").angular[2] == pytest.approx(-velocities["second"], rel=1e-6)


def test_a_planar_joint_slides_and_turns_in_its_plane(open_world, read, advance):
    world = open_world(weightless(read(link("bob") + joint("planar", axis("1 0 0")))))
    push(world, "bob", torque=(0.02, 0.5, 0.5), force=(5.0, 1.0, -0.6))
    advance(world, 0.5)
    motion = world.link_motion("robot", "bob")
    assert motion.linear == pytest.approx((0.0, 0.25, -0.15), abs=2e-3)
    assert motion.angular == pytest.approx((0.5, 0.0, 0.0), abs=2e-3)


# -- state

CHAIN = (
    link("one", com=(0.0, 0.1, -0.3))
    + link("two", com=(0.1, 0.0, -0.3), at=(0, 0, -0.5))
    + link("three", com=(0.0, 0.05, -0.2), at=(0, 0, -1))
    + link("bob", com=(0.05, 0.0, -0.2), at=(0, 0, -1.5))
    + joint("ball", name="hip", child="one")
    + joint("universal", CROSS, name="cardan", parent="one", child="two")
    + joint(
        "screw", "<screw_thread_pitch>0.3</screw_thread_pitch>", name="screw", parent="two", child="three"
    )
    + joint("revolute", axis("1 0 0"), name="knee", parent="three")
    + controlled(("knee", "position", "<pid>20 0 1</pid>"), ("cardan", "velocity", "<pid>2 0 0</pid>"))
)


def states(world) -> list[list[float]]:
    joints = world.joint_states("robot")
    ends = [world.link_motion("robot", name) for name in ("one", "two", "three", "bob")]
    moving = [value for end in ends for value in (*end.pose.position, *end.linear, *end.angular)]
    return [joints.positions.tolist(), joints.velocities.tolist(), joints.efforts.tolist(), moving]


def test_a_chain_of_them_goes_on_from_a_snapshot_and_after_a_reset_as_if_nothing_had_been(
    open_world, read, advance
):
    world, fresh = open_world(read(CHAIN)), open_world(read(CHAIN))

    def begin(each) -> None:
        each.set_joints("robot", {"hip_x": 0.4, "hip_y": -0.3, "cardan_axis2": 0.2})
        command(each, "knee", "pos", 0.6)
        command(each, "cardan", "vel", 0.3)
        advance(each, 0.3)

    begin(world)
    snapshot = world.snapshot()
    now = states(world)
    advance(world, 0.4)
    expected = states(world)
    assert expected[0] != pytest.approx(now[0], abs=0.01)
    for again in (world, fresh):
        again.restore(snapshot)
        assert states(again) == now
        advance(again, 0.4)
        assert states(again) == expected
    world.reset()
    begin(world)
    assert states(world) == now


def test_a_chain_of_them_stays_as_it_is_when_something_else_comes_into_the_scene(
    open_world, read, advance, parts
):
    world = open_world(read(CHAIN))
    world.set_joints("robot", {"hip_x": 0.4, "hip_z": -0.3, "cardan_axis2": 0.2})
    advance(world, 0.3)
    positions, velocities = told(world)
    world.spawn(parts.floor())
    assert told(world)[0] == pytest.approx(positions, abs=1e-12)
    assert told(world)[1] == pytest.approx(velocities, abs=1e-12)


def test_both_engines_move_a_chain_of_them_alike(engines, read, advance):
    ends = []
    for backend in engines:
        with backend.open(Scene((read(CHAIN),)), seed=1, options=backend.options()) as world:
            world.set_joints("robot", {"hip_x": 0.3, "hip_y": 0.2})
            command(world, "knee", "pos", 0.3)
            advance(world, 1.0)
            ends.append(told(world)[0])
    assert ends[0] == pytest.approx(ends[1], abs=0.02)


def test_a_load_cell_in_them_feels_what_hangs_on_them(open_world, read, advance):
    cell = '<sensor name="cell" type="force_torque"><update_rate>50</update_rate></sensor>'
    for kind in ("ball", "universal"):
        world = open_world(read(HANGING + joint(kind, CROSS + cell)))
        push(world, "bob", force=(MASS * GRAVITY * tan(0.2), 0.0, 0.0))
        world.set_joints("robot", {"j_axis2" if kind == "universal" else "j_y": -atan(tan(0.2))})
        advance(world, 0.1)
        load = world.engine.joint_wrench("robot", "j")
        assert load.force == pytest.approx((MASS * GRAVITY * tan(0.2), 0.0, -MASS * GRAVITY), abs=0.1)
