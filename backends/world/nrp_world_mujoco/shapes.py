"""Shapes in MuJoCo's terms."""

from __future__ import annotations

from typing import Any

from nrp_core.world.render.optics import drawn, flat
from nrp_core.world.render.tessellation import triangles_of
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    Sphere,
    Visual,
)
from nrp_core.world.scene.pose import Pose, Quaternion
from nrp_world_mujoco.engine import COLLISIONS, VISUALS, mujoco


class Shapes:
    """Adds shapes to the bodies of a specification; a mesh is loaded once."""

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self._meshes: dict[Mesh, str] = {}

    def add_visual(self, body: Any, visual: Visual, place: Pose) -> Any:
        """Add what cameras see of a link at ``place`` in a body, and return it."""
        geometry, pose = drawn(visual.geometry, place @ visual.pose)
        looks = {"group": VISUALS, "contype": 0, "conaffinity": 0, "rgba": flat(visual.rgba)}
        return body.add_geom(mass=0, **looks, **self._arguments(geometry, pose))

    def add_collision(self, body: Any, collision: Collision, place: Pose) -> Any:
        """Add what a link at ``place`` in a body touches with, and return it."""
        return body.add_geom(
            mass=0,
            group=COLLISIONS,
            condim=3 if collision.friction else 1,
            friction=[collision.friction, 0, 0],
            # where two surfaces touch, that of higher priority decides: the more slippery one
            priority=-round(1000 * collision.friction),
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
            case Mesh():
                return {"type": kinds.mjGEOM_MESH, "meshname": self._mesh(geometry), **placed(pose)}

    def _mesh(self, mesh: Mesh) -> str:
        if mesh not in self._meshes:
            self._meshes[mesh] = f"mesh{len(self._meshes)}"
            vertices, faces = triangles_of(mesh)
            element = self._spec.add_mesh(
                name=self._meshes[mesh], uservert=vertices.ravel(), userface=faces.ravel()
            )
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used; open surfaces have it
        return self._meshes[mesh]


def placed(pose: Pose) -> dict[str, Any]:
    """Return a pose as MuJoCo's arguments."""
    return {"pos": pose.position, "quat": scalar_first(pose.orientation)}


def scalar_first(orientation: Quaternion) -> Quaternion:
    """Return a quaternion in MuJoCo's order, w first."""
    x, y, z, w = orientation
    return w, x, y, z
