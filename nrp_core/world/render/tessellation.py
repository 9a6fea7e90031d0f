"""Shapes as triangles, counter-clockwise as seen from outside."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from math import cos, pi, sin

import numpy as np

from nrp_core.world.render.mesh_files import Faces, Vertices, read_mesh
from nrp_core.world.scene.model import Box, Capsule, Cylinder, Geometry, Mesh, Plane, Sphere

SLICES = 32
"""Around an axis; a polygon of so many corners misses its circle by up to 0.5 % of the radius."""
STACKS = 8
"""From the equator of a sphere to a pole."""

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
            return _turned(_arc(radius, -pi / 2, 0.0) + _arc(radius, 0.0, pi / 2)[1:])
        case Cylinder(radius, length):
            return _turned(
                [(0.0, -length / 2), (radius, -length / 2), (radius, length / 2), (0.0, length / 2)]
            )
        case Capsule(radius, length):
            below, above = _arc(radius, -pi / 2, 0.0), _arc(radius, 0.0, pi / 2)
            return _turned([(r, z - length / 2) for r, z in below] + [(r, z + length / 2) for r, z in above])
        case Plane((width, depth)):
            x, y = width / 2, depth / 2
            return np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]), np.array(
                [(0, 1, 2), (0, 2, 3)], np.int32
            )
        case Mesh(path, scale):
            vertices, faces = read_mesh(path)
            mirrored = scale[0] * scale[1] * scale[2] < 0
            return vertices * scale, faces[:, ::-1] if mirrored else faces


def _arc(radius: float, start: float, end: float) -> list[tuple[float, float]]:
    angles = [start + (end - start) * i / STACKS for i in range(STACKS + 1)]
    return [(radius * cos(angle), radius * sin(angle)) for angle in angles]


def _turned(profile: Sequence[tuple[float, float]]) -> tuple[Vertices, Faces]:
    """Turn a profile of distances from the axis and heights, from below, about z."""
    around = np.arange(SLICES) * 2 * pi / SLICES
    rings = [
        np.stack([r * np.cos(around), r * np.sin(around), np.full(SLICES, z)], axis=1) for r, z in profile
    ]
    here = np.arange(SLICES)
    there = (here + 1) % SLICES
    faces = []
    for number, ((r, _), (next_r, _)) in enumerate(pairwise(profile)):
        low, high = number * SLICES, (number + 1) * SLICES
        if r > 0:
            faces.append(np.stack([low + here, low + there, high + there], axis=1))
        if next_r > 0:
            faces.append(np.stack([low + here, high + there, high + here], axis=1))
    return np.concatenate(rings), np.concatenate(faces).astype(np.int32)
