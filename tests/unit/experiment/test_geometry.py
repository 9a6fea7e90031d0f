"""Footprints: distances on the ground, against what plane geometry says."""

from math import cos, hypot, inf, pi, sin
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import CapabilityError
from nrp_core.observables.positions import Footprint, convex_hull, distances
from nrp_core.scene.model import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from nrp_core.scene.rigid import Pose

coordinates = st.floats(-10, 10)
points = st.tuples(coordinates, coordinates)
angles = st.floats(-pi, pi)
sizes = st.floats(0.01, 5)
poses = st.builds(Pose.from_rpy, st.tuples(coordinates, coordinates, coordinates), angles, angles, angles)
solids = (
    st.builds(Box, st.tuples(sizes, sizes, sizes))
    | st.builds(Sphere, sizes)
    | st.builds(Capsule, sizes, sizes)
    | st.builds(Cylinder, sizes, sizes)
)


def rounded_rectangle_distance(point: tuple[float, float], half: tuple[float, float]) -> float:
    return hypot(max(0.0, abs(point[0]) - half[0]), max(0.0, abs(point[1]) - half[1]))


@given(points, sizes, sizes, st.tuples(coordinates, coordinates), angles)
def test_the_distance_to_an_upright_box_is_that_to_its_rectangle(
    point: tuple[float, float], length: float, width: float, centre: tuple[float, float], yaw: float
) -> None:
    footprint = Footprint.of(Box((length, width, 1.0)), Pose.from_rpy((*centre, 3.0), 0, 0, yaw))
    x, y, _ = (
        Pose.from_rpy((*centre, 0.0), 0, 0, yaw)
        .inverse()
        .rotate((point[0] - centre[0], point[1] - centre[1], 0))
    )
    assert footprint.distance(point) == pytest.approx(
        rounded_rectangle_distance((x, y), (length / 2, width / 2)), abs=1e-9
    )


@given(points, sizes, poses)
def test_the_distance_to_a_sphere_is_that_to_its_circle(
    point: tuple[float, float], radius: float, pose: Pose
) -> None:
    x, y, _ = pose.position
    expected = max(0.0, hypot(point[0] - x, point[1] - y) - radius)
    assert Footprint.of(Sphere(radius), pose).distance(point) == pytest.approx(expected, abs=1e-9)


@given(points, sizes, sizes)
def test_the_distance_to_a_lying_capsule_is_that_to_its_stadium(
    point: tuple[float, float], radius: float, length: float
) -> None:
    footprint = Footprint.of(Capsule(radius, length), Pose.from_rpy((0, 0, 1), 0, pi / 2, 0))
    expected = max(0.0, rounded_rectangle_distance(point, (length / 2, 0)) - radius)
    assert footprint.distance(point) == pytest.approx(expected, abs=1e-9)


@given(points, sizes)
def test_the_distance_to_an_upright_cylinder_is_off_by_its_polygon_at_most(
    point: tuple[float, float], radius: float
) -> None:
    exact = max(0.0, hypot(*point) - radius)
    distance = Footprint.of(Cylinder(radius, 1.0), Pose()).distance(point)
    assert exact - 1e-9 <= distance <= exact + 0.0013 * radius


@given(solids, poses, points, points)
def test_distances_obey_the_triangle_inequality(
    solid: Box | Sphere | Capsule | Cylinder, pose: Pose, a: tuple[float, float], b: tuple[float, float]
) -> None:
    footprint = Footprint.of(solid, pose)
    assert footprint.distance(a) <= footprint.distance(b) + hypot(a[0] - b[0], a[1] - b[1]) + 1e-9


@given(solids, poses, points, angles)
def test_turning_everything_about_the_vertical_changes_no_distance(
    solid: Box | Sphere | Capsule | Cylinder, pose: Pose, point: tuple[float, float], yaw: float
) -> None:
    turn = Pose.from_rpy((0, 0, 0), 0, 0, yaw)
    x, y, _ = turn.rotate((*point, 0))
    turned = Footprint.of(solid, turn @ pose).distance((x, y))
    assert turned == pytest.approx(Footprint.of(solid, pose).distance(point), abs=1e-6)


@given(st.lists(points, min_size=1, max_size=12))
def test_a_convex_hull_turns_left_and_holds_every_point(cloud: list[tuple[float, float]]) -> None:
    hull = convex_hull(cloud)
    assert set(hull) <= set(cloud)
    assert all(Footprint(hull).distance(point) < 1e-9 for point in cloud)
    assert convex_hull(list(hull)) == hull


def test_a_plane_is_everywhere() -> None:
    assert Footprint.of(Plane(), Pose()).radius == inf
    assert Footprint.of(Plane(), Pose()).distance((3.0, 4.0)) == 0.0


def test_a_point_has_a_distance_too() -> None:
    assert Footprint(((1.0, 2.0),)).distance((4.0, 6.0)) == 5.0


def test_the_distance_to_a_mesh_is_refused(golden: Golden) -> None:
    with golden.raises(CapabilityError):
        Footprint.of(Mesh(Path("a.stl")), Pose())


def test_a_box_on_its_edge_covers_its_diagonal() -> None:
    footprint = Footprint.of(Box((2.0, 2.0, 2.0)), Pose.from_rpy((0, 0, 0), pi / 4, 0, 0))
    half = hypot(1, 1)
    assert footprint.distance((0.0, half + 1)) == pytest.approx(1.0)
    assert footprint.distance((cos(0.3), sin(0.3))) == 0.0


@given(st.lists(st.tuples(points, points), min_size=1, max_size=5), solids, poses)
def test_distances_of_many_points_have_the_same_bits_as_each_alone(
    given: list[tuple[tuple[float, float], tuple[float, float]]], geometry: Box, pose: Pose
) -> None:
    for footprints in (
        [Footprint.of(geometry, pose)] * len(given),
        [Footprint((place,)) for _, place in given],
    ):
        corners = np.array([footprint.corners for footprint in footprints])
        radii = np.array([footprint.radius for footprint in footprints])
        found = distances(corners, radii, np.array([point for point, _ in given]))
        alone = [footprint.distance(point) for footprint, (point, _) in zip(footprints, given, strict=True)]
        assert found.tolist() == alone
