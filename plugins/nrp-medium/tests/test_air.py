"""Rotors and wings against their formulas."""

from __future__ import annotations

from math import atan, cos, exp, hypot, sin, sqrt

import numpy as np
import pytest
from medium_bodies import ARM, FRAME_MASS, MOMENT, MOTOR, ROTOR_MASS, G, link, model, plugin, quadrotor, run

from nrp_core.errors import NrpError
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.rigid import ModelMotion, Pose

MASS = FRAME_MASS + 4 * ROTOR_MASS
HOVER = sqrt(MASS * G / (4 * MOTOR))


def spin(world, *speeds: float, seconds: float, name: str = "quad") -> None:
    world.advertise(f"/{name}/command/motor_speed").publish(Float64MultiArray(data=list(speeds)))
    run(world, seconds)


def test_a_quadrotor_hovers_at_the_speed_at_which_thrust_is_weight(open_world):
    world = open_world(quadrotor())
    spin(world, *[HOVER] * 4, seconds=0.3)
    fell = world.model_motion("quad")
    run(world, 0.3)
    still = world.model_motion("quad")
    assert still.linear == pytest.approx(fell.linear, abs=1e-6)
    assert still.pose.rpy == pytest.approx((0, 0, 0), abs=1e-6)
    # until the rotors have their speed, it falls by the thrust that is missing: w = 1 - exp(-t / lag)
    lag_s, step_s = 0.0125, 0.002
    lack = sum(1 - (1 - exp(-step * step_s / lag_s)) ** 2 for step in range(150)) * step_s
    assert still.linear[2] == pytest.approx(-G * lack, rel=1e-3)


def test_one_percent_more_speed_climbs_by_the_square(open_world):
    world = open_world(quadrotor())
    spin(world, *[1.01 * HOVER] * 4, seconds=0.5)
    before = world.model_motion("quad").linear[2]
    run(world, 0.5)
    assert (world.model_motion("quad").linear[2] - before) / 0.5 == pytest.approx(G * (1.01**2 - 1), rel=1e-4)


def test_rotors_of_one_direction_turn_the_body_the_other_way(open_world):
    world = open_world(quadrotor())
    spin(world, 1.05 * HOVER, 1.05 * HOVER, 0.95 * HOVER, 0.95 * HOVER, seconds=0.5)
    before = world.model_motion("quad").angular[2]
    run(world, 0.2)
    torque = -MOTOR * MOMENT * 2 * HOVER**2 * (1.05**2 - 0.95**2)
    moment = 0.04 + 4 * (2.6e-5 + ROTOR_MASS * 2 * ARM**2)
    brake = 4 * HOVER * 8.06428e-05 * 2 * ARM**2  # the drag of the rotors on their way around
    gain = (torque / brake - before) * (1 - exp(-0.2 * brake / moment))
    assert world.model_motion("quad").angular[2] - before == pytest.approx(gain, rel=0.005)


def test_a_rotor_turns_its_joint_slower_than_itself(open_world):
    world = open_world(quadrotor())
    spin(world, *[HOVER] * 4, seconds=0.5)
    states = world.joint_states("quad")
    assert np.abs(states.velocities) == pytest.approx(np.full(4, HOVER / 10), rel=0.01)
    assert np.sign(states.velocities).tolist() == [1, 1, -1, -1]


def test_a_command_without_a_speed_for_each_rotor_is_refused(open_world):
    with pytest.raises(NrpError, match="rotor 3"):
        spin(open_world(quadrotor()), HOVER, HOVER, HOVER, seconds=0.01)
    with pytest.raises(NrpError, match="finite"):
        spin(open_world(quadrotor()), HOVER, HOVER, HOVER, float("nan"), seconds=0.01)


LIFT, DRAG, AREA, DENSITY, WEIGHT = 4.0, 0.4, 0.5, 1.2, 1.0


def wing(where: str, zero: float, area: float) -> str:
    return plugin(
        "LiftDrag",
        f"<link_name>base</link_name><cla>{LIFT}</cla><cda>{DRAG}</cda><alpha_stall>0.5</alpha_stall><a0>{zero}</a0>"
        f"<area>{area}</area><air_density>{DENSITY}</air_density><cp>{where}</cp>",
    )


def glider() -> str:
    """Return a wing, and a tail with less incidence that keeps its nose to the wind."""
    return model(
        link("base", WEIGHT, (0.05, 0.2, 0.2)) + wing("0.01 0 0", 0.08, AREA) + wing("-0.8 0 0", 0.06, 0.1),
        "0 0 200 0 0 0",
    )


def test_a_glider_descends_at_the_angle_of_its_drag_and_lift(open_world):
    """Both wings have the ratio DRAG / LIFT at each angle of attack, so the path does, too."""
    world = open_world(glider())
    angle = atan(DRAG / LIFT)
    # the trim: moments about the centre of mass cancel, as the centres of pressure are level with it
    attack = (0.8 * 0.1 * 0.06 - 0.01 * AREA * 0.08) / (0.01 * AREA - 0.8 * 0.1)
    lift = LIFT * (AREA * (attack + 0.08) + 0.1 * (attack + 0.06))
    speed = sqrt(2 * WEIGHT * G * cos(angle) / (DENSITY * lift))
    start = ModelMotion(
        Pose.from_rpy((0.0, 0.0, 200.0), 0.0, angle - attack, 0.0),
        (speed * cos(angle), 0.0, -speed * sin(angle)),
    )
    world.place("body", start)
    run(world, 2.0)
    motion = world.model_motion("body")
    assert motion.pose.rpy[1] == pytest.approx(angle - attack, abs=1e-6)
    assert atan(-motion.linear[2] / motion.linear[0]) == pytest.approx(angle, rel=1e-6)
    assert hypot(*motion.linear) == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize("sideways", [0.0, 3.0])
def test_a_wing_in_a_flow_has_the_force_of_its_coefficients(open_world, sideways):
    """Its first step changes the velocity by force / mass, and gravity."""
    world = open_world(model(link("base", 5.0, (1, 1, 1)) + wing("0 0 0", 0.05, AREA)))
    world.place("body", ModelMotion(Pose(), (10.0, sideways, -1.0)))
    run(world, 0.002)
    attack, plane = atan(0.1) + 0.05, 101.0
    straight = plane / (plane + sideways**2)
    size = 0.5 * DENSITY * plane * AREA * straight
    ahead, down = 10 / sqrt(plane), -1 / sqrt(plane)
    force = np.array(
        [
            LIFT * attack * size * -down - DRAG * attack * size * ahead,
            LIFT * attack * size * ahead - DRAG * attack * size * down,
        ]
    )
    x, y, z = np.subtract(world.model_motion("body").linear, (10.0, sideways, -1.0)) / 0.002
    assert (x, y, z + G) == pytest.approx((force[0] / 5, 0, force[1] / 5), rel=1e-6, abs=1e-9)


def test_engines_agree_on_a_flight_to_a_millimetre(open_in):
    ends = []
    for engine in ("mujoco", "pybullet"):
        world = open_in(engine, quadrotor())
        spin(world, 1.02 * HOVER, 1.02 * HOVER, 1.05 * HOVER, 1.01 * HOVER, seconds=0.8)
        ends.append(world.model_motion("quad").pose)
    assert np.linalg.norm(np.subtract(ends[0].position, (0, 0, 5))) > 0.1
    assert ends[0].position == pytest.approx(ends[1].position, abs=1e-3)
    assert ends[0].rpy == pytest.approx(ends[1].rpy, abs=1e-3)


def test_a_wing_without_a_direction_has_no_forces(open_world):
    still = wing("0 0 0", 0.1, AREA).replace("<cla>", "<forward>0 0 0</forward><cla>")
    world = open_world(model(link("base", 5.0, (1, 1, 1)) + still))
    run(world, 0.1)
    assert world.model_motion("body").linear == pytest.approx((0, 0, -G * 0.1))
