"""Horizontal distances to the shapes of a scene, seen from above.

The footprint of a shape is the convex hull of a few points, extended by a radius. This is exact except for
cylinders, whose rims are polygons of 64 corners (0.12 % of the radius).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from math import cos, hypot, pi, sin

from nrp_core.errors import CapabilityError
from nrp_core.world.rigid import Pose, Vector
from nrp_core.world.scene.model import Box, Capsule, Cylinder, Geometry, Plane, Sphere

GroundPoint = tuple[float, float]

_RIM = [(cos(2 * pi * k / 64), sin(2 * pi * k / 64)) for k in range(64)]


@dataclass(frozen=True, slots=True)
class Footprint:
    """The footprint of a shape on the ground.

    Args:
        corners: corners of a convex polygon, counter-clockwise; two for a line, one for a point.
        radius: extension of the footprint beyond it, m; infinite for a plane.
    """

    corners: tuple[GroundPoint, ...]
    radius: float = 0.0

    @classmethod
    def of(cls, geometry: Geometry, pose: Pose) -> Footprint:
        """Return the footprint of a shape.

        Raises:
            CapabilityError: the shape is a mesh.
        """
        if isinstance(geometry, Plane):
            return cls(((0.0, 0.0),), float("inf"))
        points = [pose @ Pose(point) for point in _hull_points(geometry)]
        radius = geometry.radius if isinstance(geometry, (Sphere, Capsule)) else 0.0
        return cls(convex_hull([point.position[:2] for point in points]), radius)

    def distance(self, point: GroundPoint) -> float:
        """Return the distance of a point from the footprint; 0 inside."""
        corners = self.corners
        edges = [*pairwise(corners), (corners[-1], corners[0])]
        if len(corners) > 2 and all(_cross(a, b, point) >= 0 for a, b in edges):
            return 0.0
        return max(0.0, min(_to_segment(a, b, point) for a, b in edges) - self.radius)


def convex_hull(points: list[GroundPoint]) -> tuple[GroundPoint, ...]:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return tuple(ordered)
    return tuple(_chain(ordered)[:-1] + _chain(ordered[::-1])[:-1])


def _chain(points: list[GroundPoint]) -> list[GroundPoint]:
    chain: list[GroundPoint] = []
    for point in points:
        while len(chain) > 1 and _cross(chain[-2], chain[-1], point) <= 0:
            chain.pop()
        chain.append(point)
    return chain


def _hull_points(geometry: Geometry) -> list[Vector]:
    if isinstance(geometry, Box):
        x, y, z = (length / 2 for length in geometry.size)
        return list(product((-x, x), (-y, y), (-z, z)))
    if isinstance(geometry, Sphere):
        return [(0.0, 0.0, 0.0)]
    if isinstance(geometry, Capsule):
        return [(0.0, 0.0, -geometry.length / 2), (0.0, 0.0, geometry.length / 2)]
    if isinstance(geometry, Cylinder):
        r, h = geometry.radius, geometry.length / 2
        return [(r * x, r * y, z) for x, y in _RIM for z in (-h, h)]
    raise CapabilityError("the distance to a mesh is not known; name a visual of simple shape beside it")


def _cross(a: GroundPoint, b: GroundPoint, c: GroundPoint) -> float:
    """Twice the area of the triangle a, b, c; positive where c is left of a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _to_segment(a: GroundPoint, b: GroundPoint, point: GroundPoint) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    px, py = point[0] - a[0], point[1] - a[1]
    length2 = dx * dx + dy * dy
    t = min(1.0, max(0.0, (px * dx + py * dy) / length2)) if length2 else 0.0
    return hypot(px - t * dx, py - t * dy)
