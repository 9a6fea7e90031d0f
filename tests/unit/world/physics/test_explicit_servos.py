"""The efforts that are held for one step do what backward Euler would."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.scene.merged_bodies import stiff_gains
from nrp_core.scene.rigid import ServoTarget
from nrp_core.world.engine_kit.joint_servo import ExplicitServos

DT = 0.002
GAINS = st.floats(0.0, 1e6)


def run(aim: ServoTarget, inertia: np.ndarray, load: np.ndarray, steps: int, limit: float = np.inf):
    """Integrate joints as an engine with semi-implicit Euler does; return positions, velocities, efforts."""
    n = len(load)
    servos = ExplicitServos([limit] * n, DT)
    for number in range(n):
        servos.set_target(number, aim)
    positions, velocities = np.zeros(n), np.zeros(n)
    efforts = np.zeros(n)
    for _ in range(steps):
        efforts = servos.push(positions, velocities, inertia)
        velocities = velocities + DT * np.linalg.solve(inertia, efforts - load)
        positions = positions + DT * velocities
    return positions, velocities, efforts


@settings(max_examples=60, deadline=None)
@given(GAINS, st.floats(0.0, 1e4), st.floats(0.001, 10.0), st.floats(-50.0, 50.0))
def test_a_joint_without_load_moves_as_by_backward_euler(stiffness, damping, inertia, target):
    aim = ServoTarget(stiffness, damping, position=target)
    found = run(aim, np.array([[inertia]]), np.zeros(1), 20)[0][0]
    q = v = 0.0
    for _ in range(20):
        v = (inertia * v + DT * stiffness * (target - q)) / (inertia + DT * damping + DT**2 * stiffness)
        q += DT * v
    assert found == pytest.approx(q, rel=1e-6, abs=1e-9)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("stiffness", [10.0, 1e3, 1e6])
def test_coupled_joints_under_load_come_to_rest_where_spring_and_load_agree(stiffness):
    inertia = np.array([[0.14, 0.074, 0.021], [0.074, 0.042, 0.013], [0.021, 0.013, 0.005]])
    load = np.array([2.0, -1.0, 0.3])
    aim = ServoTarget(stiffness, 2 * np.sqrt(stiffness * 0.14), position=0.3)
    positions, velocities, efforts = run(aim, inertia, load, 30_000)
    assert positions == pytest.approx(0.3 - load / stiffness, abs=1e-6)
    assert velocities == pytest.approx(np.zeros(3), abs=1e-6)
    assert efforts == pytest.approx(load, abs=1e-5)


def test_efforts_end_at_their_limit():
    efforts = run(ServoTarget(1e3, 10.0, position=5.0), np.eye(2), np.zeros(2), 3, limit=0.5)[2]
    assert efforts.tolist() == [0.5, 0.5]


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 1e5), st.floats(0.001, 10.0), st.floats(-50.0, 50.0))
def test_a_joint_brakes_under_load_as_by_backward_euler_however_strong_its_damper_is(damper, inertia, load):
    servos = ExplicitServos([np.inf], DT, np.array([damper]))
    v = expected = 0.0
    for step in range(200):
        servos.push(np.zeros(1), np.array([v]), np.array([[inertia]]))
        v += DT * float(servos.braking[0] - load) / inertia
        implicit = (inertia * expected - DT * load) / (inertia + DT * damper)
        expected = implicit if step else v  # the load of the first step is not known before
    assert v == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_a_servo_at_its_limit_drives_a_strong_damper_as_fast_as_it_can():
    servos = ExplicitServos([2.0], DT, np.array([50.0]))
    servos.set_target(0, ServoTarget(1e6, 1e3, position=1.0))
    position, velocity, inertia = np.zeros(1), np.zeros(1), np.array([[0.001]])
    for _ in range(500):
        effort = servos.push(position, velocity, inertia)
        velocity = velocity + DT * np.linalg.solve(inertia, effort + servos.braking)
        position = position + DT * velocity
    assert effort.tolist() == [2.0]
    assert velocity == pytest.approx([2.0 / 50.0])


def test_stiff_gains_are_critically_damped():
    gains = stiff_gains(0.3)
    assert gains.d**2 == pytest.approx(4 * gains.p * 0.3)
