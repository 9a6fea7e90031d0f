"""Texture coordinates of shapes that are not meshes.

An image covers each side of a box, a plane and each end of a cylinder, and goes once around a sphere and the
side of a cylinder. Capsules and other shapes have none.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.scene.meshes.triangles import Coordinates, Triangles
from nrp_core.world.scene.meshes.turned import SLICES, STACKS
from nrp_core.world.scene.model import Box, Cylinder, Geometry, Plane, Sphere

Mapped = tuple[Triangles, Coordinates]

_QUAD = np.array([(0, 1, 2), (0, 2, 3)])
_IMAGE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)[_QUAD]
_SIDES = np.array([
    [(1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)],
    [(-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)],
    [(1, 1, -1), (-1, 1, -1), (-1, 1, 1), (1, 1, 1)],
    [(-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)],
    [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)],
    [(-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, -1)],
]) / 2  # fmt: skip
"""Sides of a box: x, -x, y, -y, top and bottom, each from its lower left corner as seen from outside."""


def mapped_triangles(geometry: Geometry) -> Mapped | None:
    """Return the triangles of a shape with their texture coordinates; None for kinds without any."""
    match geometry:
        case Box(size):
            return (_SIDES[:, _QUAD] * size).reshape(-1, 3, 3), np.tile(_IMAGE, (6, 1, 1))
        case Plane((width, depth)):
            return _SIDES[4][_QUAD] * (width, depth, 0.0), _IMAGE
        case Sphere(radius):
            angles = [pi * (i / (2 * STACKS) - 0.5) for i in range(2 * STACKS + 1)]
            return _around([(radius * np.cos(angle), radius * np.sin(angle)) for angle in angles])
        case Cylinder(radius, length):
            side = _around([(radius, -length / 2), (radius, length / 2)])
            ends = [_end(radius, z) for z in (-length / 2, length / 2)]
            return np.concatenate([side[0], *(end[0] for end in ends)]), np.concatenate(
                [side[1], *(end[1] for end in ends)]
            )
    return None


def _around(profile: list[tuple[float, float]]) -> Mapped:
    """Return a profile rotated about z, with the image once around it."""
    turns = np.linspace(0, 1, SLICES + 1)
    heights = np.linspace(0, 1, len(profile))
    rings = [
        np.stack([r * np.cos(2 * pi * turns), r * np.sin(2 * pi * turns), np.full(SLICES + 1, z)], axis=1)
        for r, z in profile
    ]
    maps = [np.stack([turns, np.full(SLICES + 1, height)], axis=1) for height in heights]
    return _bands(rings), _bands(maps).astype(np.float32)


def _bands(rings: list[FloatArray]) -> FloatArray:
    """Return the triangles between lines of points, which run to the right as seen from outside."""
    quads = [np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1) for low, high in pairwise(rings)]
    corners: FloatArray = np.concatenate(quads)[:, _QUAD]
    return corners.reshape(-1, 3, corners.shape[-1])


def _end(radius: float, z: float) -> Mapped:
    """Return an end of a cylinder, with the image across it."""
    turns = np.linspace(0, 2 * pi, SLICES + 1)
    rim = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    here, there = (rim[:-1], rim[1:]) if z > 0 else (rim[1:], rim[:-1])
    flat = np.stack([np.zeros_like(here), here, there], axis=1)
    heights = np.full((*flat.shape[:2], 1), z)
    seen = flat * (1, 1 if z > 0 else -1)
    return np.concatenate([flat * radius, heights], axis=2), (0.5 + seen / 2).astype(np.float32)
