"""Images of a scene from any place, with light and shadows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import CameraPath, Optics
from nrp_core.world.render.realistic import RealisticCameras
from nrp_core.world.rigid import BodyPath, ReadFrames
from nrp_core.world.scene.merged_bodies import WORLD_FRAME, Body
from nrp_core.world.scene.model import Light

_VIEW: Final[CameraPath] = ("", "", "")
_NEAR_M = 1e-3


class LitView(RealisticCameras):
    """Draws bodies from any place, as realistic cameras do.

    Args:
        bodies: the bodies of each model.
        lights: the lights.
        width, height: the size of the images, pixels.
        vertical_fov: vertical field of view, rad.
        samples: a pixel is the mean of so many by so many.
    """

    def __init__(
        self,
        bodies: Mapping[str, Sequence[Body]],
        lights: Sequence[Light],
        width: int,
        height: int,
        *,
        vertical_fov: float,
        samples: int = 2,
    ) -> None:
        self._size = width, height
        self._placed = np.empty((0, 3, 4))
        optics = Optics(width * samples, height * samples, vertical_fov, near=_NEAR_M, far=1e4)
        super().__init__(bodies, {}, self._reader, lights)
        self._optics = {_VIEW: optics}

    def draw(self, frames: FloatArray, eye: FloatArray) -> npt.NDArray[np.uint8]:
        """Return an image, RGB, shape ``(height, width, 3)``.

        Args:
            frames: rotation and translation of the bodies that move, shape ``(n, 3, 4)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        """
        import cv2

        self._placed = frames
        self._eyes[_VIEW] = WORLD_FRAME, eye
        image = cv2.resize(self.image(_VIEW), self._size, interpolation=cv2.INTER_AREA)
        return image.astype(np.uint8, copy=False)

    def _reader(self, paths: Sequence[BodyPath]) -> ReadFrames:
        def read(rows: FloatArray) -> None:
            rows[:] = self._placed

        return read
