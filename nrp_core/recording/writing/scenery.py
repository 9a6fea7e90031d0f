"""The visuals of a scene as Foxglove's scene entities, each in the frame that it moves with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nrp_core.errors import SceneError
from nrp_core.messages.base import Time
from nrp_core.messages.foxglove_msgs import (
    Color,
    CubePrimitive,
    CylinderPrimitive,
    ModelPrimitive,
    SceneEntity,
    SceneEntityDeletion,
    SceneUpdate,
    SpherePrimitive,
)
from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.recording.layout import MESH_TYPE, TEXTURED_TYPE
from nrp_core.recording.writing.frames import Frames
from nrp_core.scene.meshes.gltf import glb
from nrp_core.scene.meshes.stl import read_coordinates, read_stl
from nrp_core.scene.meshes.triangles import mapped_triangles
from nrp_core.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    Rgba,
    Scene,
    Sphere,
    Texture,
)
from nrp_core.scene.rigid import Pose
from nrp_core.world.model_states import pose_message

_PLANE_THICKNESS_M = 0.002


@dataclass(frozen=True, slots=True)
class PlacedVisual:
    """A visual and its place.

    Args:
        frame: the name of the frame that it moves with.
        pose: its pose in that frame.
        geometry: its shape.
        rgba: its colour.
        texture: the image on it; none on a visual that was given another colour.
    """

    frame: str
    pose: Pose
    geometry: Geometry
    rgba: Rgba
    texture: Texture | None = None


def shown_visuals(scene: Scene, frames: Frames, colors: Mapping[str, Rgba]) -> dict[str, PlacedVisual]:
    """Return every visual of a scene by its path, ``model/link/visual``.

    Args:
        scene: the scene.
        frames: the frames of the scene.
        colors: colours of visuals by path, if they differ from those of the scene.
    """
    shown = {}
    for model, link in scene.links():
        frame, place = frames.place(model.name, link.name)
        for visual in link.visuals:
            path = f"{model.name}/{link.name}/{visual.name}"
            rgba = colors.get(path, visual.rgba)
            texture = visual.texture if rgba == visual.rgba else None
            shown[path] = PlacedVisual(frame, place @ visual.pose, visual.geometry, rgba, texture)
    return shown


def scene_update(
    before: Mapping[str, PlacedVisual], now: Mapping[str, PlacedVisual], now_ns: int
) -> SceneUpdate:
    """Return the entities to remove and to add, so that a viewer changes from ``before`` to ``now``."""
    stamp = Time.from_ns(now_ns)
    gone = [SceneEntityDeletion(stamp, id=path) for path in before if path not in now]
    new = [_entity(stamp, path, shown) for path, shown in now.items() if before.get(path) != shown]
    return SceneUpdate(gone, new)


def _entity(stamp: Time, path: str, shown: PlacedVisual) -> SceneEntity:
    entity = SceneEntity(stamp, shown.frame, path, frame_locked=True)
    pose, color = pose_message(shown.pose), Color(*shown.rgba)
    textured = _with_texture(shown, color) if shown.texture else None
    if textured is not None:
        entity.models = [textured]
        return entity
    match shown.geometry:
        case Box(size):
            entity.cubes = [CubePrimitive(pose, Vector3(*size), color)]
        case Sphere(radius):
            entity.spheres = [SpherePrimitive(pose, _ball(radius), color)]
        case Cylinder(radius, length):
            entity.cylinders = [_cylinder(shown.pose, radius, length, color)]
        case Capsule(radius, length):
            entity.cylinders = [_cylinder(shown.pose, radius, length, color)]
            ends = [shown.pose @ Pose((0.0, 0.0, z)) for z in (-length / 2, length / 2)]
            entity.spheres = [SpherePrimitive(pose_message(end), _ball(radius), color) for end in ends]
        case Plane((width, depth)):
            below = pose_message(shown.pose @ Pose((0.0, 0.0, -_PLANE_THICKNESS_M / 2)))
            entity.cubes = [CubePrimitive(below, Vector3(width, depth, _PLANE_THICKNESS_M), color)]
        case Mesh() as mesh:
            entity.models = [_mesh(mesh, shown.pose, color)]
    return entity


def _ball(radius: float) -> Vector3:
    return Vector3(2 * radius, 2 * radius, 2 * radius)


def _cylinder(pose: Pose, radius: float, length: float, color: Color) -> CylinderPrimitive:
    return CylinderPrimitive(pose_message(pose), Vector3(2 * radius, 2 * radius, length), color=color)


def _with_texture(shown: PlacedVisual, color: Color) -> ModelPrimitive | None:
    """Return a shape with its image; None if it has no texture coordinates or its image cannot be read."""
    geometry, texture = shown.geometry, shown.texture
    assert texture is not None
    mapped, scale = mapped_triangles(geometry), (1.0, 1.0, 1.0)
    if isinstance(geometry, Mesh):
        coordinates, scale = read_coordinates(geometry.path), geometry.scale
        mapped = None if coordinates is None else (read_stl(geometry.path), coordinates)
    data = glb(mapped, texture.image, texture.tint) if mapped else None
    if data is None:
        return None
    return ModelPrimitive(
        pose_message(shown.pose),
        Vector3(*scale),
        color,
        media_type=TEXTURED_TYPE,
        data=np.frombuffer(data, np.uint8),
    )


def _mesh(mesh: Mesh, pose: Pose, color: Color) -> ModelPrimitive:
    """Return a mesh with its file, so that other machines can show it."""
    try:
        data = np.fromfile(mesh.path, np.uint8)
    except OSError as error:
        raise SceneError(f"the mesh cannot be read: {error.strerror}", path=mesh.path) from error
    scale = Vector3(*mesh.scale)
    return ModelPrimitive(
        pose_message(pose), scale, color, override_color=True, media_type=MESH_TYPE, data=data
    )
