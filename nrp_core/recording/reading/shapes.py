"""The shapes of a recorded scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import type_name
from nrp_core.messages.foxglove_msgs import ModelPrimitive, SceneEntity
from nrp_core.recording.layout import TEXTURED_TYPE
from nrp_core.scene.meshes.gltf import contents_of
from nrp_core.scene.meshes.stl import stl_bytes
from nrp_core.scene.meshes.triangles import Coordinates
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world.model_states import pose_of, vector_of


class ShapeKind(Enum):
    """The kinds of shapes in a recorded scene."""

    BOX = "box"
    ELLIPSOID = "ellipsoid"
    CYLINDER = "cylinder"
    MESH = "mesh"


_MARKER_KINDS = {2: ShapeKind.ELLIPSOID, 3: ShapeKind.CYLINDER, 10: ShapeKind.MESH}
"""The kinds by the ``type`` of a ``visualization_msgs/Marker``; others are boxes."""


@dataclass(frozen=True, slots=True, eq=False)
class ShapeImage:
    """An image on a mesh.

    Args:
        data: the file of the image.
        tint: the red, green and blue by which it is multiplied.
        coordinates: texture coordinates of the triangles of the mesh.
    """

    data: bytes
    tint: Vector
    coordinates: Coordinates


@dataclass(frozen=True, slots=True, eq=False)
class RecordedShape:
    """A shape in a frame.

    Args:
        visual: path of its visual, ``model/link/visual``; a visual may have several shapes.
        frame: name of the frame that it moves with.
        kind: the kind of shape.
        pose: its pose in the frame.
        size: extents along its axes, m; of a mesh, the factors of its coordinates.
        rgba: its colour, each component 0..1.
        mesh: the STL file of a mesh, if the recording contains it.
        image: the image on it.
    """

    visual: str
    frame: str
    kind: ShapeKind
    pose: Pose
    size: Vector
    rgba: tuple[float, float, float, float]
    mesh: npt.NDArray[np.uint8] | None = None
    image: ShapeImage | None = None

    @property
    def model(self) -> str:
        """Its model."""
        return self.visual.partition("/")[0]


class RecordedScene:
    """The shapes of a scene after the messages on ``/scene``.

    Recordings of version 0.1 have markers, repeated completely at each change, and no meshes.
    """

    def __init__(self) -> None:
        self._shapes: dict[str, list[RecordedShape]] = {}

    @property
    def shapes(self) -> list[RecordedShape]:
        """All shapes."""
        return [shape for shapes in self._shapes.values() for shape in shapes]

    def take(self, message: Any) -> list[str]:
        """Apply a ``SceneUpdate`` or a ``MarkerArray``; return the visuals that are new or changed."""
        if type_name(type(message)) == "visualization_msgs/msg/MarkerArray":
            self._shapes = {marker.ns: [_marker_shape(marker)] for marker in message.markers}
            return list(self._shapes)
        for deletion in message.deletions:
            self._shapes.pop(deletion.id, None)
        for entity in message.entities:
            self._shapes[entity.id] = list(_entity_shapes(entity))
        return [entity.id for entity in message.entities]


def _entity_shapes(entity: SceneEntity) -> Iterator[RecordedShape]:
    for kind, primitives in (
        (ShapeKind.BOX, entity.cubes),
        (ShapeKind.ELLIPSOID, entity.spheres),
        (ShapeKind.CYLINDER, entity.cylinders),
    ):
        for each in primitives:
            size, color = vector_of(each.size), _rgba(each.color)
            yield RecordedShape(entity.id, entity.frame_id, kind, pose_of(each.pose), size, color)
    for model in entity.models:
        scale, color = vector_of(model.scale), _rgba(model.color)
        pose = pose_of(model.pose)
        yield RecordedShape(entity.id, entity.frame_id, ShapeKind.MESH, pose, scale, color, *_mesh(model))


def _mesh(model: ModelPrimitive) -> tuple[npt.NDArray[np.uint8], ShapeImage | None]:
    """Return the file of a mesh as STL, and the image on it."""
    if model.media_type != TEXTURED_TYPE:
        return model.data, None
    (triangles, coordinates), data, tint = contents_of(model.data.tobytes())
    return np.frombuffer(stl_bytes(triangles), np.uint8), ShapeImage(data, tint, coordinates)


def _marker_shape(marker: Any) -> RecordedShape:
    kind, size = _MARKER_KINDS.get(marker.type, ShapeKind.BOX), vector_of(marker.scale)
    return RecordedShape(
        marker.ns, marker.header.frame_id, kind, pose_of(marker.pose), size, _rgba(marker.color)
    )


def _rgba(color: Any) -> tuple[float, float, float, float]:
    return float(color.r), float(color.g), float(color.b), float(color.a)
