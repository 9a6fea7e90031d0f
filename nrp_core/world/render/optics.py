"""The definition of an image, the same for every renderer.

Images are flat: a visual shows exactly its colour, whatever the light, in front of the sky. A visual is seen
from outside only (not by a camera inside it); it is opaque or, with alpha 0, invisible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import atan, tan

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import Body, body_of
from nrp_core.world.scene.model import Box, Geometry, Plane, Rgba, Scene
from nrp_core.world.scene.sensing import View

SKY: Rgba = (178 / 255, 178 / 255, 178 / 255, 1.0)
"""Colour of the background: SDF's default grey."""

CameraPath = tuple[str, str, str]
"""Names of a camera's model, link and view, which is named after its sensor."""


@dataclass(frozen=True, slots=True)
class Optics:
    """The optics of a camera for a renderer.

    Args:
        width, height: size of the image, pixels.
        vertical_fov: vertical field of view, rad.
        near, far: clip distances along the line of sight, m.

    Attributes:
        focal: focal length, in pixels.
    """

    width: int
    height: int
    vertical_fov: float
    near: float
    far: float
    focal: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "focal", self.height / 2 / tan(self.vertical_fov / 2))

    @classmethod
    def of(cls, view: View, scale: float) -> Optics:
        """Return the optics of a view at a lower resolution, with square pixels and the same width of field.

        Args:
            view: the view in the robot's file.
            scale: factor of width and height, at most 1.
        """
        width = max(1, round(view.width * scale))
        height = max(1, round(view.height * scale))
        vertical_fov = 2 * atan(tan(view.horizontal_fov / 2) * height / width)
        return cls(width, height, vertical_fov, view.near, view.far)


def optics_of(scene: Scene, scale: float) -> Mapping[CameraPath, Optics]:
    """Return the optics of every camera of a scene."""
    return {
        (model.name, link.name, name): Optics.of(view, scale)
        for model, link in scene.links()
        for sensor in link.sensors
        for name, view in sensor.views.items()
    }


def eye_of(bodies: Sequence[Body], path: CameraPath) -> tuple[int, Pose]:
    """Return the index of the body that holds a camera, and the pose of the camera's graphics frame in it."""
    _, link_name, view_name = path
    index = body_of(bodies, link_name)
    link = next(link for link in bodies[index].links if link.name == link_name)
    view = next(sensor.views[view_name] for sensor in link.sensors if view_name in sensor.views)
    return index, looking(link.pose @ view.pose)


def looking(pose: Pose) -> Pose:
    """Turn a camera's pose (looks along x, z up) to that of graphics (looks along -z, y up)."""
    return pose @ Pose(orientation=(0.5, -0.5, -0.5, 0.5))


def flat(rgba: Rgba) -> Rgba:
    """Return a colour of 8 bits a channel, which every renderer rounds to the same bytes; alpha is 0 or 1."""
    red, green, blue = (round(255 * min(1.0, max(0.0, channel))) / 255 for channel in rgba[:3])
    return red, green, blue, 1.0 if rgba[3] > 0 else 0.0


def bytes_of(rgba: Rgba) -> tuple[int, int, int]:
    """Return red, green and blue of a flat colour as in images, 0..255."""
    red, green, blue = (round(255 * channel) for channel in rgba[:3])
    return red, green, blue


def drawn(geometry: Geometry, pose: Pose) -> tuple[Geometry, Pose]:
    """Return the geometry to draw for a visual: for a plane, a thin plate with its top in the plane."""
    if not isinstance(geometry, Plane):
        return geometry, pose
    thickness = 0.002
    return Box((*geometry.size, thickness)), pose @ Pose((0.0, 0.0, -thickness / 2))
