"""A scene as markers, which ROS viewers draw and the figure reads."""

from __future__ import annotations

from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.world.messages.geometry_msgs import Vector3
from nrp_core.world.messages.std_msgs import ColorRGBA, Header
from nrp_core.world.messages.visualization_msgs import (
    CUBE,
    CYLINDER,
    MESH_RESOURCE,
    SPHERE,
    Marker,
    MarkerArray,
)
from nrp_core.world.pose_messages import pose_message
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Link,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
    Visual,
)

_PLANE_THICKNESS = 0.001


def markers(scene: Scene) -> MarkerArray:
    """Return every visual of a scene: in the world's frame if its model is static, else in the model's."""
    return MarkerArray([
        _marker(number, model, link, visual)
        for number, (model, link, visual) in enumerate(
            (model, link, visual) for model, link in scene.links() for visual in link.visuals
        )
    ])  # fmt: skip


def _marker(number: int, model: Model, link: Link, visual: Visual) -> Marker:
    pose = link.pose @ visual.pose
    if model.static:
        pose = model.pose @ pose
    kind, scale = _shape(visual.geometry)
    return Marker(
        header=Header(frame_id=WORLD_FRAME if model.static else model.name),
        ns=f"{model.name}/{link.name}/{visual.name}",
        id=number,
        type=kind,
        pose=pose_message(pose),
        scale=Vector3(*scale),
        color=ColorRGBA(*visual.rgba),
        frame_locked=not model.static,
        mesh_resource=visual.geometry.path.as_uri() if isinstance(visual.geometry, Mesh) else "",
    )


def _shape(geometry: Geometry) -> tuple[int, Vector]:
    """Return the type of marker and its extents in m; a capsule is shown as a cylinder of its length."""
    match geometry:
        case Box(size):
            return CUBE, size
        case Sphere(radius):
            return SPHERE, (2 * radius, 2 * radius, 2 * radius)
        case Cylinder(radius, length):
            return CYLINDER, (2 * radius, 2 * radius, length)
        case Capsule(radius, length):
            return CYLINDER, (2 * radius, 2 * radius, length + 2 * radius)
        case Plane(size):
            return CUBE, (*size, _PLANE_THICKNESS)
        case Mesh(scale=scale):
            return MESH_RESOURCE, scale
