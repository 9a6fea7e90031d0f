"""Shapes as triangles, counter-clockwise as seen from outside."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from itertools import product
from math import pi

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.meshes.stl import read_coordinates, read_stl
from nrp_core.scene.meshes.triangles import (
    Coordinates,
    Faces,
    arc,
    mapped_triangles,
    revolve,
    weld_vertices,
)
from nrp_core.scene.meshes.triangles import Points as Vertices
from nrp_core.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Link,
    Mesh,
    Plane,
    Sphere,
    Visual,
)
from nrp_core.scene.rigid import Pose, matrix_of, transform

_BOX_FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
], np.int32)  # fmt: skip


def triangles_of(geometry: Geometry) -> tuple[Vertices, Faces]:
    """Return the vertices of a shape, shape ``(n, 3)``, and triangles of their indices, shape ``(m, 3)``.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    match geometry:
        case Box(size):
            corners = np.array(list(product((-0.5, 0.5), repeat=3)))
            return corners * size, _BOX_FACES
        case Sphere(radius):
            return revolve(arc(radius, -pi / 2, 0.0) + arc(radius, 0.0, pi / 2)[1:])
        case Cylinder(radius, length):
            return revolve(
                [(0.0, -length / 2), (radius, -length / 2), (radius, length / 2), (0.0, length / 2)]
            )
        case Capsule(radius, length):
            below, above = arc(radius, -pi / 2, 0.0), arc(radius, 0.0, pi / 2)
            return revolve([(r, z - length / 2) for r, z in below] + [(r, z + length / 2) for r, z in above])
        case Plane((width, depth)):
            x, y = width / 2, depth / 2
            return np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]), np.array(
                [(0, 1, 2), (0, 2, 3)], np.int32
            )
        case Mesh(path, scale):
            vertices, faces = weld_vertices(read_stl(path))
            mirrored = scale[0] * scale[1] * scale[2] < 0
            return vertices * scale, faces[:, ::-1] if mirrored else faces


def mapped_shape(geometry: Geometry) -> tuple[Vertices, Faces, Coordinates] | None:
    """Return the vertices and triangles of a shape with the places of their corners in an image.

    Returns:
        Vertices, faces, and texture coordinates of shape ``(m, 3, 2)``; None for a shape without any.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    if isinstance(geometry, Mesh):
        places = read_coordinates(geometry.path)
        vertices, faces = triangles_of(geometry)
        if places is None or len(places) != len(faces):
            return None
        mirrored = geometry.scale[0] * geometry.scale[1] * geometry.scale[2] < 0
        return vertices, faces, places[:, ::-1] if mirrored else places
    mapped = mapped_triangles(geometry)
    return None if mapped is None else (*weld_vertices(mapped[0]), mapped[1])


def shapes_of(link: Link) -> tuple[Collision | Visual, ...]:
    """Return the collision shapes and the visuals of a link."""
    return (*link.collisions, *link.visuals)


def box_around(shapes: Iterable[tuple[Pose, Geometry]]) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners of the box around bounded shapes at their poses, m; None without any.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    boxes = [_box(pose, geometry) for pose, geometry in shapes if not isinstance(geometry, Plane)]
    if not boxes:
        return None
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


@lru_cache(maxsize=2048)
def _box(pose: Pose, geometry: Geometry) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around a shape; the files of meshes are named after their contents."""
    place = matrix_of(pose)
    points = transform(triangles_of(geometry)[0], place)
    return points.min(0), points.max(0)
