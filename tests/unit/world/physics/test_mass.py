"""Masses put together."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.scene.inertia import inertia_tensor, sum_inertials
from nrp_core.scene.model import Inertial
from nrp_core.scene.rigid import Pose, rotation_matrix

lengths = st.floats(-3, 3)
angles = st.floats(-pi, pi)
poses = st.builds(lambda x, y, z, a, b, c: Pose.from_rpy((x, y, z), a, b, c), *[lengths] * 3, *[angles] * 3)


@st.composite
def inertials(draw):
    """Any inertial of three point masses, which a body can have."""
    points = np.array(draw(st.lists(st.tuples(lengths, lengths, lengths), min_size=4, max_size=4)))
    mass = draw(st.floats(0.1, 10))
    points -= points.mean(axis=0)
    xx, yy, zz = (mass * (points**2).sum() / 4 - mass * (points[:, i] ** 2).sum() / 4 for i in range(3))
    xy, xz, yz = (-mass * (points[:, i] * points[:, j]).sum() / 4 for i, j in ((0, 1), (0, 2), (1, 2)))
    return Inertial(mass, draw(poses), (xx + 0.1, yy + 0.1, zz + 0.1, xy, xz, yz))


def energy(inertial: Inertial, spin: np.ndarray, drift: np.ndarray) -> float:
    """Return the kinetic energy of a mass that turns about the origin and drifts."""
    velocity = drift + np.cross(spin, inertial.pose.position)
    return inertial.mass * velocity @ velocity / 2 + spin @ inertia_tensor(inertial) @ spin / 2


@given(st.lists(inertials(), min_size=1, max_size=4), st.integers(0, 2**32 - 1))
def test_the_whole_has_the_kinetic_energy_of_its_parts(parts, seed):
    spin, drift = np.random.default_rng(seed).normal(size=(2, 3))
    whole = sum_inertials(parts)
    assert whole is not None
    assert energy(whole, spin, drift) == pytest.approx(sum(energy(p, spin, drift) for p in parts), rel=1e-9)
    assert whole.inertia[3:] == (0, 0, 0)


@given(poses)
def test_a_rotation_matrix_turns_as_its_quaternion(pose):
    vector = (0.3, -1.2, 0.7)
    assert rotation_matrix(pose.orientation) @ vector == pytest.approx(pose.rotate(vector))


def test_axes_that_are_principal_already_stay_as_they_are():
    given_one = Inertial(2.0, Pose((1, 2, 3)), (3.0, 1.0, 2.0, 0.0, 0.0, 0.0))
    assert sum_inertials([given_one]) == given_one


def test_two_point_masses_turn_about_their_middle():
    angle = 0.4
    ends = [Pose((s * cos(angle), s * sin(angle), 0.0)) for s in (-1.0, 1.0)]
    whole = sum_inertials([Inertial(1.5, end, (1e-9,) * 3 + (0.0,) * 3) for end in ends])
    assert whole.mass == 3.0
    assert whole.pose.position == pytest.approx((0, 0, 0), abs=1e-12)
    assert sorted(whole.inertia[:3]) == pytest.approx([0, 3, 3], abs=1e-6)


def test_the_sum_of_massless_inertials_is_none():
    assert sum_inertials([]) is None
    assert sum_inertials([Inertial(0.0)]) is None
