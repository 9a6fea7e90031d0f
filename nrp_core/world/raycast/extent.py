"""How far a scene extends on the ground."""

from __future__ import annotations

from math import hypot
from typing import Final

import numpy as np

from nrp_core.errors import SceneError
from nrp_core.world.raycast.solids import Solid, room_of, solids_of
from nrp_core.world.scene.model import Heightmap, Mesh, Model, Plane, Scene

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
