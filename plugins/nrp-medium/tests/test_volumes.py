"""Volumes below a level against formulas."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_medium.buoyancy import Solid

from nrp_core.scene.model import Box, Cylinder, Sphere
from nrp_core.world import Pose

NO_TURN = np.eye(3)
angles = st.floats(-3.0, 3.0)


def turned(*rpy: float) -> np.ndarray:
    pose = Pose.from_rpy((0.0, 0.0, 0.0), *rpy)
    return np.array([pose.rotate(axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T


@given(st.floats(-0.99, 0.99), angles, angles)
def test_a_ball_displaces_a_spherical_cap(level: float, roll: float, pitch: float) -> None:
    solid = Solid.of(Pose(), Sphere(1.0))
    assert solid is not None
    volume, moment = solid.below(turned(roll, pitch, 0.0), level)
    depth = 1 + level
    assert volume == pytest.approx(pi * depth**2 * (3 - depth) / 3, abs=0.01)
    assert moment == pytest.approx((0, 0, -pi / 4 * (1 - level**2) ** 2), abs=0.01)


@given(angles, angles, angles, st.floats(-0.6, 0.6))
def test_parts_of_a_box_make_the_whole(roll: float, pitch: float, yaw: float, level: float) -> None:
    solid = Solid.of(Pose((0.1, -0.2, 0.05)), Box((0.4, 0.6, 0.3)))
    assert solid is not None
    turn = turned(roll, pitch, yaw)
    over = np.diag([1.0, -1.0, -1.0])
    (below, under), (above, upper) = solid.below(turn, level), solid.below(over @ turn, -level)
    assert below + above == pytest.approx(0.4 * 0.6 * 0.3)
    assert under + over @ upper == pytest.approx(turn @ solid.centre * 0.4 * 0.6 * 0.3, abs=1e-9)
    half, _ = solid.below(turn, float((turn @ solid.centre)[2]))
    assert half == pytest.approx(0.4 * 0.6 * 0.3 / 2)


def test_a_standing_cylinder_displaces_its_draught() -> None:
    solid = Solid.of(Pose(), Cylinder(0.2, 1.0))
    assert solid is not None
    volume, moment = solid.below(NO_TURN, 0.1)
    assert volume == pytest.approx(pi * 0.04 * 0.6, rel=2e-3)
    assert moment[2] / volume == pytest.approx(-0.2, abs=2e-3)
