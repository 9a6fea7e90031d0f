"""The interface of a renderer to a world."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core.errors import CapabilityError
from nrp_core.world.render.optics import CameraPath
from nrp_core.world.render.segments import SegmentArray
from nrp_core.world.scene.model import Light, Rgba

ImageArray = npt.NDArray[np.uint8]
DepthArray = npt.NDArray[np.float32]

RASTER, REALISTIC = SHARED = ("raster", "realistic")
"""The renderers of the core, which every engine has: flat colours, and light with shadows."""


class Cameras(ABC):
    """All cameras of a scene, drawn by one renderer.

    Attributes:
        draws_depth: whether it has :meth:`depth` and :meth:`segments`.
    """

    draws_depth: ClassVar[bool] = False

    @abstractmethod
    def image(self, path: CameraPath) -> ImageArray:
        """Return the image of a camera, shape ``(height, width, 3)``, RGB, a new array."""

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
