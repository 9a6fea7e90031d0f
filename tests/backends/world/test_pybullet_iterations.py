"""PyBullet's solver takes as many iterations as the motors of a robot need."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pybullet")

from nrp_world_pybullet.control import USUAL, iterations_for


@pytest.mark.parametrize(("light", "heavy"), [(0.1, 1.0), (0.11, 1.0), (0.12, 1.0), (0.05, 1.0), (1.0, 1.0)])
def test_two_joints_of_one_axis_need_iterations_by_their_inertias(light: float, heavy: float) -> None:
    """An iteration leaves heavy / (light + heavy) of an error, by Gauss and Seidel for two unknowns."""
    inertia = np.array([[light + heavy, heavy], [heavy, heavy]])
    left = (heavy / (light + heavy)) ** iterations_for(inertia)
    assert left <= 1e-6 * (1 + 1e-9)
    assert iterations_for(inertia) % 2 == 0
    assert iterations_for(inertia) == USUAL or left > 1e-6 * (heavy / (light + heavy)) ** 2


@pytest.mark.parametrize(
    ("inertia", "expected"), [(np.eye(3), USUAL), (np.zeros((2, 2)), USUAL), ([[1.0001, 1], [1, 1]], 500)]
)
def test_the_number_has_bounds(inertia: object, expected: int) -> None:
    assert iterations_for(np.array(inertia)) == expected
