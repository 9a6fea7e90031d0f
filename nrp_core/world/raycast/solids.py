"""Collision shapes in the world: their points, bounding boxes, and the depth of other points inside them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import hypot, inf
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.errors import SceneError
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
)
from nrp_core.scene.rigid import Pose, matrix_of, transform
from nrp_core.scene.tessellation import triangles_of

_LATTICE = np.array(list(itertools.product(np.linspace(-0.5, 0.5, 5), repeat=3)))
_MAX_POINTS = 300
"""Maximum number of vertices of a shape that are checked."""
_NONE = np.empty((0, 3, 3))
_CORNERS = 4
"""Cells of the grid of a height map that are checked on each side of a point."""


_ROUNDED_M: Final = 1e-6
"""Shapes that touch are not below each other."""


@dataclass(frozen=True)
class Solid:
    """A collision shape at its initial pose in the world."""

    name: str
    geometry: Geometry
    pose: Pose

    @cached_property
    def points(self) -> FloatArray:
        """Points on and in the shape, m, shape ``(n, 3)``."""
        if isinstance(self.geometry, Box):
            local = _LATTICE * self.geometry.size
        else:
            vertices = triangles_of(self.geometry)[0]
            local = np.vstack([vertices[:: 1 + len(vertices) // _MAX_POINTS], vertices.mean(0)])
        return transform(local, matrix_of(self.pose))

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest corner of the box around the shape, m."""
        surface = self._surface if isinstance(self.geometry, Heightmap) else self.points
        return surface.min(0), surface.max(0)

    @cached_property
    def _surface(self) -> FloatArray:
        """All vertices of the shape, m, shape ``(n, 3)``."""
        return transform(triangles_of(self.geometry)[0], matrix_of(self.pose))

    @property
    def half_thickness_m(self) -> float:
        """The largest depth that a point inside the shape can have."""
        match self.geometry:
            case Box(size):
                return min(size) / 2
            case Cylinder(radius, length):
                return min(radius, length / 2)
            case Sphere(radius) | Capsule(radius):
                return radius
        return inf

    @property
    def is_endless(self) -> bool:
        """Whether it is unbounded."""
        return isinstance(self.geometry, Plane)

    @property
    def lowest_m(self) -> float:
        """The lowest height of the shape."""
        if isinstance(self.geometry, Plane) and not self._is_level:
            return -inf
        return float(self.box[0][2])

    @property
    def highest_m(self) -> float:
        """The largest height of the shape."""
        if isinstance(self.geometry, Plane):
            return self.pose.position[2] if self._is_level else inf
        return float(self.box[1][2])

    @property
    def _is_level(self) -> bool:
        return self.pose.rotate((0.0, 0.0, 1.0))[2] > 1 - 1e-6

    def is_below(self, points: FloatArray) -> bool:
        """Return whether the box around the shape reaches below one of these points."""
        if isinstance(self.geometry, Plane):
            return True
        low, high = self.box
        inside = (points[:, :2] >= low[:2]) & (points[:, :2] <= high[:2])
        return bool(np.any(inside.all(1) & (points[:, 2] > low[2] + _ROUNDED_M)))

    def depth_of(self, points: FloatArray) -> float:
        """Return how deep the deepest of these points is inside the shape, m; 0 for none."""
        if isinstance(self.geometry, Heightmap):
            return self._depth_below_surface(points)
        if isinstance(self.geometry, Mesh):
            return 0.0
        from nrp_core.world.raycast.collisions import signed_distance  # compiled code takes time to load

        place = matrix_of(self.pose)
        local = product(points - place[:, 3], place[:, :3])
        return -min(0.0, *(signed_distance(self.geometry, _NONE, (x, y, z)) for x, y, z in local.tolist()))

    def _depth_below_surface(self, points: FloatArray) -> float:
        """Return how far the deepest of these points is below the lowest of the corners around it."""
        assert isinstance(self.geometry, Heightmap)
        low, high = self.box
        over = points[((points[:, :2] >= low[:2]) & (points[:, :2] <= high[:2])).all(1)]
        if not len(over):
            return 0.0
        cells = np.array([self.geometry.columns, self.geometry.rows]) - 1
        width_m = 2 * float(((high - low)[:2] / cells).max())
        around = (self._surface[:, :2] >= over[:, :2].min(0) - width_m) & (
            self._surface[:, :2] <= over[:, :2].max(0) + width_m
        )
        corners = self._surface[around.all(1)]
        apart = np.linalg.norm(corners[None, :, :2] - over[:, None, :2], axis=2)
        nearest = np.argsort(apart, axis=1)[:, :_CORNERS]
        return max(0.0, float((corners[nearest, 2].min(1) - over[:, 2]).max()))


def solids_of(model: Model) -> Iterator[Solid]:
    """Yield the collision shapes of a model at their initial poses."""
    for link in model.links:
        for collision in link.collisions:
            name = f"{model.name}/{link.name}/{collision.name}"
            yield Solid(name, collision.geometry, model.pose @ link.pose @ collision.pose)


def room_of(scene: Scene) -> list[Solid]:
    """Return all collision shapes of a scene that never move."""
    return [solid for model in scene.models if model.static for solid in solids_of(model)]


_ENDLESS_M: Final = 100.0
"""The smallest width of a scene with an endless floor: about as far as robots go in a few minutes."""
_TIMES: Final = 10.0
"""Assumed width of an endless floor, in multiples of the width of the objects on it."""


def width_m(scene: Scene) -> float:
    """Return the largest horizontal distance in a scene, m; infinite if a shape cannot be read.

    An endless floor counts as ten times as wide as the objects on it, and at least 100 m.
    """
    solids = [solid for model in scene.models for solid in solids_of(model)]
    shapes = [solid for solid in solids if not isinstance(solid.geometry, Plane)]
    width = _across(shapes, [model.pose.position[:2] for model in scene.models])
    return width if len(shapes) == len(solids) else max(_ENDLESS_M, _TIMES * width)


def _across(shapes: list[Solid], origins: list[tuple[float, ...]]) -> float:
    """Return the diagonal of the rectangle around shapes and origins of models, m."""
    try:
        boxes = [corner[:2] for shape in shapes for corner in shape.box]
    except SceneError:
        return float("inf")
    points = np.array([*boxes, *origins, (0.0, 0.0)])
    return hypot(*np.ptp(points, axis=0))


def can_fall(model: Model, scene: Scene) -> bool:
    """Return whether a model has collision shapes and is free to fall."""
    held = model.static or any(joint.parent == WORLD for joint in model.joints)
    return scene.gravity[2] < 0 and not held and any(link.collisions for link in model.links)
