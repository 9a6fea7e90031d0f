"""The bodies that ship stand, walk, roll and look on both engines."""

from __future__ import annotations

from math import cos, pi, sin

import pytest
from nrp_experiments.bodies import FOLDER
from nrp_experiments.bodies.hexapod import PLACES, SIDES, Hexapod

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_model

STEP_NS = 20_000_000


@pytest.fixture
def ground(open_world, parts):
    """Open a shipped body on a floor."""
    return lambda name: open_world(Scene((parts.floor(), read_model(FOLDER / f"{name}.sdf"))))


def test_the_walker_stands_on_its_legs(ground, advance):
    world = ground("hexapod")
    advance(world, 2.0)
    pose = world.model_motion("hexapod").pose
    assert pose.position[2] == pytest.approx(Hexapod().height, abs=0.015)
    assert pose.rpy == pytest.approx((0, 0, 0), abs=0.01)
    assert abs(world.joint_states("hexapod").positions).max() < 0.05


def test_the_walker_walks_on_three_legs_at_a_time(ground, advance):
    world = ground("hexapod")
    advance(world, 0.5)
    legs = [
        (f"{place}_{side}", (i + j) % 2 * pi)
        for i, (side, _) in enumerate(SIDES)
        for j, (place, _) in enumerate(PLACES)
    ]
    commands = {
        (leg, joint): world.advertise(f"/hexapod/{leg}_{joint}/cmd_pos")
        for leg, _ in legs
        for joint in ("alpha", "beta")
    }
    start_ns = world.now_ns
    while world.now_ns < start_ns + 5_000_000_000:
        phase = 2 * pi * 0.8 * (world.now_ns - start_ns) * 1e-9
        for leg, offset in legs:
            commands[leg, "alpha"].publish(Float64(-0.28 * cos(phase + offset)))
            commands[leg, "beta"].publish(Float64(0.35 * max(0.0, sin(phase + offset))))
        world.run_until(world.now_ns + STEP_NS)
    pose = world.model_motion("hexapod").pose
    x, y, z = pose.position
    assert x > 0.7
    assert abs(y) < 0.15
    assert z == pytest.approx(Hexapod().height, abs=0.03)
    assert abs(pose.yaw) < 0.15


def test_the_camera_head_turns_to_the_commanded_position(ground, advance):
    world = ground("pan_tilt")
    for joint, angle in (("pan", 1.0), ("tilt", -0.4)):
        world.advertise(f"/pan_tilt/{joint}/cmd_pos").publish(Float64(angle))
    advance(world, 2.0)
    states = world.joint_states("pan_tilt")
    reached = dict(zip(states.names, states.positions, strict=True))
    assert reached["pan"] == pytest.approx(1.0, abs=0.02)
    assert reached["tilt"] == pytest.approx(-0.4, abs=0.02)


def test_the_two_wheeler_drives_an_arc(ground):
    world = ground("pioneer")
    commands = world.advertise("/pioneer/cmd_vel")
    for _ in range(100):
        commands.publish(Twist(Vector3(0.4), Vector3(0, 0, 0.5)))
        world.run_until(world.now_ns + STEP_NS)
    pose = world.model_motion("pioneer").pose
    assert pose.yaw == pytest.approx(1.0, abs=0.03)
    assert pose.position[:2] == pytest.approx((0.8 * sin(1.0), 0.8 * (1 - cos(1.0))), abs=0.04)
    assert pose.position[2] == pytest.approx(0.0975, abs=0.005)
