"""Boxes of missing meshes are cut at what they overlap; the values are those of the geometry."""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from nrp_core.scene.clearance import with_clearance
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import (
    Box,
    Collision,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Joint,
    Link,
    Model,
    Plane,
    Scene,
    Sphere,
)
from nrp_core.scene.rigid import Pose

CUBE = Box((0.4, 0.4, 0.4))


def thing(name: str, geometry: Geometry, pose: Pose = Pose(), *, static: bool = False) -> Model:
    shape = Collision("c", geometry, estimated=name.startswith("lost"))
    return Model(name, (Link("l", collisions=(shape,)),), pose=pose, static=static)


def left(*models: Model, name: str = "lost") -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return the size and the centre, in its link, of the estimated box that is left."""
    shapes = with_clearance(Scene(models)).model(name).links[0].collisions
    if not shapes:
        return None
    assert isinstance(shapes[0].geometry, Box)
    return shapes[0].geometry.size, shapes[0].pose.position


def test_the_part_above_a_floor_is_left() -> None:
    robot = thing("lost", CUBE, Pose((0.0, 0.0, 0.1)))
    size, centre = left(robot, thing("floor", Plane(), static=True)) or ((), ())
    assert size == pytest.approx((0.4, 0.4, 0.3))
    assert centre == pytest.approx((0.0, 0.0, 0.05))


def test_a_box_on_its_edge_is_cut_until_its_lowest_corner_is_on_the_floor() -> None:
    tilt = pi / 6
    turned = Pose((0.0, 0.0, 0.2), (sin(tilt / 2), 0.0, 0.0, cos(tilt / 2)))
    size, centre = left(thing("lost", CUBE, turned), thing("floor", Plane(), static=True)) or ((), ())
    depth = 0.2 * (cos(tilt) + sin(tilt)) - 0.2
    assert size == pytest.approx((0.4, 0.4, 0.4 - depth / cos(tilt)))
    assert centre == pytest.approx((0.0, 0.0, depth / cos(tilt) / 2))


def test_a_box_stays_whole_beside_a_wall_whose_bounding_box_contains_it() -> None:
    yaw = Pose((0.4, 0.0, 0.0), (0.0, 0.0, sin(pi / 8), cos(pi / 8)))
    wall = thing("wall", Box((8.0, 0.1, 1.0)), yaw, static=True)
    robot = thing("lost", Box((0.3, 0.3, 0.4)))
    assert (
        with_clearance(Scene((robot, wall))).model("lost") == robot
    )  # 0.23 m from the wall, half of it 0.21 m


@pytest.mark.parametrize(
    ("other", "width"),
    [(Sphere(0.1), 0.3), (Cylinder(0.1, 1.0), 0.3), (Box((0.2, 0.6, 2.0)), 0.3)],
)
def test_the_side_towards_a_known_shape_is_cut(other: Geometry, width: float) -> None:
    size, centre = left(thing("lost", CUBE), thing("post", other, Pose((0.2, 0.0, 0.0)))) or ((), ())
    assert size == pytest.approx((width, 0.4, 0.4), abs=2e-3)  # round shapes are polyhedra
    assert centre == pytest.approx((-0.05, 0.0, 0.0), abs=1e-3)


def test_nothing_is_left_inside_a_known_shape() -> None:
    assert left(thing("lost", Box((0.1, 0.1, 0.1))), thing("block", Box((1.0, 1.0, 1.0)))) is None


def test_of_two_estimated_boxes_that_of_the_room_makes_way() -> None:
    scene = Scene((thing("lost", CUBE, Pose((0.3, 0.0, 0.0)), static=True), thing("lost_robot", CUBE)))
    assert left(*scene.models, name="lost_robot") == (CUBE.size, (0.0, 0.0, 0.0))
    size, centre = left(*scene.models) or ((), ())
    assert size == pytest.approx((0.3, 0.4, 0.4))
    assert centre == pytest.approx((0.05, 0.0, 0.0))


def test_links_are_where_their_joints_start() -> None:
    """An arm that starts upright, 0.5 m above its joint, not 0.5 m before it, where a block is."""
    shape = Collision("c", CUBE, Pose((0.5, 0.0, 0.0)), estimated=True)
    links = Link("base"), Link("arm", collisions=(shape,))
    joint = Joint("j", "revolute", "base", "arm", axis=(0.0, -1.0, 0.0))
    arm = Model("lost", links, (joint,), starts=(("j", pi / 2),))
    block = thing("block", CUBE, Pose((0.5, 0.0, 0.0)), static=True)
    assert with_clearance(Scene((arm, block))).model("lost") == arm
    high = thing("block", CUBE, Pose((0.0, 0.0, 0.8)), static=True)
    (cut,) = with_clearance(Scene((arm, high))).model("lost").link("arm").collisions
    assert isinstance(cut.geometry, Box)
    assert cut.geometry.size == pytest.approx((0.3, 0.4, 0.4))
    assert cut.pose.position == pytest.approx((0.45, 0.0, 0.0))


def write_surface(path: Path, height: float) -> None:
    """Write a square of 4 m at a height as two triangles that face upwards."""
    corners = np.array([(-2, -2, height), (2, -2, height), (-2, 2, height), (2, 2, height)], float)
    write_stl(path, corners[[(0, 1, 3), (0, 3, 2)]])


@pytest.mark.parametrize("kind", ["terrain", "surface"])
def test_the_part_above_a_terrain_or_a_surface_is_left(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "ground.stl"
    write_surface(path, 0.3)
    ground = Heightmap(path) if kind == "terrain" else ConcaveMesh(path, depth=0.05)
    size, centre = left(thing("lost", CUBE, Pose((0, 0, 0.4))), thing("g", ground, static=True)) or ((), ())
    assert size == pytest.approx((0.4, 0.4, 0.3), rel=1e-6)
    assert centre == pytest.approx((0.0, 0.0, 0.05), rel=1e-6)


def test_only_a_terrain_is_solid_far_below_its_surface(tmp_path: Path) -> None:
    path = tmp_path / "ground.stl"
    write_surface(path, 3.0)
    robot = thing("lost", CUBE)
    assert left(robot, thing("g", Heightmap(path), static=True)) is None
    assert left(robot, thing("g", ConcaveMesh(path), static=True)) == (CUBE.size, (0.0, 0.0, 0.0))
