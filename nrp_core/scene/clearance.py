"""Boxes of missing meshes, cut so that at the start none is inside another model.

The size of such a box is only an estimate, so it makes way for known shapes: it is cut at the face of the
other shape that leaves most of it. A box of which nothing is left does not collide. Engines would push such
bodies apart, which topples or throws a robot.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.model import (
    Box,
    Collision,
    ConcaveMesh,
    Geometry,
    Heightmap,
    Link,
    Model,
    Plane,
    Scene,
)
from nrp_core.scene.posture import at_start
from nrp_core.scene.rigid import Pose, Vector, matrix_of, transform
from nrp_core.scene.tessellation import box_around, triangles_of

THINNEST_M = 1e-3
"""Smallest edge of a box that is left."""
_TOUCHING_M = 1e-6
"""Overlaps that are the rounding of poses."""
_BURIED_M = 100.0
"""Assumed depth of a terrain."""
_AXES = np.vstack([np.eye(3), -np.eye(3)])


@dataclass(frozen=True, slots=True)
class _Solid:
    """A convex solid in the world.

    Args:
        points: its corners, m, shape ``(n, 3)``.
        normals: outward normals of its faces, shape ``(m, 3)``.
        is_bounded: whether the corners are all that it reaches.
    """

    points: FloatArray
    normals: FloatArray
    is_bounded: bool = True

    def in_frame(self, place: FloatArray) -> _Solid:
        """Return the solid in a frame with a pose in the world, shape ``(3, 4)``."""
        points = product(self.points - place[:, 3], place[:, :3])
        return replace(self, points=points, normals=product(self.normals, place[:, :3]))


_Corners = tuple[FloatArray, FloatArray]
"""The lowest and the highest corner of a box."""


def with_clearance(scene: Scene) -> Scene:
    """Return a scene without overlap of estimated boxes and other models in the initial positions.

    Movable models come first, so the boxes of the room make way for robots.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    estimated = [model for model in scene.models if _estimates(model)]
    if not estimated:
        return scene
    pending = {model.name for model in estimated}
    placed = {model.name: at_start(model) for model in scene.models}
    for model in sorted(estimated, key=lambda one: one.static):
        start = placed[model.name]
        reach = box_around(_estimates(start))
        assert reach is not None  # boxes have bounds
        others = [one for one in placed.values() if one.name != model.name]
        others = [one for one in others if not (model.static and one.static)]
        solids = [
            part for one in others for part in _solids(one, reach, with_estimates=one.name not in pending)
        ]
        pending.discard(model.name)
        links = tuple(_cleared(link, start.pose @ link.pose, solids) for link in start.links)
        placed[model.name] = replace(start, links=links)
    return replace(scene, models=tuple(_with_shapes(model, placed[model.name]) for model in scene.models))


def _estimates(model: Model) -> list[tuple[Pose, Geometry]]:
    """Return the estimated boxes of a model with their poses in the world."""
    shapes = ((link, one) for link in model.links for one in link.collisions if one.estimated)
    return [(model.pose @ link.pose @ one.pose, one.geometry) for link, one in shapes]


def _with_shapes(model: Model, start: Model) -> Model:
    """Return a model with the collision shapes that its links have at the start."""
    links = zip(model.links, start.links, strict=True)
    return replace(model, links=tuple(replace(one, collisions=moved.collisions) for one, moved in links))


def _cleared(link: Link, pose: Pose, solids: Sequence[_Solid]) -> Link:
    """Return a link at a pose in the world whose estimated boxes overlap none of these solids."""
    if not any(one.estimated for one in link.collisions):
        return link
    cleared = (_clear(one, pose @ one.pose, solids) if one.estimated else one for one in link.collisions)
    return replace(link, collisions=tuple(one for one in cleared if one is not None))


def _clear(collision: Collision, pose: Pose, solids: Sequence[_Solid]) -> Collision | None:
    """Return the rest of a box at a pose in the world; None if nothing remains."""
    if not isinstance(collision.geometry, Box):
        return collision
    left = _outside(collision.geometry, pose, solids)
    return left and replace(collision, geometry=left[0], pose=collision.pose @ Pose(left[1]))


def part_above(height: float, box: Box, pose: Pose) -> tuple[Box, Pose] | None:
    """Return the part of a box at a pose that is above a height (m), with its pose, or None."""
    below = _Solid(np.array([[0.0, 0.0, height]]), _AXES[2:3], is_bounded=False)
    left = _outside(box, pose, [below])
    return left and (left[0], pose @ Pose(left[1]))


def _outside(box: Box, pose: Pose, solids: Sequence[_Solid]) -> tuple[Box, Vector] | None:
    """Return the part of a box at a pose that is outside of solids, with its centre in the box."""
    half = np.array(box.size) / 2
    place = matrix_of(pose)
    corners: _Corners | None = (-half, half)
    for solid in solids:
        if corners is not None:
            corners = _cut(corners, solid.in_frame(place))
    if corners is None:
        return None
    (x, y, z), (cx, cy, cz) = (corners[1] - corners[0]).tolist(), ((corners[0] + corners[1]) / 2).tolist()
    return Box((x, y, z)), (cx, cy, cz)


def _cut(corners: _Corners, solid: _Solid) -> _Corners | None:
    """Return the largest part of a box that one of its own planes separates from a solid, or None.

    The whole box is left if a face of either separates the two; two edges that pass each other do not count.
    """
    low, high = corners
    normals = np.vstack([solid.normals, _AXES]) if solid.is_bounded else solid.normals
    limits = product(solid.points, normals.T).max(0)
    lowest = np.minimum(normals * low, normals * high).sum(1)
    depths = limits - lowest
    if (depths <= _TOUCHING_M).any():
        return corners
    # a face that moves by t moves its lowest corner by t times its share of the normal
    reach = np.abs(normals) * (high - low)
    axes = reach.argmax(1)
    lost = depths / reach.max(1)
    best = int(lost.argmin())
    axis = int(axes[best])
    cut = float(lost[best] * (high - low)[axis])
    if (high - low)[axis] - cut < THINNEST_M:
        return None
    low, high = low.copy(), high.copy()
    if normals[best, axis] > 0:
        low[axis] += cut
    else:
        high[axis] -= cut
    return low, high


def _solids(model: Model, reach: _Corners, *, with_estimates: bool) -> Iterator[_Solid]:
    """Yield the collision shapes of a model at its start as convex solids in the world.

    Args:
        model: the model, with its links where its joints start.
        reach: the box outside of which shapes are ignored.
        with_estimates: whether shapes of estimated sizes count.
    """
    for link in model.links:
        for one in link.collisions:
            pose = model.pose @ link.pose @ one.pose
            if (with_estimates or not one.estimated) and _is_near(one.geometry, pose, reach):
                yield from _convex(one.geometry, matrix_of(pose), reach)


def _is_near(geometry: Geometry, pose: Pose, reach: _Corners) -> bool:
    around = None if isinstance(geometry, Heightmap) else box_around([(pose, geometry)])
    return around is None or bool((around[0] <= reach[1]).all() and (around[1] >= reach[0]).all())


def _convex(geometry: Geometry, place: FloatArray, reach: _Corners) -> Iterator[_Solid]:
    rotation = place[:, :3]
    if isinstance(geometry, Plane):
        yield _Solid(place[:, 3][None], rotation[:, 2][None], is_bounded=False)
        return
    vertices, faces = triangles_of(geometry)
    points = transform(vertices, place)
    if isinstance(geometry, Box):
        yield _Solid(points, product(_AXES, rotation.T))
    elif isinstance(geometry, ConcaveMesh):
        yield from _behind(points[faces], reach, geometry.depth)
    elif isinstance(geometry, Heightmap):
        yield from _behind(points[faces], reach, -_BURIED_M * rotation[:, 2])
    else:
        yield _Solid(points, _hull_normals(points))


def _behind(triangles: FloatArray, reach: _Corners, depth: float | FloatArray) -> Iterator[_Solid]:
    """Yield the prisms behind triangles that meet a box.

    Args:
        triangles: their corners, m, shape ``(n, 3, 3)``.
        reach: the box.
        depth: how deep the prisms are below the triangles, m, or a vector to their other ends.
    """
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    normals = np.divide(across, lengths, out=np.zeros_like(across), where=lengths > 0)
    ends = triangles + (-normals * depth if isinstance(depth, float) else depth)[..., None, :]
    prisms = np.concatenate([triangles, ends], axis=1)
    low, high = reach
    near = (prisms.min(1) <= high).all(1) & (prisms.max(1) >= low).all(1) & (lengths[:, 0] > 0)
    for prism, normal in zip(prisms[near], normals[near], strict=True):
        yield _Solid(prism, np.vstack([normal, -normal]))


def _hull_normals(points: FloatArray) -> FloatArray:
    """Return the outward normals of a convex hull, none for a flat one."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        normals = ConvexHull(points).equations[:, :3]
    except QhullError:
        return np.empty((0, 3))
    return np.unique(normals.round(6), axis=0)
