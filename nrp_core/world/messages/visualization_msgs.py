"""ROS package visualization_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

from nrp_core.world.messages.base import Duration, message
from nrp_core.world.messages.geometry_msgs import Point, Pose, Vector3
from nrp_core.world.messages.sensor_msgs import CompressedImage
from nrp_core.world.messages.std_msgs import ColorRGBA, Header


@message("visualization_msgs/msg/UVCoordinate")
class UVCoordinate:
    """Coordinates in a texture, each 0..1."""

    u: float = 0.0
    v: float = 0.0


@message("visualization_msgs/msg/MeshFile")
class MeshFile:
    """A mesh file in a message."""

    filename: str = ""
    data: bytes = b""


@message("visualization_msgs/msg/Marker")
class Marker:
    """An object to draw: ``type`` is its shape, ``scale`` its full extents in m."""

    header: Header = field(default_factory=Header)
    ns: str = ""
    id: int = 0
    type: int = 0
    action: int = 0
    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: ColorRGBA = field(default_factory=ColorRGBA)
    lifetime: Duration = field(default_factory=Duration)
    frame_locked: bool = False
    points: list[Point] = field(default_factory=list)
    colors: list[ColorRGBA] = field(default_factory=list)
    texture_resource: str = ""
    texture: CompressedImage = field(default_factory=CompressedImage)
    uv_coordinates: list[UVCoordinate] = field(default_factory=list)
    text: str = ""
    mesh_resource: str = ""
    mesh_file: MeshFile = field(default_factory=MeshFile)
    mesh_use_embedded_materials: bool = False


CUBE, SPHERE, CYLINDER, MESH_RESOURCE = 1, 2, 3, 10
"""Values of ``Marker.type`` that the platform uses."""


@message("visualization_msgs/msg/MarkerArray")
class MarkerArray:
    """Several markers."""

    markers: list[Marker] = field(default_factory=list)
