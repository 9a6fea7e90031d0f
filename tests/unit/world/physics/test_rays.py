"""Rays enter shapes at their surface, and nowhere before."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Capsule, Collision, Cylinder, Link, Model, Plane, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.raycast.collisions import CollisionSpace, signed_distance
from nrp_core.world.sensors.laser import Laser

SIZES = st.floats(0.1, 1.5)
SHAPES = st.one_of(
    st.builds(Sphere, SIZES),
    st.builds(Box, st.tuples(SIZES, SIZES, SIZES)),
    st.builds(Cylinder, SIZES, SIZES),
    st.builds(Capsule, SIZES, SIZES),
    st.just(Plane()),
)
ANGLES = st.floats(-pi, pi)
POSES = st.builds(
    lambda x, y, z, r, p, w: Pose.from_rpy((x, y, z), r, p, w),
    st.floats(-4, 4), st.floats(-4, 4), st.floats(-1, 1), ANGLES, ANGLES, ANGLES,
)  # fmt: skip
LASER = Laser("laser", "/scan", 10.0, 73, -pi, pi, 0.0, 20.0)


def scanned(shape, pose: Pose, laser: Laser = LASER) -> np.ndarray:
    models = (
        Model("eye", (Link("link", sensors=(laser,)),), static=True),
        Model("thing", (Link("link", collisions=(Collision("c", shape),)),), pose=pose, static=True),
    )
    space = CollisionSpace({m.name: bodies_of(m) for m in models}, lambda paths: lambda frames: None)
    return space.scan("eye", "link", laser.beams)


def depth(shape, pose: Pose, point) -> float:
    inverse = pose.inverse()
    turned = inverse.rotate(tuple(map(float, point)))
    local = tuple(a + b for a, b in zip(turned, inverse.position, strict=True))
    return signed_distance(shape, np.empty((0, 3, 3)), local)


@pytest.mark.heavy
@settings(max_examples=150, deadline=None)
@given(SHAPES, POSES)
def test_a_ray_ends_on_the_surface_and_meets_nothing_before(shape, pose):
    if depth(shape, pose, (0.0, 0.0, 0.0)) < 1e-3:
        return  # the eye is within the shape
    ranges = scanned(shape, pose)
    for angle, distance in zip(np.linspace(-pi, pi, 73), ranges, strict=True):
        ray = np.array([np.cos(angle), np.sin(angle), 0.0])
        if np.isfinite(distance):
            assert abs(depth(shape, pose, ray * distance)) < 1e-6
        for share in np.linspace(0.02, 0.98, 25):
            reach = min(float(distance), LASER.range_max)
            assert depth(shape, pose, ray * reach * share) > -1e-6


def test_from_within_nothing_is_seen():
    for shape in (Sphere(1.0), Box((2.0, 2.0, 2.0)), Cylinder(1.0, 2.0), Capsule(1.0, 2.0)):
        assert np.isinf(scanned(shape, Pose())).all()


def test_objects_outside_the_range_of_a_laser_are_not_seen():
    near = Laser("laser", "/scan", 10.0, 1, 0.0, 0.0, 3.0, 20.0)
    far = Laser("laser", "/scan", 10.0, 1, 0.0, 0.0, 0.0, 1.0)
    exact = Laser("laser", "/scan", 10.0, 1, 0.0, 0.0, 0.0, 1.5)
    ball = Sphere(0.5), Pose((2.0, 0.0, 0.0))
    assert [scanned(*ball, laser)[0] for laser in (near, far)] == [-inf, inf]
    assert scanned(*ball, exact)[0] == pytest.approx(1.5)
