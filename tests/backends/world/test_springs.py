"""Springs of joints swing, carry and come to rest as the law of Hooke says."""

from __future__ import annotations

from math import cos, exp, pi, sqrt

import pytest
from jointed import GRAVITY, MASS, MOMENT, axis, command, controlled, joint, link, push, told, weightless

from nrp_core.scene.model import Scene


def sprung(stiffness: float, *, rest: float = 0.0, damping: float = 0.0) -> str:
    spring = f"<spring_stiffness>{stiffness}</spring_stiffness><spring_reference>{rest}</spring_reference>"
    return f"<dynamics><damping>{damping}</damping>{spring}</dynamics>"


@pytest.mark.parametrize(("kind", "inertia"), [("prismatic", MASS), ("revolute", MOMENT)])
def test_a_mass_on_a_spring_swings_about_where_it_rests(open_world, read, advance, kind, inertia):
    frequency = 8.0
    spring = axis("0 0 1", sprung(inertia * frequency**2, rest=0.3))
    world = open_world(weightless(read(link("bob") + joint(kind, spring))))
    for step in range(1, 60):
        advance(world, 0.02)
        expected = 0.3 * (1 - cos(frequency * 0.02 * step))
        assert told(world)[0]["j"] == pytest.approx(expected, abs=0.01)
    assert world.joint_states("robot").efforts == pytest.approx([0.0])  # what a motor does, and there is none


def test_a_damped_spring_sags_by_its_load_over_its_stiffness(open_world, read, advance):
    suspension = axis("0 0 1", sprung(2000.0, rest=0.1, damping=150.0))
    world = open_world(read(link("bob") + joint("prismatic", suspension)))
    advance(world, 3.0)
    positions, velocities = told(world)
    assert positions["j"] == pytest.approx(0.1 - MASS * GRAVITY / 2000.0, abs=1e-5)
    assert velocities["j"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e8])
def test_any_spring_is_stable(open_world, read, advance, stiffness):
    spring = axis("0 0 1", sprung(stiffness, damping=20.0))
    world = open_world(read(link("bob") + joint("prismatic", spring)))
    world.set_joints("robot", {"j": 0.01})
    advance(world, 3.0)
    assert told(world)[0]["j"] == pytest.approx(-MASS * GRAVITY / stiffness, abs=2e-5)


def test_a_servo_and_a_spring_meet_where_their_efforts_do(open_world, read, advance):
    spring = axis("0 0 1", sprung(30.0))
    led = controlled(("j", "position", "<pid>60 0 4</pid>"))
    world = open_world(weightless(read(link("bob") + joint("revolute", spring) + led)))
    command(world, "j", "pos", 0.6)
    advance(world, 2.0)
    assert told(world)[0]["j"] == pytest.approx(0.4, abs=1e-4)
    assert world.joint_states("robot").efforts == pytest.approx([60.0 * 0.2], rel=1e-3)


def test_a_wheel_on_a_spring_decays_as_a_damped_oscillator(open_world, read, advance):
    """The first axis of a ``revolute2`` has a spring, the second spins."""
    axes = axis("1 0 0", sprung(2.0, damping=0.04)) + axis("0 1 0", tag="axis2")
    world = open_world(weightless(read(link("bob") + joint("revolute2", axes))))
    world.set_joints("robot", {"j": 0.2})
    frequency, decay = sqrt(2.0 / MOMENT), 0.04 / 2 / MOMENT
    period = 2 * pi / sqrt(frequency**2 - decay**2)
    advance(world, 0.02 * round(2 * period / 0.02))
    late = world.now_ns * 1e-9 - 2 * period
    expected = 0.2 * exp(-decay * 2 * period) * cos(2 * pi / period * late)
    assert told(world)[0]["j"] == pytest.approx(expected, abs=4e-3)


def test_a_spring_goes_on_from_a_snapshot_bit_for_bit(open_world, read, advance, require_to_go_on):
    model = read(link("bob", com=(0.1, 0.0, 0.0)) + joint("revolute", axis("0 1 0", sprung(5.0, rest=0.4))))
    world, fresh = open_world(Scene((model,))), open_world(Scene((model,)))
    advance(world, 0.2)
    require_to_go_on(world, fresh, 0.3, told)


def test_a_load_cell_feels_what_a_spring_carries(open_world, read, advance):
    cell = '<sensor name="cell" type="force_torque"><update_rate>50</update_rate></sensor>'
    hinge = joint("revolute", axis("0 1 0", sprung(50.0, damping=1.0)) + cell)
    world = open_world(read(link("bob", com=(0.2, 0.0, 0.0)) + hinge))
    advance(world, 4.0)
    sag = told(world)[0]["j"]
    load = world.engine.joint_wrench("robot", "j")
    assert load.force == pytest.approx((0.0, 0.0, -MASS * GRAVITY), abs=0.05)
    assert load.torque == pytest.approx((0.0, 50.0 * sag, 0.0), abs=0.02)
    assert 50.0 * sag == pytest.approx(MASS * GRAVITY * 0.2 * cos(sag), rel=1e-3)


def test_a_load_cell_measures_the_push_of_the_step_at_whose_end_it_stops(open_world, read):
    cell = '<sensor name="c" type="force_torque"><update_rate>500</update_rate><topic>/c</topic></sensor>'
    world = open_world(read(link("bob") + joint("revolute", axis("0 1 0") + cell)))
    loads = world.subscribe("/c")
    world.run_until(10_000_000)
    push(world, "bob", force=(0.0, 5.0, 0.0), lasts_ns=10_000_000)
    felt = []
    for t_ms in range(12, 26, 2):
        world.run_until(t_ms * 1_000_000)
        felt.append(loads.latest.message.wrench.force.y)
    assert felt == pytest.approx([5.0] * 5 + [0.0] * 2, abs=1e-3)


def leg(damping: float) -> str:
    """Return a body of 4 kg, 3 cm in front of a leg of three joints, on a foot of 12 cm."""
    parts = (("body", 0.65, 4.0, (0.2, 0.2, 0.1)), ("thigh", 0.45, 1.0, (0.05, 0.05, 0.3)),
             ("shank", 0.175, 0.5, (0.04, 0.04, 0.25)), ("foot", 0.025, 0.2, (0.12, 0.08, 0.05)))  # fmt: skip
    links = ""
    for name, height, mass, (x, y, z) in parts:
        moments = mass * (y * y + z * z) / 12, mass * (x * x + z * z) / 12, mass * (x * x + y * y) / 12
        box = f"<collision name='c'><geometry><box><size>{x} {y} {z}</size></box></geometry></collision>"
        at = (0.03 if name == "body" else 0.0, 0.0, height)
        links += link(name, mass, moments, at=at).replace("</link>", f"{box}</link>")
    slow = axis("0 1 0", f"<dynamics><damping>{damping}</damping></dynamics>")
    hinges = (
        ("hip", "body", "thigh", 0.15),
        ("knee", "thigh", "shank", 0.125),
        ("ankle", "shank", "foot", 0.025),
    )
    return links + "".join(
        joint("revolute", f"<pose>0 0 {up} 0 0 0</pose>{slow}", name=name, parent=parent, child=child)
        for name, parent, child, up in hinges
    )


@pytest.mark.parametrize("damping", [1e3, 1e5])
def test_a_leg_of_strong_dampers_stands_and_sinks_as_slowly_as_they_let_it(
    backend, open_world, read, advance, parts, damping
):
    """The weight of the body turns each joint by its moment over the damping; contacts must carry it."""
    world = open_world(parts.floor(), read(leg(damping)))
    advance(world, 3.0)
    x, _, z = world.link_motion("robot", "body").pose.position
    assert z == pytest.approx(0.65, abs=0.005)
    assert x == pytest.approx(0.03, abs=0.05)
    if "Mujoco" in type(backend).__name__:  # PyBullet's iterations leave more of an error
        turned = [-3.0 * 4.0 * GRAVITY * 0.03 / damping] * 2
        assert world.joint_states("robot").positions[:2] == pytest.approx(turned, rel=0.1, abs=2e-4)
