"""The cameras of a scene, drawn by OpenGL or by rays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core.world.interface import ImageArray
from nrp_core.world.physics.optics import CameraPath, Optics
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.gl import GlRenderer
from nrp_world_mujoco.rays import RayCamera


class Cameras(ABC):
    """Draws the pictures of all cameras; positions must be up to date."""

    @abstractmethod
    def picture(self, path: CameraPath) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, a fresh array."""

    def close(self) -> None:
        """Release what the renderer holds."""


class GlCameras(Cameras):
    """All cameras share one OpenGL context."""

    def __init__(self, built: Built, data: Any, optics: Mapping[CameraPath, Optics], library: str) -> None:
        self._renderer = GlRenderer(built.model, library)
        self._data, self._cameras, self._optics = data, built.cameras, optics

    def picture(self, path: CameraPath) -> ImageArray:
        return self._renderer.picture(self._data, self._cameras[path], self._optics[path])

    def close(self) -> None:
        self._renderer.close()


class RayCameras(Cameras):
    """Each camera has its own rays."""

    def __init__(self, built: Built, data: Any, optics: Mapping[CameraPath, Optics]) -> None:
        self._cameras = {
            path: RayCamera(built.model, data, ident, optics[path], _visuals_of(built, path[0]))
            for path, ident in built.cameras.items()
        }

    def picture(self, path: CameraPath) -> ImageArray:
        return self._cameras[path].picture()


def _visuals_of(built: Built, model: str) -> Any:
    return np.array([geom for path, geom in built.visuals.items() if path.startswith(f"{model}/")])
