"""Package foxglove_msgs: scenes as Foxglove and Lichtblick draw them; SI units.

Fields as in Foxglove's schemas, https://docs.foxglove.dev/docs/sdk/schemas.
"""

from __future__ import annotations

from dataclasses import field
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import Duration, Time, array_field, message
from nrp_core.messages.geometry_msgs import Point, Pose, Vector3


@message("foxglove_msgs/msg/Color")
class Color:
    """A colour, each component 0..1."""

    r: float = 0.0
    g: float = 0.0
    b: float = 0.0
    a: float = 0.0


@message("foxglove_msgs/msg/KeyValuePair")
class KeyValuePair:
    """An entry of the metadata of an entity."""

    key: str = ""
    value: str = ""


@message("foxglove_msgs/msg/ArrowPrimitive")
class ArrowPrimitive:
    """An arrow along x."""

    pose: Pose = field(default_factory=Pose)
    shaft_length: float = 0.0
    shaft_diameter: float = 0.0
    head_length: float = 0.0
    head_diameter: float = 0.0
    color: Color = field(default_factory=Color)


@message("foxglove_msgs/msg/CubePrimitive")
class CubePrimitive:
    """A box; ``pose`` is at its centre."""

    pose: Pose = field(default_factory=Pose)
    size: Vector3 = field(default_factory=Vector3)
    color: Color = field(default_factory=Color)


@message("foxglove_msgs/msg/SpherePrimitive")
class SpherePrimitive:
    """An ellipsoid; ``size`` has its diameters."""

    pose: Pose = field(default_factory=Pose)
    size: Vector3 = field(default_factory=Vector3)
    color: Color = field(default_factory=Color)


@message("foxglove_msgs/msg/CylinderPrimitive")
class CylinderPrimitive:
    """A cylinder or cone along z; the scales are those of its two ends."""

    pose: Pose = field(default_factory=Pose)
    size: Vector3 = field(default_factory=Vector3)
    bottom_scale: float = 1.0
    top_scale: float = 1.0
    color: Color = field(default_factory=Color)


_LINE = """\
uint8 LINE_STRIP=0
uint8 LINE_LOOP=1
uint8 LINE_LIST=2
uint8 type
geometry_msgs/Pose pose
float64 thickness
bool scale_invariant
geometry_msgs/Point[] points
foxglove_msgs/Color color
foxglove_msgs/Color[] colors
uint32[] indices"""


@message("foxglove_msgs/msg/LinePrimitive", _LINE)
class LinePrimitive:
    """A series of points connected by lines."""

    LINE_STRIP: ClassVar[int] = 0
    LINE_LOOP: ClassVar[int] = 1
    LINE_LIST: ClassVar[int] = 2

    type: int = 0
    pose: Pose = field(default_factory=Pose)
    thickness: float = 0.0
    scale_invariant: bool = False
    points: list[Point] = field(default_factory=list)
    color: Color = field(default_factory=Color)
    colors: list[Color] = field(default_factory=list)
    indices: npt.NDArray[np.uint32] = array_field(np.uint32)


@message("foxglove_msgs/msg/TriangleListPrimitive")
class TriangleListPrimitive:
    """Triangles; each three points, or indices of points, are one."""

    pose: Pose = field(default_factory=Pose)
    points: list[Point] = field(default_factory=list)
    color: Color = field(default_factory=Color)
    colors: list[Color] = field(default_factory=list)
    indices: npt.NDArray[np.uint32] = array_field(np.uint32)


@message("foxglove_msgs/msg/TextPrimitive")
class TextPrimitive:
    """A text label."""

    pose: Pose = field(default_factory=Pose)
    billboard: bool = False
    font_size: float = 0.0
    scale_invariant: bool = False
    color: Color = field(default_factory=Color)
    text: str = ""


@message("foxglove_msgs/msg/ModelPrimitive")
class ModelPrimitive:
    """A mesh, by its address or with its file in ``data``; ``media_type`` is that of the file."""

    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: Color = field(default_factory=Color)
    override_color: bool = False
    url: str = ""
    media_type: str = ""
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


_DELETION = "uint8 MATCHING_ID=0\nuint8 ALL=1\nbuiltin_interfaces/Time timestamp\nuint8 type\nstring id"


@message("foxglove_msgs/msg/SceneEntityDeletion", _DELETION)
class SceneEntityDeletion:
    """Removes entities that are not newer than ``timestamp``: one, or all."""

    MATCHING_ID: ClassVar[int] = 0
    ALL: ClassVar[int] = 1

    timestamp: Time = field(default_factory=Time)
    type: int = 0
    id: str = ""


@message("foxglove_msgs/msg/SceneEntity")
class SceneEntity:
    """Shapes that belong together, in one frame; replaces the entity of the same ``id``.

    ``frame_locked`` entities move with their frame. With a ``lifetime`` of 0 they stay.
    """

    timestamp: Time = field(default_factory=Time)
    frame_id: str = ""
    id: str = ""
    lifetime: Duration = field(default_factory=Duration)
    frame_locked: bool = False
    metadata: list[KeyValuePair] = field(default_factory=list)
    arrows: list[ArrowPrimitive] = field(default_factory=list)
    cubes: list[CubePrimitive] = field(default_factory=list)
    spheres: list[SpherePrimitive] = field(default_factory=list)
    cylinders: list[CylinderPrimitive] = field(default_factory=list)
    lines: list[LinePrimitive] = field(default_factory=list)
    triangles: list[TriangleListPrimitive] = field(default_factory=list)
    texts: list[TextPrimitive] = field(default_factory=list)
    models: list[ModelPrimitive] = field(default_factory=list)


@message("foxglove_msgs/msg/SceneUpdate")
class SceneUpdate:
    """Entities to remove, and then entities to add or replace."""

    deletions: list[SceneEntityDeletion] = field(default_factory=list)
    entities: list[SceneEntity] = field(default_factory=list)
