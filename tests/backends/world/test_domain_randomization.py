"""Drawn properties act as the closed forms say, and each copy of a scene is what its seed gives alone."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

import jointed
import numpy as np
import pytest

from nrp_core.scene.devices import JointController, Noise, Pid
from nrp_core.scene.model import Box, Inertial, Joint, Light, Link, Model, Scene
from nrp_core.scene.randomization import Randomization
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_scene
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.sensors.navigation import Imu

SEEDS = (1, 2, 3)
TILT = radians(30)
SLOPE = Pose.from_rpy((0, 0, 0), 0, TILT, 0)  # down along x


def drawn(world, quantity):
    """Return the numbers drawn for the one part that has a quantity."""
    (values,) = [each.values for each in world.randomized if each.quantity == quantity]
    return values


def one_joint(damping=20.0):
    """Return a bob of 2 kg on a vertical rail, held by a controller with gains."""
    bob = Link("bob", inertial=Inertial(2.0, inertia=(0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
    rail = Joint("rail", "prismatic", "world", "bob", damping=damping)
    held = JointController("rail", "position", "/bob/rail", Pid(200.0, 0.0, 40.0), initial=0.0)
    return Model("bob", (bob,), (rail,), controllers=(held,), joint_states_topic="/bob/joint_states")


def test_a_force_accelerates_the_drawn_mass(open_world, parts, advance):
    block = replace(parts.prop("robot", Box((0.2, 0.2, 0.2)), mass=3.0))
    mass = Randomization("mass", "robot/link", "scale", 0.5, 2.0, "log_uniform")
    scene = Scene((block,), gravity=(0.0, 0.0, 0.0), randomize=(mass,))
    speeds = []
    for seed in SEEDS:
        world = open_world(scene, seed=seed)
        jointed.push(world, "link", force=(6.0, 0.0, 0.0), torque=(0.0, 0.0, 0.03))
        advance(world, 1.0)
        motion, heavier = world.model_motion("robot"), drawn(world, "mass")[0]
        assert motion.linear[0] == pytest.approx(6.0 / (3.0 * heavier), rel=1e-2)
        assert motion.angular[2] == pytest.approx(0.03 / (0.03 * heavier), rel=1e-2)  # moment m / 100
        speeds.append(motion.linear[0])
    assert len(set(speeds)) == len(SEEDS)


def test_a_box_slides_by_the_drawn_friction(open_world, parts, advance):
    plane = parts.prop("slope", Box((20, 20, 1)), SLOPE @ Pose((0, 0, -0.5)))
    slider = parts.prop("slider", Box((0.4, 0.4, 0.2)), SLOPE @ Pose((0, 0, 0.1)), mass=3.0)
    rubs = Randomization("friction", "slider/.*", "range", 0.1, 0.4)
    for seed in SEEDS:
        world = open_world(Scene((plane, slider), randomize=(rubs,)), seed=seed)
        advance(world, 1.0)
        speed = np.linalg.norm(world.model_motion("slider").linear)
        friction = drawn(world, "friction")[0]
        assert speed == pytest.approx(9.8 * (sin(TILT) - friction * cos(TILT)), rel=0.03)


def test_a_box_of_an_mjcf_file_slides_by_the_drawn_friction(open_world, advance, tmp_path):
    place = "0.05 0 0.0866"  # of a box of 0.2 m that touches the slope
    (tmp_path / "slope.xml").write_text(
        '<mujoco><worldbody><geom name="slope" type="plane" size="9 9 1" euler="0 30 0" friction="0.9"/>'
        f'<body name="slider" pos="{place}" euler="0 30 0"><freejoint/>'
        '<geom type="box" size="0.1 0.1 0.1" friction="0.9"/></body></worldbody></mujoco>'
    )
    rubs = Randomization("friction", ".*", "scale", 0.1, 0.4, shared=True)
    scene = replace(read_scene(tmp_path / "slope.xml"), gravity=(0.0, 0.0, -9.8), randomize=(rubs,))
    for seed in SEEDS:
        world = open_world(scene, seed=seed)
        advance(world, 0.5)
        speed = np.linalg.norm(world.model_motion("slider").linear)
        (factor,) = {each.values for each in world.randomized}
        assert speed == pytest.approx(0.5 * 9.8 * (sin(TILT) - 0.9 * factor[0] * cos(TILT)), rel=0.03)


def test_a_joint_sinks_by_its_load_over_the_drawn_gain(open_world, advance):
    gains = Randomization("gains", "bob/rail", "scale", 0.5, 2.0)
    for seed in SEEDS:
        world = open_world(Scene((one_joint(),), randomize=(gains,)), seed=seed)
        advance(world, 3.0)
        p, _, d = drawn(world, "gains")
        assert world.joint_states("bob").positions[0] == pytest.approx(-2.0 * 9.8 / (200.0 * p), rel=1e-3)
        assert p != d


def test_a_laser_measures_from_where_it_was_drawn(open_world, parts):
    scanner = Laser("laser", "/scan", 10.0, samples=1, angle_min=0.0, angle_max=0.0, pose=Pose((0, 0, 1)))
    holder = Model("holder", (Link("base", sensors=(scanner,)),), static=True)
    ranges = (
        Randomization("sensor_position", "holder/base/laser", "add", -0.1, 0.1),
        Randomization("sensor_orientation", "holder/base/laser", "add", -0.2, 0.2, "normal"),
    )
    for seed in SEEDS:
        world = open_world(Scene((parts.wall(2.0), holder), randomize=ranges), seed=seed)
        scans = world.subscribe("/scan")
        world.run_until(200_000_000)
        _, pitch, yaw = drawn(world, "sensor_orientation")
        along = 2.0 - drawn(world, "sensor_position")[0]
        assert scans.latest.message.ranges[0] == pytest.approx(along / (cos(pitch) * cos(yaw)), rel=1e-5)


@pytest.fixture
def varied(parts):
    """Return a scene in which everything is drawn that a seed can change."""
    imu = Imu("imu", "/imu", 50.0, noise=Noise(0.0, 0.1))
    slider = parts.prop("slider", Box((0.4, 0.4, 0.2)), SLOPE @ Pose((0, 0, 0.1)), mass=3.0)
    slider = replace(slider, links=(replace(slider.links[0], sensors=(imu,)),))
    plane = parts.prop("slope", Box((20, 20, 1)), SLOPE @ Pose((0, 0, -0.5)))
    ranges = (
        Randomization("mass", ".*", "scale", 0.5, 2.0),
        Randomization("friction", "slider/link", "range", 0.1, 0.4),
        Randomization("gains", "bob/.*", "scale", 0.5, 2.0),
        Randomization("light", "sun", "scale", 0.5, 1.5),
        Randomization("sensor_noise", "slider/link/imu", "scale", 0.5, 2.0),
    )
    aside = replace(one_joint(2.0), pose=Pose((0.0, 5.0, 9.0)))
    return Scene((plane, slider, aside), (Light("sun"),), randomize=ranges)


def look(world, samples):
    """Return motion, joints, the last measurement, and the lights after half a second."""
    world.run_until(world.now_ns + 500_000_000)
    motion, states = world.model_motion("slider"), world.joint_states("bob")
    reached = motion.pose.position, motion.linear, states.positions.tobytes(), states.efforts.tobytes()
    return reached, samples.latest.message.linear_acceleration, world.scene.lights


def test_each_copy_is_bit_for_bit_what_its_seed_gives_alone(backend, varied):
    options = backend.options()

    def alone(seed):
        with backend.open(varied, seed=seed, options=options) as world:
            return look(world, world.subscribe("/imu"))

    with backend.open_batch(varied, seeds=SEEDS, options=options) as batch:
        samples = batch.subscribe("/imu")
        seen = [look(world, each) for world, each in zip(batch.worlds, samples, strict=True)]
        assert seen == [alone(seed) for seed in SEEDS]
        assert len({str(one) for one in seen}) == len(SEEDS)
        batch.reset(seeds=[5, 2, 1])  # others, the same, and one that another copy had
        again = [look(world, each) for world, each in zip(batch.worlds, samples, strict=True)]
        assert again == [alone(5), seen[1], seen[0]]


def test_a_snapshot_brings_back_what_was_drawn(backend, varied):
    with backend.open(varied, seed=1, options=backend.options()) as world:
        samples = world.subscribe("/imu")
        start = world.snapshot()
        first, drawn_first = look(world, samples), world.randomized
        world.reset(seed=2)
        assert look(world, samples) != first
        world.restore(start)
        assert (look(world, samples), world.randomized, world.seed) == (first, drawn_first, 1)
