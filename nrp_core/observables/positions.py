"""Positions of the models of a running world, and horizontal distances to their shapes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from math import cos, hypot, pi, sin, sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import CapabilityError, SceneError
from nrp_core.scene.model import Box, Capsule, Cylinder, Geometry, Link, Model, Plane, Scene, Sphere
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world.physics_observer import unchanged_ns
from nrp_core.world.world import World

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


def distances(corners: FloatArray, radius: FloatArray, points: FloatArray) -> FloatArray:
    """Return what :meth:`Footprint.distance` returns for many footprints and points, bit for bit.

    Args:
        corners: of each footprint, shape ``(n, corners, 2)``.
        radius: of each, shape ``(n,)``.
        points: a point for each, shape ``(n, 2)``.
    """
    edges, ahead = np.roll(corners, -1, axis=1) - corners, points[:, None] - corners
    dx, dy, px, py = edges[..., 0], edges[..., 1], ahead[..., 0], ahead[..., 1]
    length2 = dx * dx + dy * dy
    t = np.clip((px * dx + py * dy) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    x, y = px - t * dx, py - t * dy
    found: FloatArray = np.maximum(0.0, np.sqrt(x * x + y * y).min(axis=1) - radius)
    if corners.shape[1] > 2:
        found[(dx * py - dy * px >= 0.0).all(axis=1)] = 0.0
    return found


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
    x, y = px - t * dx, py - t * dy
    return sqrt(x * x + y * y)  # not hypot, of which NumPy computes other bits for many copies


Poses = Mapping[str, Pose]
"""The poses of models by their names."""
FAST_M_S = 10.0


class GroundPositions:
    """The poses of all models, read once per step.

    Args:
        world: an open world; without poses if its engine does not report them.
        period_ns: time between two steps.

    Attributes:
        moving: the names of the models that can move, in the order of the scene.
    """

    moving: Sequence[str] = ()

    def __init__(self, world: World, period_ns: int = 0) -> None:
        self._world, self._period_ns = world, period_ns
        self._are_reported = world.capabilities.poses
        self._scene: Scene | None = None
        self._numbers: FloatArray
        self.poses = {}
        self.refresh()

    def refresh(self) -> None:
        """Read the present poses; those of static models change only with the scene."""
        if not self._are_reported:
            return
        engine = self._world.engine
        if engine.scene is not self._scene:
            self._scene = engine.scene
            self._fixed = {model.name: model.pose for model in self._scene.models}
            self.moving = [model.name for model in self._scene.models if not model.static]
        self.poses = self._fixed | {name: engine.model_pose(name) for name in self.moving}

    @cached_property
    def poses(self) -> Poses:
        """The poses of all models at the moment; made from numbers when they are read."""
        rows = zip(self.moving, self._numbers.tolist(), strict=True)
        return self._fixed | {name: Pose(tuple(row[:3]), tuple(row[3:])) for name, row in rows}

    def set_numbers(self, numbers: FloatArray) -> None:
        """Set the present poses of the moving models: positions and orientations (x, y, z, w) in rows."""
        self._numbers = numbers
        vars(self).pop("poses", None)

    def unchanged_ns(self, gap_m: float, *models: str) -> int:
        """Return the time for which a distance between models stays on the same side of a limit, ns.

        Speeds are read only where it matters: not if the bound holds even at 10 m/s.

        Args:
            gap_m: how far the distance is from the limit, m.
            models: the models.
        """
        surely_ns = unchanged_ns(gap_m, FAST_M_S)
        if surely_ns >= self._period_ns:
            return surely_ns
        motions = [self._world.engine.model_motion(name) for name in models if name in self.moving]
        return unchanged_ns(gap_m, sum(hypot(*motion.linear) for motion in motions))

    def __contains__(self, model: object) -> bool:
        return model in self.poses

    def pose(self, model: str) -> Pose:
        """Return the pose of a model."""
        return self.poses[model]

    def ground(self, model: str) -> GroundPoint:
        """Return the horizontal position of a model's origin."""
        x, y, _ = self.poses[model].position
        return x, y


def require_poses(world: World) -> None:
    """Refuse a world without poses of models.

    Raises:
        CapabilityError: its engine does not report poses of models.
    """
    if not world.capabilities.poses:
        raise CapabilityError("the world does not report where models are, so no distance is known")


Target = Callable[[GroundPositions], Footprint]
"""Returns the footprint of a target now."""


def target_of(place: GroundPoint | str, scene: Scene) -> Target:
    """Return the footprint of a point, of a model's origin, or of a visual (``model/link/visual``).

    Raises:
        SceneError: the scene does not have the model or visual, or a joint moves the visual relative to its
            model.
        CapabilityError: the visual is a mesh.
    """
    if not isinstance(place, str):
        point = Footprint((place,))
        return lambda _where: point
    if "/" in place:
        return _VisualFootprint(place, scene)
    other = scene.model(place).name
    return lambda where: Footprint((where.ground(other),))


class _VisualFootprint:
    """The footprint of a visual, computed again only after a motion of its model."""

    def __init__(self, path: str, scene: Scene) -> None:
        visual = scene.visual(path)
        model, link = next(
            (model, link)
            for model, link in scene.links()
            if any(f"{model.name}/{link.name}/{visual.name}" == path for visual in link.visuals)
        )
        _require_rigid(model, link)
        self._model, self._geometry = model.name, visual.geometry
        self._on_model = link.pose @ visual.pose
        self._pose = model.pose
        self._footprint = Footprint.of(self._geometry, self._pose @ self._on_model)

    def __call__(self, where: GroundPositions) -> Footprint:
        pose = where.pose(self._model)
        if pose != self._pose:
            self._pose = pose
            self._footprint = Footprint.of(self._geometry, pose @ self._on_model)
        return self._footprint


def _require_rigid(model: Model, link: Link) -> None:
    """Refuse a link that a joint moves relative to its model."""
    holding = {joint.child: joint for joint in model.joints}
    name = link.name
    while name in holding:
        joint = holding[name]
        if joint.kind != "fixed":
            raise SceneError(
                f"the distance to link '{model.name}/{link.name}' is not known: joint '{joint.name}' moves it"
            )
        name = joint.parent
