"""Wheels that drive by friction alone: near the ideal where nothing slips, and slipping as real ones do."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from math import cos, degrees, radians, sin
from pathlib import Path

import numpy as np
import pytest

from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model

SECONDS = 2.0


def two_wheeler():
    """Return a robot with two wheels and a caster that slides."""
    return read_model(Path(str(files("nrp_experiments.bodies") / "pioneer.sdf")), name="pioneer")


def with_drive(model, **changes):
    return replace(model, drives=(replace(model.drives[0], **changes),))


def ideal(forward, turn):
    """Return where a unicycle is after the time: x, y (m), heading (degrees)."""
    heading = turn * SECONDS
    if not turn:
        return forward * SECONDS, 0.0, 0.0
    return forward / turn * sin(heading), forward / turn * (1 - cos(heading)), degrees(heading)


@pytest.mark.parametrize(("forward", "turn"), [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (-0.3, -0.8)])
def test_two_wheels_go_nearly_as_commanded(open_world, parts, driver, forward, turn):
    world = open_world(parts.floor(), two_wheeler(), drive="physical")
    start = world.model_motion("pioneer").pose
    pose = start.inverse() @ driver(world, "pioneer").drive(forward, turn, SECONDS)
    x, y, heading = ideal(forward, turn)
    assert pose.position[:2] == pytest.approx((x, y), abs=0.08)
    assert degrees(pose.yaw) == pytest.approx(heading, abs=10 if forward else 3)


def test_a_skid_steered_robot_goes_straight_and_turns_too_little(open_world, parts, driver):
    world = open_world(parts.floor(), parts.husky(), drive="physical")
    pose = driver(world).drive(0.5, 0.0, SECONDS)
    assert pose.position[:2] == pytest.approx((1.0, 0.0), abs=0.02)
    world.reset()
    turned = driver(world).drive(0.0, 0.5, SECONDS).yaw / (0.5 * SECONDS)
    assert 0.1 < turned < 0.4
    joints = world.joint_states("husky")
    assert joints.velocities[joints.names.index("front_right")] == pytest.approx(
        0.5 * 0.571 / 2 / 0.17775, rel=0.15
    )


def test_a_wider_separation_in_the_file_makes_it_turn_more(open_world, parts, driver):
    turned = []
    for factor in (1.0, 1.875):
        robot = with_drive(parts.husky(), separation=factor * 0.571)
        world = open_world(parts.floor(), robot, drive="physical")
        turned.append(driver(world).drive(0.0, 0.5, SECONDS).yaw)
    assert turned[1] > 1.5 * turned[0]


def test_on_ice_wheels_spin_in_vain(open_world, parts, driver):
    moved = {}
    for drive in ("planar", "physical"):
        world = open_world(parts.floor(friction=0.0), parts.husky(), drive=drive)
        moved[drive] = driver(world).drive(0.5, 0.0, 1.0).position[0]
    assert moved["planar"] == pytest.approx(0.5, abs=0.02)
    assert abs(moved["physical"]) < 0.02


def test_weak_motors_take_their_time(open_world, parts, driver):
    torque, mass = 1.0, 33.855 + 1.0 + 4 * 2.6357
    world = open_world(parts.floor(), with_drive(parts.husky(), torque=torque), drive="physical")
    driver(world).drive(1.0, 0.0, 1.0)
    spinning = 4 * 0.0441 / 0.17775**2  # what the wheels' inertia adds to the mass
    speed = 4 * torque / 0.17775 / (mass + spinning)
    assert world.model_motion("husky").linear[0] == pytest.approx(speed, rel=0.1)


def test_a_robot_stays_on_a_slope(open_world, parts, driver):
    tilt = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, radians(-10), 0.0)
    floor = replace(parts.floor(), pose=tilt)
    robot = parts.husky(pose=tilt @ Pose((0.0, 0.0, parts.standing)))
    world = open_world(floor, robot, drive="physical")
    start = driver(world).drive(0.0, 0.0, 0.5).position
    assert driver(world).drive(0.0, 0.0, 1.0).position == pytest.approx(start, abs=0.02)
    uphill = driver(world).drive(0.5, 0.0, 1.0).position[0] - start[0]
    assert uphill == pytest.approx(0.5 * cos(radians(10)), abs=0.05)


def states(world):
    motion, joints = world.model_motion("husky"), world.joint_states("husky")
    return motion, joints.positions.tobytes(), joints.velocities.tobytes()


def test_runs_resets_and_snapshots_are_exact(open_world, parts, driver):
    scene = Scene((parts.floor(), parts.wall(1.2), parts.husky()))
    world, other = open_world(scene, drive="physical"), open_world(scene, drive="physical")
    driver(world).drive(0.6, 0.4, 1.0)
    kept = world.snapshot()
    driver(world).drive(0.8, -0.7, 1.5)
    end = states(world)
    world.restore(kept)
    driver(world).drive(0.8, -0.7, 1.5)
    assert states(world) == end
    world.reset()
    for each in (world, other):
        driver(each).drive(0.6, 0.4, 1.0)
        driver(each).drive(0.8, -0.7, 1.5)
        assert states(each) == end


def test_the_engines_agree_where_nothing_slips(engines, parts, driver):
    ends = []
    for backend in engines:
        scene = Scene((parts.floor(), two_wheeler()))
        with backend.open(scene, seed=1, options=backend.options(drive="physical")) as world:
            ends.append(driver(world, "pioneer").drive(0.4, 0.3, SECONDS).position)
    assert np.hypot(*np.subtract(*ends)[:2]) < 0.05
