"""The interface of a renderer to a world: optics, images, depth and segments."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import atan, tan
from typing import ClassVar, Protocol

import numpy as np
import numpy.typing as npt

from nrp_core.errors import CapabilityError
from nrp_core.scene.devices import ANY_CAMERA, View
from nrp_core.scene.merged_bodies import Body, body_of
from nrp_core.scene.model import Box, Geometry, Light, Plane, Rgba, Scene
from nrp_core.scene.rigid import Pose

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
        mask: bits; visuals are drawn whose flags share one.

    Attributes:
        focal: focal length, in pixels.
    """

    width: int
    height: int
    vertical_fov: float
    near: float
    far: float
    mask: int = ANY_CAMERA
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
        return cls(width, height, vertical_fov, view.near, view.far, view.mask)


def optics_of(scene: Scene, scale: float) -> Mapping[CameraPath, Optics]:
    """Return the optics of every camera of a scene."""
    return {
        (model.name, link.name, name): Optics.of(view, scale)
        for model, link in scene.links()
        for sensor in link.sensors
        for name, view in sensor.views.items()
    }


def camera_pose(bodies: Sequence[Body], path: CameraPath) -> tuple[int, Pose]:
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


SegmentArray = npt.NDArray[np.uint16]
"""Labels and numbers of instances, shape ``(height, width, 2)``; 0 and 0 where nothing has a label."""


def segments_of(bodies: Mapping[str, Sequence[Body]]) -> SegmentArray:
    """Return label and instance of every visual in the order of a scene's mesh, and last of the background.

    The models with visuals of a label are its instances, numbered from 1 in the order of the scene.
    """
    rows = []
    seen: dict[int, list[str]] = {}
    for model, parts in bodies.items():
        for visual in (each for body in parts for link in body.links for each in link.visuals):
            models = seen.setdefault(visual.label, [])
            if model not in models:
                models.append(model)
            rows.append((visual.label, len(models) if visual.label else 0))
    return np.array([*rows, (0, 0)], np.uint16)


ImageArray = npt.NDArray[np.uint8]
DepthArray = npt.NDArray[np.float32]

RASTER, REALISTIC = SHARED = ("raster", "realistic")
"""The renderers of the core, which every engine has: flat colours, and light with shadows."""


class Sight(Protocol):
    """What a camera sees at a given time; its image is drawn on request."""

    @property
    def palette(self) -> npt.NDArray[np.uint8]:
        """All colours in the image, that of the sky last, shape ``(n, 3)``."""

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the image, pixels."""

    def image(self) -> ImageArray:
        """Return the image, shape ``(height, width, 3)``, RGB, read-only."""

    def count(self, chosen: npt.NDArray[np.bool_]) -> tuple[int, int]:
        """Return the number of pixels in the left and in the right half with certain colours of the palette.

        Args:
            chosen: for each colour except that of the sky, whether it is counted.
        """


class Cameras(ABC):
    """All cameras of a scene, drawn by one renderer.

    Attributes:
        draws_depth: whether it has :meth:`depth` and :meth:`segments`.
    """

    draws_depth: ClassVar[bool] = False

    @abstractmethod
    def image(self, path: CameraPath) -> ImageArray:
        """Return the image of a camera, shape ``(height, width, 3)``, RGB, a new array."""

    def look(self, path: CameraPath) -> Sight | None:
        """Return what a camera sees now, if its image can be drawn later."""
        return None

    def depth(self, path: CameraPath) -> DepthArray:
        """Return the depth along a camera's line of sight, m, ``inf`` where it sees nothing."""
        raise CapabilityError("this renderer does not draw depth images; use 'raster'")

    def segments(self, path: CameraPath) -> SegmentArray:
        """Return label and instance of the visual at each pixel of a camera, a new array."""
        raise CapabilityError("this renderer does not draw segments; use 'raster'")

    @abstractmethod
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Set the colour of a visual, named by its path, from the next image on."""

    def set_glow(self, visual: str, glows: bool) -> None:
        """Set whether a visual glows (has its colour in any light); flat colours do not show it."""

    def set_lights(self, lights: Sequence[Light]) -> None:
        """Set the lights, from the next image on; flat colours do not show them."""

    def close(self) -> None:
        """Release the renderer."""
