from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.scene.inertia import collision_inertia, equivalent_box, repair_inertia, shape_inertia
from nrp_core.scene.meshes.shapes import unit_solid
from nrp_core.scene.model import Box, Capsule, Collision, Cylinder, Geometry, Inertial, Mesh, Plane, Sphere
from nrp_core.scene.rigid import Pose

lengths = st.floats(0.01, 3)
boxes = st.builds(Box, st.tuples(lengths, lengths, lengths))
angles = st.floats(-3, 3)


def contains(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    match geometry:
        case Box((a, b, c)):
            return (abs(x) < a / 2) & (abs(y) < b / 2) & (abs(z) < c / 2)
        case Sphere(r):
            return x * x + y * y + z * z < r * r
        case Cylinder(r, length):
            return (x * x + y * y < r * r) & (abs(z) < length / 2)
        case Capsule(r, length):
            beyond = np.maximum(abs(z) - length / 2, 0)
            return x * x + y * y + beyond * beyond < r * r
    raise AssertionError(geometry)


@pytest.mark.parametrize(
    "geometry", [Box((0.4, 0.8, 1.2)), Sphere(0.5), Cylinder(0.3, 1.1), Capsule(0.3, 0.6)], ids=type
)
def test_the_moments_of_a_solid_are_those_of_the_points_in_it(geometry: Geometry) -> None:
    cells = (np.arange(64) + 0.5) / 64 * 1.2 - 0.6
    grid = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), axis=-1).reshape(-1, 3)
    points = grid[contains(geometry, grid)]
    mass = len(points) * (1.2 / 64) ** 3 * 1000
    squares = (points**2).mean(axis=0) * mass
    solid = shape_inertia(geometry)
    assert solid is not None
    assert solid.mass == pytest.approx(mass, rel=0.03)
    assert solid.inertia[:3] == pytest.approx(squares.sum() - squares, rel=0.04)


def test_ellipsoids_and_cones_have_the_moments_of_round_solids() -> None:
    """Engines have them as meshes. The formulas are textbooks'; a cone's frame is at half its height."""
    egg = shape_inertia(Mesh(unit_solid("ellipsoid"), (0.1, 0.2, 0.3)), 1000.0)
    mass = 1000 * 4 / 3 * pi * 0.1 * 0.2 * 0.3
    squares = np.array([0.1, 0.2, 0.3]) ** 2 / 5 * mass
    assert egg is not None
    assert (egg.mass, *egg.inertia[:3]) == pytest.approx((mass, *(squares.sum() - squares)), rel=1e-12)
    cone = shape_inertia(Mesh(unit_solid("cone"), (0.2, 0.2, 0.6)), 1000.0)
    mass = 1000 / 3 * pi * 0.2**2 * 0.6
    across = mass * (3 / 20 * 0.2**2 + 3 / 80 * 0.6**2)
    assert cone is not None
    moments = (across, across, 3 / 10 * mass * 0.2**2)
    assert (cone.mass, *cone.inertia[:3]) == pytest.approx((mass, *moments), rel=1e-12)
    assert cone.pose.position == pytest.approx((0, 0, -0.15))


def test_planes_weigh_nothing() -> None:
    assert shape_inertia(Plane()) is None
    assert collision_inertia([(Collision("floor", Plane()), 1000.0)]) is None


def test_two_half_boxes_weigh_what_the_whole_one_does() -> None:
    half = Box((1.0, 0.5, 0.2))
    halves = [(Collision(side, half, Pose((x, 0.3, 0))), 500.0) for side, x in (("l", -0.5), ("r", 0.5))]
    both, whole = collision_inertia(halves), shape_inertia(Box((2.0, 0.5, 0.2)), 500.0)
    assert both is not None
    assert whole is not None
    assert both.mass == pytest.approx(whole.mass)
    assert both.pose.position == pytest.approx((0, 0.3, 0))
    assert both.inertia == pytest.approx(whole.inertia)


def test_a_hollow_ball_weighs_less_by_its_density() -> None:
    light = collision_inertia([(Collision("ball", Sphere(0.1)), 10.0)])
    assert light is not None
    assert light.mass == pytest.approx(10 * 4 / 3 * pi * 0.001)


@given(boxes, angles, angles)
def test_the_box_with_the_inertia_of_a_box_is_that_box(box: Box, roll: float, yaw: float) -> None:
    solid = shape_inertia(box)
    assert solid is not None
    placed = Inertial(solid.mass, Pose.from_rpy((1, 2, 3), roll, 0, yaw), solid.inertia)
    found, pose = equivalent_box(placed)
    assert sorted(found.size) == pytest.approx(sorted(box.size), rel=1e-3, abs=1e-3)
    assert pose.position == pytest.approx((1, 2, 3))
    longest = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    if sorted(box.size)[2] > 1.1 * sorted(box.size)[1]:
        theirs = pose.rotate(longest[found.size.index(max(found.size))])
        ours = placed.pose.rotate(longest[box.size.index(max(box.size))])
        assert abs(np.dot(theirs, ours)) == pytest.approx(1, abs=1e-3)


@given(boxes)
def test_the_inertia_of_a_solid_needs_no_repair(box: Box) -> None:
    solid = shape_inertia(box)
    assert solid is not None
    assert repair_inertia(solid) == (solid, "")


moments = st.floats(-2, 10)


@given(st.tuples(moments, moments, moments), st.tuples(moments, moments, moments))
def test_a_repaired_inertia_is_positive_and_obeys_the_triangle_inequality(
    diagonal: tuple[float, float, float], products: tuple[float, float, float]
) -> None:
    given_ = Inertial(2.0, Pose((1.0, 0.0, 0.0)), (*diagonal, *products))
    inertial, wrong = repair_inertia(given_)
    assert (inertial is given_) == (wrong == "")
    assert inertial.mass == 2
    assert inertial.pose.position == pytest.approx((1, 0, 0))
    if wrong:
        a, b, c = sorted(inertial.inertia[:3])
        assert a > 0
        assert a + b >= c
        assert inertial.inertia[3:] == (0, 0, 0)


def test_only_the_smaller_moments_are_raised() -> None:
    inertial, wrong = repair_inertia(Inertial(1.0, inertia=(0.1, 0.2, 1.0, 0.0, 0.0, 0.0)))
    assert "0.1, 0.2, 1" in wrong
    assert "triangle" in wrong
    assert inertial.inertia[2] == 1.0
    assert inertial.inertia[1] - inertial.inertia[0] == pytest.approx(0.1)
