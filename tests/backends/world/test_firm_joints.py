"""Joints without gains in their files reach what is commanded, with any load that their limits allow."""

from __future__ import annotations

from ctypes import CDLL
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from chains import GRAVITY, LENGTH, LINKS, MASS, chain, command

from nrp_core.messages.base import Duration
from nrp_core.messages.trajectory_msgs import JointTrajectory, JointTrajectoryPoint
from nrp_core.scene.devices import JointController, Pid, TrajectoryController
from nrp_core.scene.merged_bodies import stiff_gains
from nrp_core.scene.model import Box, Collision, Cylinder, Inertial, Joint, Link, Model, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.engine_kit.jointed import JointedEngine

RADIUS = 0.1


def cart(gains: Pid | None) -> Model:
    """Return a body of 20 kg on two wheels with motors, and on two casters that slide."""
    body = Link(
        "body",
        Pose((0.0, 0.0, RADIUS)),
        Inertial(20.0, Pose((0.0, 0.0, 0.1)), (0.5, 0.5, 0.5, 0.0, 0.0, 0.0)),
        collisions=tuple(
            Collision(f"c{x}", Sphere(0.03), Pose((x, 0.0, 0.03 - RADIUS)), friction=0.0) for x in (-0.2, 0.2)
        ),
    )
    lying = Pose.from_rpy((0.0, 0.0, 0.0), -pi / 2, 0.0, 0.0)
    wheels = [
        Link(
            name,
            Pose((0.0, y, RADIUS)),
            Inertial(1.0, inertia=(3e-3, 5e-3, 3e-3, 0.0, 0.0, 0.0)),
            collisions=(Collision("tyre", Cylinder(RADIUS, 0.04), lying),),
        )
        for name, y in (("left", 0.25), ("right", -0.25))
    ]
    joints = [
        Joint(
            f"{wheel.name}_joint", "continuous", "body", wheel.name, wheel.pose, (0.0, 1.0, 0.0), effort=20.0
        )
        for wheel in wheels
    ]
    control = [
        JointController(each.name, "velocity", f"/cart/{each.name}/velocity", gains) for each in joints
    ]
    return Model(
        "cart", (body, *wheels), tuple(joints), controllers=tuple(control), joint_states_topic="/joints"
    )


def rolled(world, advance) -> tuple[float, float]:
    """Return the speed of the wheels 0.2 s after a command of 1 rad/s, and the way (m) within 1 s."""
    advance(world, 0.2)
    start = world.model_motion("cart").pose.position[0]
    for wheel in ("left_joint", "right_joint"):
        command(world, 1.0, joint=wheel, kind="velocity", model="cart")
    advance(world, 0.2)
    speed = float(world.joint_states("cart").velocities.min())
    advance(world, 0.8)
    return speed, world.model_motion("cart").pose.position[0] - start


def test_wheels_that_carry_a_robot_have_the_commanded_speed_after_a_fifth_of_a_second(
    open_world, parts, advance
):
    speed, way = rolled(open_world(parts.floor(), cart(None)), advance)
    assert speed == pytest.approx(1.0, abs=0.01)
    # the command begins after 20 ms at the latest, and the speed approaches it with 40 ms
    assert way == pytest.approx(RADIUS * (1.0 - 0.04), abs=RADIUS * 0.03)
    wrong, _ = rolled(open_world(parts.floor(), cart(stiff_gains(5e-3, velocity=True))), advance)
    assert wrong < 0.9  # a gain from the inertia of the wheel alone


def test_an_arm_stays_within_a_milliradian_of_its_command_under_gravity(open_world, advance):
    world = open_world(chain())
    goals = [-0.3 + 0.05 * i for i in range(LINKS)]
    for i, goal in enumerate(goals):
        command(world, goal, joint=f"j{i}")
    advance(world, 1.0)
    states = world.joint_states("chain")
    assert states.positions == pytest.approx(goals, abs=1e-3)
    # the efforts hold the rods outside of each joint
    pitch = np.cumsum(goals)
    tips = np.concatenate([[0.0], np.cumsum(LENGTH * np.cos(pitch))])
    centres = tips[:-1] + LENGTH / 2 * np.cos(pitch)
    held = [-MASS * GRAVITY * (centres[i:] - tips[i]).sum() for i in range(LINKS)]
    assert states.efforts == pytest.approx(held, rel=0.01, abs=0.05)


def test_no_effort_and_no_speed_is_beyond_the_limits_of_a_joint(open_world, advance):
    world = open_world(chain(effort=100.0, velocity=0.8))
    command(world, -1.0)
    seen = []
    for _ in range(75):
        advance(world, 0.02)
        states = world.joint_states("chain")
        seen.append((states.efforts[0], states.velocities[0]))
    efforts, speeds = np.array(seen).T
    assert abs(efforts).max() <= 100.0 * (1 + 1e-9)
    assert -0.8 * 1.01 < speeds.min() < -0.8 * 0.98
    assert world.joint_states("chain").positions[0] == pytest.approx(-1.0, abs=1e-3)


def test_a_load_beyond_the_limit_of_effort_pulls_the_joint_along(open_world, advance):
    weak = MASS * GRAVITY * LENGTH / 2 / 2  # half of what the rod needs
    world = open_world(chain(effort=weak, links=1))
    command(world, 0.0)
    advance(world, 0.1)
    inertia = 1e-2 + MASS * (LENGTH / 2) ** 2
    assert world.joint_states("chain").positions[0] == pytest.approx(weak / inertia * 0.1**2 / 2, rel=0.15)
    assert world.joint_states("chain").efforts[0] == pytest.approx(-weak)


def test_a_joint_without_a_limit_of_effort_does_not_crush_the_world(open_world, parts, advance):
    rod = chain(links=1)
    tip = replace(rod.links[0], collisions=(Collision("tip", Box((0.04, 0.04, 0.04)), Pose((LENGTH, 0, 0))),))
    world = open_world(replace(rod, links=(tip,)), parts.prop("wall", Box((1, 1, 0.1)), Pose((0, 0, 1.9))))
    command(world, 1.5)
    advance(world, 1.0)
    assert world.joint_states("chain").positions[0] == pytest.approx(0.15, abs=0.03)
    assert world.joint_states("chain").efforts[0] <= 10.01 * MASS * 9.81 * LENGTH / 2


@pytest.mark.parametrize(("kind", "damping"), [("position", 0.05), ("velocity", 5.0)])
def test_a_firm_joint_goes_on_from_a_snapshot_and_after_a_reset(
    open_world, advance, require_to_go_on, kind, damping
):
    """Also in a world where its damper acted and other gains held."""
    loose = chain(kind=kind, effort=200.0, velocity=2.0)
    joints = tuple(replace(joint, damping=damping) for joint in loose.joints)
    soft = JointController("j0", "velocity", "/chain/j0/soft", Pid(500.0))
    damped = replace(loose, joints=joints, controllers=(*loose.controllers, soft))

    def look(world):
        states = world.joint_states("chain")
        return states.positions.tolist(), states.velocities.tolist(), states.efforts.tolist()

    world, other = open_world(damped), open_world(damped)
    command(other, 1.0, kind="soft")
    command(world, 0.5, kind=kind)
    advance(world, 0.06)
    first = look(world)
    command(world, -0.4, joint="j3", kind=kind)
    advance(world, 0.06)
    require_to_go_on(world, other, 0.2, look)
    world.restore(world.snapshot())
    world.reset()
    command(world, 0.5, kind=kind)
    assert not world.joint_states("chain").efforts.any()
    advance(world, 0.06)
    assert look(world) == first


def test_a_trajectory_is_followed_within_two_milliradians(open_world, advance, monkeypatch):
    single = []
    plain = JointedEngine._do_set_servo_target
    monkeypatch.setattr(
        JointedEngine, "_do_set_servo_target", lambda *given: single.append(given[2]) or plain(*given)
    )
    led = TrajectoryController("lead", "/chain/lead", tuple(f"j{i}" for i in range(LINKS)))
    world = open_world(replace(chain(), controllers=(), trajectory_controllers=(led,)))
    times = np.linspace(0.05, 1.0, 20)
    points = [
        JointTrajectoryPoint(
            [0.3 * (1 - np.cos(pi * t))] * LINKS,
            [0.3 * pi * np.sin(pi * t)] * LINKS,
            [],
            time_from_start=Duration(0, round(t * 1e9)) if t < 1 else Duration(1),
        )
        for t in times
    ]
    world.advertise("/chain/lead").publish(JointTrajectory(joint_names=list(led.joints), points=points))
    for _ in range(48):
        advance(world, 0.02)
        t = world.now_ns / 1e9
        expected = 0.3 * (1 - np.cos(pi * t))
        assert world.joint_states("chain").positions == pytest.approx(
            [expected] * LINKS, abs=2e-3
        )  # a path is a step ahead
    assert single == list(led.joints)  # the first targets; from then on those of all joints go in one call


def test_an_effort_releases_a_firm_joint(open_world, advance):
    rod = chain(links=1)
    push = JointController("j0", "effort", "/chain/j0/effort")
    world = open_world(replace(rod, controllers=(*rod.controllers, push)))
    command(world, 0.0)
    advance(world, 0.3)
    command(world, 0.0, kind="effort")
    advance(world, 0.1)
    inertia = 1e-2 + MASS * (LENGTH / 2) ** 2
    fallen = MASS * GRAVITY * LENGTH / 2 / inertia * 0.1**2 / 2
    assert world.joint_states("chain").positions[0] == pytest.approx(fallen, rel=0.1)
    assert world.joint_states("chain").efforts[0] == 0.0


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_a_weak_joint_that_falls_behind_its_path_arrives_without_swinging(open_world, advance, share):
    """A motor that is too weak for the path of a far target catches up with it, and brakes in time."""
    rod = chain(effort=share, links=1)
    world = open_world(replace(rod, joints=(replace(rod.joints[0], axis=(0.0, 0.0, 1.0)),)))
    command(world, 1.0)
    furthest = 0.0
    for _ in range(75):
        advance(world, 0.02)
        furthest = max(furthest, world.joint_states("chain").positions[0])
    assert furthest < 1.01
    assert world.joint_states("chain").positions[0] == pytest.approx(1.0, abs=1e-3)


def test_an_engine_prints_nothing_of_an_axis_that_it_rounds(open_world, capfd):
    model = chain(links=1)  # with the wrist of a humanoid, along whose principal axes PyBullet turns the axis
    wrist = Inertial(1.547, inertia=(0.0037869, 0.004071, 0.0015203, 1.63e-5, -2.52e-5, -9.24e-5))
    link = replace(model.links[0], inertial=wrist)
    joint = replace(model.joints[0], axis=(0.0, 0.0, 1.0), damping=0.05)
    open_world(replace(model, links=(link,), joints=(joint,)))
    CDLL(None).fflush(None)
    assert capfd.readouterr() == ("", "")
