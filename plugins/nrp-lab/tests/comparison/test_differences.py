"""Differences that were put into signals are measured with their size."""

import numpy as np
import pytest
from nrp_lab.comparison.engine_measures import MISSING, Kind, Signal, difference

from nrp_core.recording import nearest_quaternions

STEP_S = 0.02
TIMES = np.arange(0, 8, STEP_S)
WAVE = np.stack([1 + np.sin(TIMES), np.cos(1.7 * TIMES), 0 * TIMES], axis=1)


def signal(values: np.ndarray, floor: float = 1e-6) -> Signal:  # type: ignore[type-arg]
    return Signal(Kind.SENSOR, values, floor)


def test_a_signal_does_not_differ_from_itself() -> None:
    apart = difference(signal(WAVE), signal(WAVE), STEP_S)
    assert apart is not None
    assert (apart.level_percent, apart.delay_s, apart.noise_percent) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("factor", "percent"), [(1.02, 2 / 1.02), (0.5, 50.0), (-1.0, 200.0)])
def test_a_gain_is_a_difference_in_level(factor: float, percent: float) -> None:
    apart = difference(signal(WAVE), signal(factor * WAVE), STEP_S)
    assert apart is not None
    assert apart.level_percent == pytest.approx(percent, rel=0.02)
    assert apart.delay_s == 0


@pytest.mark.parametrize("steps", [-3, 1, 5])
def test_a_delay_is_found_to_the_step_and_leaves_no_difference(steps: int) -> None:
    apart = difference(signal(WAVE), signal(np.roll(WAVE, steps, axis=0)), STEP_S)
    assert apart is not None
    assert apart.delay_s == pytest.approx(steps * STEP_S)
    assert apart.level_percent < 3  # both ends of a rolled signal are those of the other end


def test_noise_is_measured_as_its_deviation() -> None:
    drawn = np.random.Generator(np.random.Philox(1)).normal(0, 0.1, (len(TIMES), 1))
    still = np.full((len(TIMES), 1), 5.0)
    apart = difference(signal(still), signal(still + drawn), STEP_S)
    assert apart is not None
    # a moving mean over 11 steps takes away all but 1 / 11 of the variance
    assert apart.noise_percent == pytest.approx(100 * 0.1 * (10 / 11) ** 0.5 / 5, rel=0.1)
    assert apart.delay_s == 0


def test_a_difference_below_the_noise_floor_is_not_reported() -> None:
    apart = difference(signal(1e-5 * WAVE, 1.0), signal(-1e-5 * WAVE, 1.0), STEP_S)
    assert apart is not None
    assert apart.level_percent < 0.01


def test_another_number_of_values_is_missing() -> None:
    assert difference(signal(WAVE), signal(WAVE[:, :2]), STEP_S) is MISSING


def test_a_quaternion_and_its_negative_are_the_same_orientation() -> None:
    names = ("x", "qx", "qy", "qz", "qw", "vx", "vy", "vz")
    one = np.array([[-1.0, 0.0, 0.0, 1.0, 1e-17, 2.0, 0.0, 0.0], [1.0, 0.6, 0.0, 0.0, 0.8, 2.0, 0.0, 0.0]])
    other = one * [[1, -1, -1, -1, -1, 1, 1, 1], [-1, 1, 1, 1, 1, -1, 1, 1]]
    turned = nearest_quaternions(names, one, other)
    assert np.array_equal(turned[0], one[0])  # half a turn, of which rounding decides the sign
    assert np.array_equal(turned[1], other[1])  # positions and velocities keep their signs
    paths = [f".pose[0].orientation.{end}" for end in "wxyz"]
    quaternion = one[1, [4, 1, 2, 3]]
    assert np.array_equal(nearest_quaternions(paths, quaternion, -quaternion), quaternion)
