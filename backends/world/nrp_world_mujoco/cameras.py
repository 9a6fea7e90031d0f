"""The cameras of a scene, drawn by MuJoCo's own renderers: OpenGL and ray casting."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import Cameras, ImageArray
from nrp_core.world.render.optics import CameraPath, Optics, flat
from nrp_core.world.rigid.motion import BodyPath, ReadFrames
from nrp_core.world.scene.model import Rgba
from nrp_world_mujoco import headless
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.gl import GlRenderer
from nrp_world_mujoco.rays import RayCamera


def open_cameras(
    renderer: str,
    built: Built,
    data: Any,
    optics: Mapping[CameraPath, Optics],
    refresh: Callable[[], None],
) -> Cameras:
    """Open one of MuJoCo's renderers.

    Args:
        renderer: ``gl`` or ``rays``.
        built: the scene with its visuals.
        data: MuJoCo's state.
        optics: optics of each camera.
        refresh: updates positions in the state before each image.
    """
    refresh()
    return (GlCameras if renderer == "gl" else RayCameras)(built, data, optics, refresh)


def frame_reader(built: Built, data: Any, paths: Sequence[BodyPath]) -> ReadFrames:
    """Return a function that writes the poses of bodies; positions must be up to date."""
    ids = np.array([built.bodies[model][index][1] for model, index in paths], int)

    def read(frames: FloatArray) -> None:
        frames[:, :, :3] = data.xmat[ids].reshape(-1, 3, 3)
        frames[:, :, 3] = data.xpos[ids]

    return read


class _GeomCameras(Cameras):
    """Renderers that draw MuJoCo's geoms."""

    def __init__(self, built: Built, refresh: Callable[[], None]) -> None:
        self._geoms, self._model, self._refresh = built.visuals, built.model, refresh

    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._model.geom_rgba[self._geoms[visual]] = flat(rgba)


class GlCameras(_GeomCameras):
    """Cameras that share one OpenGL context."""

    def __init__(
        self, built: Built, data: Any, optics: Mapping[CameraPath, Optics], refresh: Callable[[], None]
    ) -> None:
        super().__init__(built, refresh)
        self._renderer = GlRenderer(built.model, headless.library() or headless.LIBRARIES[0])
        self._data, self._cameras, self._optics = data, built.cameras, optics

    def image(self, path: CameraPath) -> ImageArray:
        self._refresh()
        return self._renderer.image(self._data, self._cameras[path], self._optics[path])

    def close(self) -> None:
        self._renderer.close()


class RayCameras(_GeomCameras):
    """Cameras by ray casting, each with its own rays."""

    def __init__(
        self, built: Built, data: Any, optics: Mapping[CameraPath, Optics], refresh: Callable[[], None]
    ) -> None:
        super().__init__(built, refresh)
        self._cameras = {
            path: RayCamera(built.model, data, ident, optics[path], _visuals_of(built, path[0]))
            for path, ident in built.cameras.items()
        }

    def image(self, path: CameraPath) -> ImageArray:
        self._refresh()
        return self._cameras[path].image()


def _visuals_of(built: Built, model: str) -> Any:
    return np.array([geom for path, geom in built.visuals.items() if path.startswith(f"{model}/")], int)
