"""What a renderer is to a world."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core.errors import CapabilityError
from nrp_core.world.render.optics import CameraPath
from nrp_core.world.scene.model import Light, Rgba

ImageArray = npt.NDArray[np.uint8]
DepthArray = npt.NDArray[np.float32]

RASTER, REALISTIC = SHARED = ("raster", "realistic")
"""The renderers of the core, which every engine has: flat colours, and light with shadows."""


class Cameras(ABC):
    """All cameras of a scene, drawn by one renderer.

    Attributes:
        draws_depth: whether it has :meth:`depth`.
    """

    draws_depth: ClassVar[bool] = False

    @abstractmethod
    def picture(self, path: CameraPath) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, a fresh array."""

    def depth(self, path: CameraPath) -> DepthArray:
        """Return how far along its line of sight a camera sees, m, ``inf`` where it sees nothing."""
        raise CapabilityError("this renderer does not draw depth images; use 'raster'")

    @abstractmethod
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual, named by its path, from the next picture on."""

    def set_glow(self, visual: str, glows: bool) -> None:
        """Let a visual have its colour in any light, or not; flat colours do not show it."""

    def set_lights(self, lights: Sequence[Light]) -> None:
        """Let these be the lights, from the next picture on; flat colours do not show them."""

    def close(self) -> None:
        """Release what the renderer holds."""
