"""The paths of joints that follow with any load."""

from __future__ import annotations

from math import exp, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.scene.merged_bodies import STIFF_TIME_CONSTANT_S as LAG
from nrp_core.scene.model import Joint
from nrp_core.scene.rigid import JointTargets, ServoTarget
from nrp_core.world.engine_kit.firm_joints import BRAKING, RETURN_S, FirmJoint, FirmServos

STEP_S = 0.002


def servos(speed: float = inf) -> FirmServos:
    return FirmServos([FirmJoint(Joint("j", "revolute", "a", "b", velocity=speed))], STEP_S)


def to(position: float) -> ServoTarget:
    return ServoTarget(stiffness=1.0, position=position, firm=True)


def follow(servo: FirmServos, steps: int, start: float = 0.0) -> np.ndarray:
    """Return positions and speeds of the path of a joint that follows exactly, shape ``(steps, 2)``."""
    seen, x, v = [], np.array([start]), np.zeros(1)
    for _ in range(steps):
        servo.step(x, v)
        x, v = servo.positions, servo.speeds
        seen.append((x[0], v[0]))
    return np.array(seen)


def test_a_position_is_approached_as_by_a_critically_damped_spring():
    servo = servos()
    servo.set_target(0, to(0.8))
    seen = follow(servo, 100)
    for step in (1, 10, 50, 100):
        t = step * STEP_S / LAG
        assert seen[step - 1][0] == pytest.approx(0.8 * (1 - (1 + t) * exp(-t)), abs=1e-12)


def test_a_velocity_is_approached_with_one_time_constant():
    servo = servos()
    servo.set_target(0, ServoTarget(damping=1.0, velocity=2.0, firm=True))
    assert follow(servo, 50)[-1][1] == pytest.approx(2.0 * (1 - exp(-50 * STEP_S / LAG)))


@settings(max_examples=15)
@given(
    st.floats(-3, 3),
    st.lists(st.floats(-3, 3), min_size=1, max_size=4),
    st.floats(2, 10),
    st.integers(1, 40),
)
def test_a_path_keeps_its_speed_limit_goes_without_jumps_and_ends_at_its_target(start, goals, speed, steps):
    servo, last = servos(speed), start
    for goal in goals:
        servo.set_target(0, to(goal))
        for x, v in follow(servo, steps, start):
            assert abs(x - last) <= speed * STEP_S * (1 + 1e-9)
            assert abs(v) <= speed
            last = x
    seen = follow(servo, round((6 / speed + 30 * LAG) / STEP_S), start)
    assert seen[-1] == pytest.approx((goals[-1], 0.0), abs=1e-8)
    assert not servo.moving


def test_a_point_of_a_path_is_taken_at_once_with_its_rate():
    servo = servos()
    servo.set_target(0, ServoTarget(stiffness=1.0, position=0.3, velocity=1.5, firm=False))
    assert follow(servo, 1)[0] == pytest.approx((0.3, 1.5))


def test_a_pushed_joint_is_taken_back_to_its_path():
    servo = servos()
    servo.set_target(0, to(0.0))
    follow(servo, 1)
    assert servo.velocities(np.array([0.01]))[0] == pytest.approx(-0.01 / (0.005 + STEP_S))


def test_a_joint_far_off_its_path_is_taken_back_no_faster_than_it_can_brake():
    effort, inertia, off = 12.0, 0.4, 0.1
    servo = FirmServos([FirmJoint(Joint("j", "revolute", "a", "b", effort=effort), inertia)], STEP_S)
    servo.set_target(0, to(0.0))
    follow(servo, 1)
    speed = -servo.velocities(np.array([off]))[0]
    assert speed**2 / (2 * BRAKING * effort / inertia) == pytest.approx(off)  # v^2 / 2a
    assert speed < off / (RETURN_S + STEP_S)  # without a limit it would pass its path, and turn back for ever


@pytest.mark.parametrize("between", ["rates", "aim", "restore"])
def test_a_rate_that_came_between_is_gone_with_the_next_target_at_rest(between: str) -> None:
    servo, whole = servos(), slice(0, 1)
    saved = servos()
    saved.set_target(0, ServoTarget(stiffness=1.0, position=0.1, velocity=0.3, firm=True))
    servo.set_target(0, ServoTarget(stiffness=1.0, position=0.1, firm=True))
    servo.retarget(whole, JointTargets(("j",), [0.2], (), smooth=True))
    if between == "rates":
        servo.retarget(whole, JointTargets(("j",), [0.2], [0.3], smooth=False))
    elif between == "aim":
        servo.set_target(0, ServoTarget(stiffness=1.0, position=0.2, velocity=0.3, firm=True))
    else:
        servo.restore(saved.save())
    assert servo.paths["rate"][0] == 0.3
    servo.retarget(whole, JointTargets(("j",), [0.4], (), smooth=True))
    assert (servo.paths["rate"][0], servo.paths["smooth"][0]) == (0.0, 1)
