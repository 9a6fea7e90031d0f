"""Collision shapes in the world: their points, bounding boxes, and the depth of other points inside them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import hypot, inf
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import SceneError
from nrp_core.world.raycast.collisions import signed_distance
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.implausible_shapes import box_around, solid_or_seen
from nrp_core.world.scene.model import (
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
from nrp_core.world.scene.tessellation import triangles_of

_LATTICE = np.array(list(product(np.linspace(-0.5, 0.5, 5), repeat=3)))
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
        place = matrix_of(self.pose)
        return np.asarray(local @ place[:, :3].T + place[:, 3])

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest corner of the box around the shape, m."""
        surface = self._surface if isinstance(self.geometry, Heightmap) else self.points
        return surface.min(0), surface.max(0)

    @cached_property
    def _surface(self) -> FloatArray:
        """All vertices of the shape, m, shape ``(n, 3)``."""
        place = matrix_of(self.pose)
        return np.asarray(triangles_of(self.geometry)[0] @ place[:, :3].T + place[:, 3])

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
        """Whether it has no bounds."""
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
        place = matrix_of(self.pose)
        local = (points - place[:, 3]) @ place[:, :3]
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


def size_m(model: Model) -> float | None:
    """Return the horizontal size of a model, m; None without shapes that can be read."""
    try:
        corners = [corner[:2] for solid in solids_of(model) for corner in solid.box]
    except SceneError:
        return None
    return float(hypot(*np.ptp(np.array(corners), axis=0))) if corners else None


def outside_m(scene: Scene, point: tuple[float, float]) -> float:
    """Return how far a point on the ground is outside the rectangle around a scene, m.

    It is 0 inside, and where the scene has no end or a shape cannot be read.
    """
    solids = [solid for model in scene.models for solid in solids_of(model)]
    if not solids or any(isinstance(solid.geometry, Plane) for solid in solids):
        return 0.0
    try:
        corners = np.array([corner[:2] for solid in solids for corner in solid.box])
    except SceneError:
        return 0.0
    beyond = np.maximum(corners.min(0) - point, point - corners.max(0))
    return float(np.linalg.norm(np.maximum(beyond, 0.0)))


def inside_m(scene: Scene, point: tuple[float, float], height_m: float) -> tuple[str, float] | None:
    """Return the part of the room in which a point on the ground is deepest, and how deep; None if in none.

    Only parts that reach from below a height to above it count, so no floor; a mesh counts as hollow.
    """
    depths = {
        solid.name: solid.depth_of(np.array([(*point, (solid.lowest_m + solid.highest_m) / 2)]))
        for solid in room_of(scene)
        if not isinstance(solid.geometry, Plane | Heightmap | Mesh)
        if solid.lowest_m < height_m < solid.highest_m
    }
    deepest = max(depths, key=depths.__getitem__, default=None)
    return None if deepest is None else (deepest, depths[deepest])


def _across(shapes: list[Solid], origins: list[tuple[float, ...]]) -> float:
    """Return the diagonal of the rectangle around shapes and origins of models, m."""
    try:
        boxes = [corner[:2] for shape in shapes for corner in shape.box]
    except SceneError:
        return float("inf")
    points = np.array([*boxes, *origins, (0.0, 0.0)])
    return hypot(*np.ptp(points, axis=0))


_LEAST_M, _MOST_M = 0.02, 0.05
"""Limits of the tolerated overlap: engines correct it without throwing the model."""


@dataclass(frozen=True, slots=True)
class Overlap:
    """A collision shape of a model inside one of the room, both as ``model/link/collision``."""

    part: str
    room: str
    depth_m: float
    tolerated_m: float


def deepest_overlap(model: Model, room: Sequence[Solid]) -> Overlap | None:
    """Return the deepest overlap of a model with a room at the start, if it is more than is tolerated."""
    parts = list(solids_of(model))
    if not parts:
        return None
    points = np.vstack([part.points for part in parts])
    height_m = float(np.ptp(points[:, 2]))
    overlaps = [
        Overlap(part.name, solid.name, solid.depth_of(part.points), _tolerated_m(height_m, solid))
        for part in parts
        for solid in room
        if _near(part, solid)
    ]
    too_deep = (overlap for overlap in overlaps if overlap.depth_m > overlap.tolerated_m)
    return max(too_deep, key=lambda overlap: overlap.depth_m, default=None)


def _tolerated_m(height_m: float, solid: Solid) -> float:
    """Return the tolerated overlap; it is smaller for low models and in thin solids."""
    return max(_LEAST_M, min(_MOST_M, 0.2 * height_m, solid.half_thickness_m / 2))


def has_ground(model: Model, scene: Scene) -> bool:
    """Return whether some shape of another model is below a model at the start."""
    points = np.vstack([solid.points for solid in solids_of(model)])
    others = (solid for other in scene.models if other.name != model.name for solid in solids_of(other))
    return any(solid.is_below(points) for solid in others)


def height_above_ground_m(model: Model, scene: Scene) -> float:
    """Return the height of the lowest point of a model above the shapes of other models below it, m.

    A shape counts as its bounding box, so the result is never too large; above a slope it is 0.
    """
    points = np.vstack([solid.points for solid in solids_of(model)])
    others = (solid for other in scene.models if other.name != model.name for solid in solids_of(other))
    tops = [solid.highest_m for solid in others if solid.is_below(points)]
    return max(0.0, float(points[:, 2].min()) - max(tops)) if tops else 0.0


def below_ground(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield each static model below the ground that robots stand on, with the collision shape that covers it.

    A model with something below it is in a cellar, and one that is as wide as the shape above it is its
    foundation.

    Args:
        scene: the scene with the robots at their start poses.
        robots: names of the robots.
    """
    names = set(robots)
    feet = [solid.lowest_m for model in scene.models if model.name in names for solid in solids_of(model)]
    room = room_of(scene)
    for model in scene.models if feet else ():
        own = list(solids_of(model))
        if not model.static or model.name in names or not own or any(solid.is_endless for solid in own):
            continue
        points = np.vstack([corner for solid in own for corner in solid.box])
        others = [solid for solid in room if solid not in own]
        covers = [one for one in others if one.highest_m < min(feet) + _MOST_M and _covers(one, points)]
        if covers and not any(one.is_below(points) for one in others if one not in covers):
            yield model.name, covers[0].name


def buried(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str, float, str]]:
    """Yield each robot that cannot fall and is below a ground without end, its top (m), and the ground.

    Those that can fall start inside the ground, which :func:`deepest_overlap` finds.
    """
    names = set(robots)
    grounds = [solid for solid in room_of(scene) if solid.is_endless and solid.highest_m < inf]
    lowest = min(grounds, key=lambda solid: solid.highest_m, default=None)
    for model in scene.models if lowest else ():
        if model.name not in names or can_fall(model, scene):
            continue
        shapes = ((link, one) for link in model.links for one in solid_or_seen(link))
        box = box_around((model.pose @ link.pose @ one.pose, one.geometry) for link, one in shapes)
        if lowest is not None and box is not None and box[1][2] < lowest.highest_m - _MOST_M:
            yield model.name, float(box[1][2]), lowest.name


def _covers(ground: Solid, points: FloatArray) -> bool:
    """Return whether points are below a much wider shape, with room between them."""
    low, high = points.min(0), points.max(0)
    if high[2] > ground.highest_m - _MOST_M:
        return False
    if ground.is_endless:
        return ground.highest_m < inf
    ground_low, ground_high = ground.box
    inside = bool(((ground_low <= low) & (high <= ground_high))[:2].all())
    wide = float(np.prod((high - low)[:2])) < 0.5 * float(np.prod((ground_high - ground_low)[:2]))
    return inside and wide and bool(high[2] < ground_low[2] + _MOST_M)


def can_fall(model: Model, scene: Scene) -> bool:
    """Return whether a model has collision shapes and is free to fall."""
    held = model.static or any(joint.parent == WORLD for joint in model.joints)
    return scene.gravity[2] < 0 and not held and any(link.collisions for link in model.links)


def _near(part: Solid, solid: Solid) -> bool:
    """Return whether the boxes around two shapes meet."""
    if isinstance(solid.geometry, Plane):
        return True
    (low, high), (room_low, room_high) = part.box, solid.box
    apart = (low > room_high) | (high < room_low)
    if isinstance(solid.geometry, Heightmap):
        apart[2] = low[2] > room_high[2]  # below its surface everything is inside
    return not bool(apart.any())
