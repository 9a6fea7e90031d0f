"""Buoyancy, thrusters and drag against their formulas."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import atan2, pi

import numpy as np
import pytest
from medium_bodies import WATER, G, box, link, model, plugin, run

from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import ModelMotion, Pose
from nrp_core.world.world import World

UNIFORM = WATER.format("<uniform_fluid_density>1000</uniform_fluid_density>")
SEA = WATER.format(
    "<graded_buoyancy><default_density>1025</default_density>"
    "<density_change><above_depth>0</above_depth><density>1</density></density_change></graded_buoyancy>"
)
SIZE = (0.5, 0.25, 0.108)
VOLUME = 0.5 * 0.25 * 0.108
"""A box of the volume that PX4 gives to its BlueROV2 Heavy."""
DAMPING = "".join(f"<{each}>{value}</{each}>" for each, value in (
    ("xU", -25), ("yV", -25), ("zW", -30), ("kP", -5), ("mQ", -5), ("nR", -5),
    ("zWabsW", -60), ("xUabsU", -60)
))  # fmt: skip


def hydrodynamics(text: str) -> str:
    return plugin("Hydrodynamics", f"<link_name>base</link_name>{text}")


def rov(mass: float, com: str = "0 0 0 0 0 0", more: str = "", at: str = "0 0 -2 0 0 0") -> str:
    return model(link("base", mass, (0.25, 0.22, 0.36), com=com, shape=box(*SIZE)) + more, at)


def test_a_neutral_body_stays_where_it_is(open_world):
    world = open_world(UNIFORM + rov(1000 * VOLUME))
    run(world, 2.0)
    assert world.model_motion("body").pose.position == pytest.approx((0, 0, -2), abs=1e-6)


def test_a_submerged_vehicle_floats_at_its_trim(open_world):
    """The centre of mass comes to lie below that of buoyancy."""
    slow = DAMPING.replace("-5<", "-1.5<")  # about critical
    world = open_world(UNIFORM + rov(1000 * VOLUME, "0.004 0.002 -0.02 0 0 0", hydrodynamics(slow)))
    run(world, 4.0)
    motion = world.model_motion("body")
    roll, pitch, _ = motion.pose.rpy
    assert pitch == pytest.approx(atan2(0.004, np.hypot(0.002, 0.02)), abs=1e-4)
    assert roll == pytest.approx(atan2(-0.002, 0.02), abs=1e-4)
    x, y, _ = motion.pose.rotate((0.004, 0.002, -0.02))
    assert (x, y) == pytest.approx((0, 0), abs=1e-5)


def test_a_vehicle_at_the_surface_has_the_draught_of_its_mass(open_world):
    mass = 9.0
    world = open_world(SEA + rov(mass, "0 0 -0.03 0 0 0", hydrodynamics(DAMPING), "0 0 -0.02 0 0 0"))
    run(world, 4.0)
    area = SIZE[0] * SIZE[1]
    draught = (mass - VOLUME) / (1024 * area)  # the air carries a part, too
    assert world.model_motion("body").pose.position[2] == pytest.approx(SIZE[2] / 2 - draught, abs=1e-4)


def test_a_floating_ball_swings_with_the_frequency_of_its_waterline(open_world):
    """A half-submerged ball: its stiffness is density times gravity times the area of the waterline."""
    radius = 0.1
    mass = 2 / 3 * pi * radius**3 * 1025
    ball = f"<geometry><sphere><radius>{radius}</radius></sphere></geometry>"
    world = open_world(
        SEA.replace("<density>1<", "<density>0<")
        + model(link("base", mass, (0.01,) * 3, shape=ball), "0 0 0.002 0 0 0")
    )
    heights = []
    for _ in range(600):
        run(world, 0.002)
        heights.append(world.model_motion("body").pose.position[2])
    rate = np.sqrt(1025 * G * pi * radius**2 / mass)
    times = 0.002 * np.arange(1, 601)
    assert heights == pytest.approx(0.002 * np.cos(rate * times), abs=1e-4)


def test_only_enabled_models_float_and_a_spawned_one_does(open_world):
    named = UNIFORM.replace("</plugin>", "<enable>body::base</enable></plugin>")
    heavy = rov(1000 * VOLUME, at="3 0 -2 0 0 0").replace('name="body"', 'name="other"')
    world = open_world(named + rov(1000 * VOLUME) + heavy)
    run(world, 0.5)
    assert world.model_motion("body").linear == pytest.approx((0, 0, 0), abs=1e-6)
    assert world.model_motion("other").linear[2] == pytest.approx(-G * 0.5, rel=1e-3)
    body = world.scene.model("body")
    world.delete("body")
    world.spawn(body)
    run(world, 0.5)
    assert world.model_motion("body").linear == pytest.approx((0, 0, 0), abs=1e-6)


def weightless(text: str) -> str:
    return text.replace("<inertial>", "<gravity>false</gravity><inertial>")


PROPELLER = (
    link("propeller", 0.05, (1e-4,) * 3, at="-0.3 0 0 0 1.5707963267948966 0")
    + '<joint name="shaft" type="revolute"><parent>base</parent><child>propeller</child>'
    "<axis><xyz>0 0 1</xyz></axis></joint>"
)


def thruster(text: str) -> str:
    return plugin(
        "Thruster",
        "<joint_name>shaft</joint_name><thrust_coefficient>0.02</thrust_coefficient><propeller_diameter>0.1</propeller_diameter>"
        f"<fluid_density>1000</fluid_density>{text}",
    )


@pytest.mark.parametrize("by_speed", [False, True])
def test_a_vehicle_reaches_the_speed_at_which_drag_is_thrust(open_world, by_speed):
    thrust = 20.0
    speed = np.sqrt(thrust / (1000 * 0.02 * 0.1**4))
    text = "<use_angvel_cmd>true</use_angvel_cmd>" if by_speed else ""
    more = PROPELLER + thruster(text) + hydrodynamics(DAMPING)
    world = open_world(weightless(rov(13.0, more=more)))
    topic = "/model/body/joint/shaft/"
    pull = world.advertise(f"{topic}{'cmd_vel' if by_speed else 'cmd_thrust'}")
    pull.publish(Float64(speed if by_speed else thrust))
    state = world.subscribe(f"{topic}{'force' if by_speed else 'ang_vel'}")
    run(world, 3.0)
    reached = (-25 + np.sqrt(25**2 + 4 * 60 * thrust)) / (2 * 60)
    assert world.model_motion("body").linear[0] == pytest.approx(reached, rel=2e-3)
    assert state.latest.message.data == pytest.approx(thrust if by_speed else speed, rel=1e-9)
    assert world.joint_states("body").velocities[0] == pytest.approx(speed, rel=0.02)


def test_a_current_takes_all_vehicles_along(open_world):
    one = rov(1000 * VOLUME, more=hydrodynamics(DAMPING))
    two = one.replace('name="body"', 'name="other"').replace("<pose>0 0 -2", "<pose>3 0 -2")
    world = open_world(UNIFORM + one + two)
    world.advertise("/ocean_current").publish(Vector3(0.3, -0.2, 0.0))
    run(world, 2.0)
    world.delete("other")
    world.advertise("/ocean_current").publish(Vector3(0.3, -0.2, 0.0))
    run(world, 2.0)
    assert world.model_motion("body").linear == pytest.approx((0.3, -0.2, 0), abs=3e-3)


@pytest.mark.parametrize("added", [0.5, 5.0, 50.0])
def test_a_body_sinks_with_its_added_mass(open_world, added):
    """Above the body's own mass, forces at the start of a step would double in each."""
    mass = 20.0
    load = f"<zDotW>{-added * mass}</zDotW>"
    world = open_world(UNIFORM + rov(mass, more=hydrodynamics(load)))
    run(world, 0.1)
    before = world.model_motion("body").linear[2]
    run(world, 0.5)
    gain = (1000 * VOLUME - mass) * G / (mass + added * mass)
    assert (world.model_motion("body").linear[2] - before) / 0.5 == pytest.approx(gain, rel=1e-6)


def test_a_body_in_ideal_fluid_keeps_its_energy_and_momentum(open_world):
    """Kirchhoff's equations: energy and momentum of body and fluid are those of M + A."""
    mass, moments = 5.0, np.array([0.1, 0.2, 0.15])
    added, turned = np.array([2.0, 6.0, 9.0]), np.array([0.05, 0.1, 0.02])
    names = dict(zip(("xDotU", "yDotV", "zDotW", "kDotP", "mDotQ", "nDotR"), (*added, *turned), strict=True))
    text = "".join(f"<{name}>{-value}</{name}>" for name, value in names.items())
    world = open_world(weightless(model(link("base", mass, moments) + hydrodynamics(text))), step="1 ms")
    world.place("body", ModelMotion(Pose(), (0.5, 0.2, -0.1), (0.3, -0.8, 1.0)))

    def totals() -> tuple[float, np.ndarray]:
        motion = world.model_motion("body")
        linear, angular = (
            np.array(motion.pose.rotate_back(each)) for each in (motion.linear, motion.angular)
        )
        push = (mass + added) * linear
        energy = 0.5 * (push @ linear + (moments + turned) @ angular**2)
        return energy, np.array(motion.pose.rotate(tuple(push)))

    run(world, 0.01)
    energy, momentum = totals()
    run(world, 1.5)
    later, kept = totals()
    assert later == pytest.approx(energy, rel=0.01)
    assert kept == pytest.approx(momentum, abs=0.02 * np.linalg.norm(momentum))


ALONG, ACROSS, LENGTH = 2.0, 4.0, 0.1


def drag(*links: str) -> str:
    each = "".join(f'<link length="{LENGTH}">{name}</link>' for name in links)
    return plugin("nrp_drag", f"<along>{ALONG}</along><across>{ACROSS}</across>{each}", "drag")


def test_a_slender_body_sinks_at_an_angle_in_a_viscous_fluid(open_world):
    """A step is 40 to 80 times as long as the time in which drag stops it."""
    mass, tilt = 1e-5, 0.6
    rod = link("rod", mass, (1e-9, 1e-8, 1e-8)) + drag("rod")
    world = open_world(model(rod, f"0 0 0 0 {tilt} 0"))
    run(world, 0.1)
    motion = world.model_motion("body")
    weight = mass * G
    axis = np.array([np.cos(tilt), 0, -np.sin(tilt)])
    force = np.array([0, 0, -weight])
    part = (force @ axis) * axis
    expected = part / (ALONG * LENGTH) + (force - part) / (ACROSS * LENGTH)
    assert motion.linear == pytest.approx(expected, rel=1e-3, abs=1e-9)
    assert motion.pose.rpy[1] == pytest.approx(tilt, abs=1e-6)


def chain(count: int) -> str:
    """Return slender links on joints that follow positions, in drag that stops them within a step."""
    parts = []
    for number in range(count):
        parts.append(link(f"l{number}", 1e-4, (1e-8, 1e-7, 1e-7), at=f"{LENGTH * number} 0 0 0 0 0"))
        if number:
            parts.append(
                f'<joint name="j{number}" type="revolute"><pose>{-LENGTH / 2} 0 0 0 0 0</pose>'
                f"<parent>l{number - 1}</parent><child>l{number}</child><axis><xyz>0 0 1</xyz></axis></joint>"
            )
    names = [f"l{number}" for number in range(count)]
    return weightless(model("".join(parts) + drag(*names)))


def with_servos(scene: Scene) -> Scene:
    body = scene.model("body")
    controllers = tuple(JointController(each.name, "position", f"/{each.name}", None) for each in body.joints)
    return replace(scene, models=(replace(body, controllers=controllers),))


def swim(world: World, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Send a wave along the joints; return the angles and the ways of the first link."""
    joints = [world.advertise(f"/j{number}") for number in range(1, 6)]
    angles, ways = [], []
    for step in range(round(seconds / 0.01)):
        for number, joint in enumerate(joints):
            joint.publish(Float64(0.5 * np.sin(2 * pi * (0.01 * step - number / 5))))
        run(world, 0.01)
        pose = world.model_motion("body").pose
        angles.append(world.joint_states("body").positions)
        ways.append((*pose.position[:2], pose.yaw))
    return np.array(angles), np.array(ways)


def resistive_force_path(angles: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the path on which drag on the links has neither a force nor a torque (Gray and Hancock 1955)."""
    path = [start]
    for before, after in pairwise(angles):
        yaw = path[-1][2]
        turns = np.concatenate([[0.0], np.cumsum((before + after) / 2)]) + yaw
        rates = np.concatenate([[0.0], np.cumsum(after - before)])
        ways = LENGTH * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        centres = np.cumsum(np.vstack([np.zeros(2), (ways[:-1] + ways[1:]) / 2]), axis=0)
        normals = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
        turning = normals * rates[:, None]
        spins = np.cumsum(np.vstack([np.zeros(2), (turning[:-1] + turning[1:]) / 2]), axis=0)
        drags = np.zeros((3, 3))
        push = np.zeros(3)
        for way, (cx, cy), spin, rate in zip(ways / LENGTH, centres, spins, rates, strict=True):
            slow = LENGTH * (ACROSS * np.eye(2) + (ALONG - ACROSS) * np.outer(way, way))
            by = np.array([[1, 0, -cy], [0, 1, cx]])
            drags += by.T @ slow @ by
            push += by.T @ slow @ spin
            drags[2, 2] += LENGTH**3 / 12 * ACROSS
            push[2] += LENGTH**3 / 12 * ACROSS * rate
        path.append(path[-1] - np.linalg.solve(drags, push))
    return np.array(path)


def test_a_chain_in_stiff_drag_swims_as_resistive_force_theory_says(open_world):
    """Drag stops its links within a step; in the theory they have no mass."""
    world = open_world(chain(6), step="1 ms", change=with_servos)
    angles, ways = swim(world, 1.5)
    expected = resistive_force_path(angles[30:], ways[30])
    swum = np.linalg.norm(expected[-1, :2] - expected[0, :2])
    assert swum > 0.015
    assert ways[30:] == pytest.approx(expected, abs=0.04 * swum)


def test_a_saved_state_continues_as_before(open_world):
    more = hydrodynamics(DAMPING + "<xDotU>-6</xDotU><zDotW>-15</zDotW>") + PROPELLER + thruster("")
    world = open_world(UNIFORM + rov(13.0, "0 0 -0.02 0 0 0", more))
    world.advertise("/model/body/joint/shaft/cmd_thrust").publish(Float64(15.0))
    run(world, 0.5)
    saved = world.snapshot()
    ways = []
    for goes_back in (
        lambda: None,
        lambda: world.restore(saved),
        lambda: (world.reset(), world.restore(saved)),
    ):
        goes_back()
        run(world, 0.3)
        ways.append(world.model_motion("body"))
    for each in ways[1:]:
        assert each.linear == pytest.approx(ways[0].linear, abs=1e-12)
    world.reset()
    world.advertise("/model/body/joint/shaft/cmd_thrust").publish(Float64(15.0))
    run(world, 0.8)
    ways.append(world.model_motion("body"))
    for each in ways[1:]:
        assert each.pose.position == pytest.approx(ways[0].pose.position, abs=1e-7)
        assert each.linear == pytest.approx(ways[0].linear, abs=1e-6)
