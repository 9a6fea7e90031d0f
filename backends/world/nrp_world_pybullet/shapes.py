"""Shapes as PyBullet's shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any, TypeVar

from nrp_core.world.render.optics import drawn, flat
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Plane,
    Sphere,
    Visual,
)
from nrp_world_pybullet.library import bullet

MAX_SHAPES = 16
"""PyBullet's limit of shapes in one link; beyond it the process crashes."""
NO_SHAPE = -1
GROUND_M, GROUND_DEPTH_M = 2000.0, 100.0

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Shapes:
    """Shapes that fit into one link, in its frame.

    Args:
        collisions: collisions with the same friction, which PyBullet sets for a whole link.
        visuals: visuals with their paths ``model/link/visual``.
    """

    collisions: Sequence[Collision] = ()
    visuals: Sequence[tuple[str, Visual]] = ()


def shapes_of(model: str, body: Body, with_visuals: bool) -> list[Shapes]:
    """Return the shapes of a body, distributed to as many links as PyBullet needs, at least one."""
    visuals = [
        (f"{model}/{link.name}/{visual.name}", replace(visual, pose=link.pose @ visual.pose))
        for link in body.links
        for visual in (link.visuals if with_visuals else ())
    ]
    by_friction: dict[float, list[Collision]] = {}
    for link in body.links:
        for collision in link.collisions:
            placed = replace(collision, pose=link.pose @ collision.pose)
            by_friction.setdefault(collision.friction, []).append(placed)
    collisions = (chunk for alike in by_friction.values() for chunk in _chunks(alike))
    pairs = zip_longest(collisions, _chunks(visuals), fillvalue=())
    return [Shapes(touching, seen) for touching, seen in pairs] or [Shapes()]


def _chunks(items: Sequence[T]) -> Iterator[Sequence[T]]:
    return (items[start : start + MAX_SHAPES] for start in range(0, len(items), MAX_SHAPES))


def add_collisions(collisions: Sequence[Collision], client: int) -> int:
    """Load collision shapes as one compound and return its id."""
    if not collisions:
        return NO_SHAPE
    shapes = [_touched(collision.geometry, collision.pose) for collision in collisions]
    return int(bullet.createCollisionShapeArray(**_arguments(shapes, "collision"), physicsClientId=client))


def _touched(geometry: Geometry, pose: Pose) -> tuple[Geometry, Pose]:
    """Return the collision geometry; for a plane a block, because boxes that slide on a plane rattle."""
    if not isinstance(geometry, Plane):
        return geometry, pose
    return Box((GROUND_M, GROUND_M, GROUND_DEPTH_M)), pose @ Pose((0.0, 0.0, -GROUND_DEPTH_M / 2))


def add_visuals(visuals: Sequence[tuple[str, Visual]], client: int) -> int:
    """Load visuals as one compound in the same order, and return its id."""
    if not visuals:
        return NO_SHAPE
    shapes = [drawn(visual.geometry, visual.pose) for _, visual in visuals]
    colors = [flat(visual.rgba) for _, visual in visuals]
    arguments = _arguments(shapes, "visual")
    return int(bullet.createVisualShapeArray(**arguments, rgbaColors=colors, physicsClientId=client))


def add_nothing_to_see(client: int) -> int:
    """Load an invisible visual, and return its id.

    A link with collision shapes needs it if it has no visuals: PyBullet would draw the collision shapes.
    """
    return add_visuals([("", Visual("nothing", Sphere(1e-3), rgba=(0.0, 0.0, 0.0, 0.0)))], client)


def _arguments(shapes: Sequence[tuple[Geometry, Pose]], kind: str) -> dict[str, Any]:
    """Return the arguments of PyBullet's array functions, which take every size of every shape."""
    rows = [_row(geometry) for geometry, _ in shapes]
    return {
        **{name: [row[name] for row in rows] for name in rows[0]},
        f"{kind}FramePositions": [pose.position for _, pose in shapes],
        f"{kind}FrameOrientations": [pose.orientation for _, pose in shapes],
    }


def _row(geometry: Geometry) -> dict[str, Any]:
    unused = {
        "halfExtents": (1, 1, 1),
        "radii": 1,
        "lengths": 1,
        "fileNames": "",
        "meshScales": (1, 1, 1),
        "flags": 0,
    }
    match geometry:
        case Plane():
            raise AssertionError("planes are drawn as plates and collided as blocks")
        case Box((x, y, z)):
            return unused | {"shapeTypes": bullet.GEOM_BOX, "halfExtents": (x / 2, y / 2, z / 2)}
        case Sphere(radius):
            return unused | {"shapeTypes": bullet.GEOM_SPHERE, "radii": radius}
        case Cylinder(radius, length):
            return unused | {"shapeTypes": bullet.GEOM_CYLINDER, "radii": radius, "lengths": length}
        case Capsule(radius, length):
            return unused | {"shapeTypes": bullet.GEOM_CAPSULE, "radii": radius, "lengths": length}
        case Heightmap(path, scale):
            concave = {"shapeTypes": bullet.GEOM_MESH, "flags": bullet.GEOM_FORCE_CONCAVE_TRIMESH}
            return unused | concave | {"fileNames": str(path), "meshScales": scale}
        case Mesh(path, scale):
            return unused | {"shapeTypes": bullet.GEOM_MESH, "fileNames": str(path), "meshScales": scale}
