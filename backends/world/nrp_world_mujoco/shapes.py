"""Shapes as MuJoCo's geoms."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.world.render.optics import drawn, flat
from nrp_core.world.rigid.pose import Pose, Quaternion
from nrp_core.world.scene.meshes.terrain import heights_of
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
from nrp_core.world.scene.tessellation import triangles_of
from nrp_world_mujoco.library import COLLISIONS, VISUALS, mujoco

THICKNESS = 1.0
"""Thickness of the ground below the lowest point of a height map, m."""
MIN_EXTENT = 1e-6
"""Minimum height of a height map in MuJoCo, m."""


class Shapes:
    """Adds shapes to the bodies of a specification; a mesh is loaded once."""

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self._meshes: dict[Mesh, str] = {}

    def add_visual(self, body: Any, visual: Visual, place: Pose) -> Any:
        """Add a visual of a link at ``place`` in a body, and return its geom."""
        geometry, pose = drawn(visual.geometry, place @ visual.pose)
        looks = {"group": VISUALS, "contype": 0, "conaffinity": 0, "rgba": flat(visual.rgba)}
        return body.add_geom(mass=0, **looks, **self._arguments(geometry, pose))

    def add_collision(self, body: Any, collision: Collision, place: Pose, name: str) -> Any:
        """Add a collision of a link at ``place`` in a body, and return its geom, which gets a name."""
        return body.add_geom(
            name=name,
            mass=0,
            group=COLLISIONS,
            condim=3 if collision.friction else 1,
            friction=[collision.friction, 0, 0],
            # in a contact the geom with the higher priority decides: the more slippery one; those of MJCF
            # have their own, usually 0, so that their contacts are MuJoCo's
            priority=round(1000 * (1 - collision.friction)),
            **self._arguments(collision.geometry, place @ collision.pose),
        )

    def _arguments(self, geometry: Geometry, pose: Pose) -> dict[str, Any]:
        kinds = mujoco.mjtGeom
        match geometry:
            case Box((x, y, z)):
                return {"type": kinds.mjGEOM_BOX, "size": [x / 2, y / 2, z / 2], **placed(pose)}
            case Sphere(radius):
                return {"type": kinds.mjGEOM_SPHERE, "size": [radius, 0, 0], **placed(pose)}
            case Cylinder(radius, length):
                return {"type": kinds.mjGEOM_CYLINDER, "size": [radius, length / 2, 0], **placed(pose)}
            case Capsule(radius, length):
                return {"type": kinds.mjGEOM_CAPSULE, "size": [radius, length / 2, 0], **placed(pose)}
            case Plane():
                return {"type": kinds.mjGEOM_PLANE, "size": [0, 0, 1], **placed(pose)}
            case Heightmap():
                name, bottom = self._ground(geometry)
                return {"type": kinds.mjGEOM_HFIELD, "hfieldname": name, **placed(pose @ bottom)}
            case Mesh():
                return {"type": kinds.mjGEOM_MESH, "meshname": self._mesh(geometry), **placed(pose)}

    def _ground(self, ground: Heightmap) -> tuple[str, Pose]:
        """Load a height map; return its name, and the height of its lowest point."""
        x, y, z = ground.scale
        heights = heights_of(ground) * z
        lowest, extent = float(heights.min()), max(float(np.ptp(heights)), MIN_EXTENT)
        if ground not in self._meshes:
            self._meshes[ground] = f"ground{len(self._meshes)}"
            self._spec.add_hfield(
                name=self._meshes[ground], nrow=ground.rows, ncol=ground.columns,
                size=[x / 2, y / 2, extent, THICKNESS], userdata=((heights - lowest) / extent).ravel(),
            )  # fmt: skip
        return self._meshes[ground], Pose((0.0, 0.0, lowest))

    def _mesh(self, mesh: Mesh) -> str:
        if mesh not in self._meshes:
            self._meshes[mesh] = f"mesh{len(self._meshes)}"
            vertices, faces = triangles_of(mesh)
            element = self._spec.add_mesh(
                name=self._meshes[mesh], uservert=vertices.ravel(), userface=faces.ravel()
            )
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used
        return self._meshes[mesh]


def placed(pose: Pose) -> dict[str, Any]:
    """Return a pose as MuJoCo's arguments."""
    return {"pos": pose.position, "quat": scalar_first(pose.orientation)}


def scalar_first(orientation: Quaternion) -> Quaternion:
    """Return a quaternion in MuJoCo's order, w first."""
    x, y, z, w = orientation
    return w, x, y, z
