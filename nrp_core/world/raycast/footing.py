"""Checks of a model's initial pose: its overlap with the static room, and whether anything is below it.

Both checks avoid false alarms: static meshes count as ground, but models overlap only with height maps and
simple solids, because engines treat the inside of other meshes differently.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.raycast.solids import Solid, room_of, solids_of
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.implausible_shapes import box_around, solid_or_seen
from nrp_core.world.scene.model import Heightmap, Model, Plane, Scene

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
