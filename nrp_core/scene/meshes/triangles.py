"""Triangles of mesh files, before they are placed in a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.scene.model import Box, Cylinder, Geometry, Plane, Rgba, Sphere

Triangles = npt.NDArray[np.float64]
"""Corners of triangles, counter-clockwise as seen from outside; shape ``(m, 3, 3)``, in m."""
Points = npt.NDArray[np.float64]
"""Shape ``(n, 3)``, in m."""
Coordinates = npt.NDArray[np.float32]
"""Places in an image of the corners of triangles, from its lower left corner at 0, 0; shape ``(m, 3, 2)``."""
Faces = npt.NDArray[np.int32]
"""Indices of the corners of triangles, shape ``(m, 3)``."""

_MIXERS = np.array(
    [0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64
)  # large odd numbers


@dataclass(frozen=True)
class Surface:
    """Triangles of a file with the same look.

    Args:
        names: names in the file of the objects that contain them; a ``<submesh>`` names one of these.
        triangles: at least one.
        rgba: their colour, None if the file has none; with an image its mean.
        coordinates: texture coordinates, None if the file has none.
        image: the name in the file of the image on them, None for none.
        held: the contents of an image that is inside of the file.
        depth: thickness of the solid behind a concave surface, m; None for others.
    """

    names: frozenset[str]
    triangles: Triangles
    rgba: Rgba | None = None
    coordinates: Coordinates | None = None
    image: str | None = None
    held: bytes | None = None
    depth: float | None = None


def concatenate(surfaces: Sequence[Surface]) -> Triangles:
    """Return the triangles of several surfaces."""
    return np.concatenate([surface.triangles for surface in surfaces])


def merge_surfaces(surfaces: Sequence[Surface]) -> Surface:
    """Return several surfaces as one with the look of the first."""
    coordinates = None
    if any(surface.coordinates is not None for surface in surfaces):
        coordinates = np.concatenate([_coordinates(surface) for surface in surfaces])
    return replace(surfaces[0], triangles=concatenate(surfaces), coordinates=coordinates)


def _coordinates(surface: Surface) -> Coordinates:
    if surface.coordinates is None:
        return np.zeros((len(surface.triangles), 3, 2), np.float32)
    return surface.coordinates


def weld_vertices(triangles: Triangles) -> tuple[Points, Faces]:
    """Return the distinct corners of triangles, and the indices of the triangles' corners."""
    points = triangles.reshape(-1, 3) + 0.0  # turns -0 into 0
    # numbers sort many times faster than rows; in the rare case that two rows are one number, rows are sorted
    bits = points.astype(np.float32).view(np.uint32).astype(np.uint64)
    numbers = (bits * _MIXERS).sum(axis=1, dtype=np.uint64)
    distinct, inverse = np.unique(numbers, return_inverse=True)
    corners = np.empty((len(distinct), 3))
    corners[inverse] = points
    if not np.array_equal(corners[inverse], points):
        corners, inverse = np.unique(points, axis=0, return_inverse=True)
    return corners, inverse.reshape(-1, 3).astype(np.int32)


def area_of(triangles: Triangles) -> float:
    """Return the area of triangles, m^2."""
    a, b, c = triangles.swapaxes(0, 1)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def connected_pieces(points: Points, faces: Faces) -> tuple[int, IntArray]:
    """Return the number of pieces that are connected by common corners, and the piece of each corner."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ends = np.concatenate([faces[:, :2], faces[:, 1:]]).T
    links = coo_array((np.ones(ends.shape[1], bool), tuple(ends)), shape=(len(points), len(points)))
    count, labels = connected_components(links, directed=False)
    return count, labels


SLICES = 32
"""Number of corners around the axis; the polygon deviates from its circle by up to 0.5 % of the radius."""
STACKS = 8
"""Number of steps from the equator of a sphere to a pole."""

Profile = Sequence[tuple[float, float]]
"""A profile: distances from the axis and heights, from below."""


def arc(radius: float, start: float, end: float) -> list[tuple[float, float]]:
    """Return the profile of a sphere between two angles above the equator."""
    angles = [start + (end - start) * i / STACKS for i in range(STACKS + 1)]
    return [(radius * cos(angle), radius * sin(angle)) for angle in angles]


def revolve(profile: Profile) -> tuple[Points, Faces]:
    """Return the surface of a profile rotated about z, counter-clockwise as seen from outside."""
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
