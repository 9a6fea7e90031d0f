"""The cameras of a scene, drawn by MuJoCo's own renderers: OpenGL and ray casting."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import tan
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import SKY, CameraPath, Cameras, ImageArray, Optics, bytes_of, flat
from nrp_core.world.rigid import BodyPath, ReadFrames
from nrp_core.world.scene.model import Rgba
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.gl import GlRenderer
from nrp_world_mujoco.library import VISUALS, mujoco
from nrp_world_mujoco.options import HEADLESS_LIBRARIES, headless_library

_SKY = np.array([bytes_of(SKY)], np.uint8)
_STATIC_TOO = 1
_NO_BODY = -1


class RayCamera:
    """One camera of a model.

    Args:
        model: a compiled MuJoCo model.
        data: its state, with positions up to date.
        camera: id of the camera.
        optics: optics of the camera.
        own_geoms: ids of the visuals of the camera's own model. Those that enclose the eye or are nearer than
            the near clip distance are invisible, as in the other renderers.
    """

    def __init__(
        self, model: Any, data: Any, camera: int, optics: Optics, own_geoms: npt.NDArray[np.int64]
    ) -> None:
        self._model, self._data, self._optics = model, data, optics
        self._eye = data.cam_xpos[camera]
        self._axes = data.cam_xmat[camera].reshape(3, 3)
        self._rays = _rays(optics)
        self._depth_of_1_m = -self._rays[:, 2]
        n = len(self._rays)
        self._geoms = np.empty(n, np.int32)
        self._distances = np.empty(n)
        self._groups = np.zeros(mujoco.mjNGROUP, np.uint8)
        self._groups[VISUALS] = 1
        self._hidden = np.empty(0, np.int64)
        self._hide(own_geoms)

    def image(self) -> ImageArray:
        """Return the image, shape ``(height, width, 3)``, RGB; positions must be up to date."""
        self._cast()
        colors = np.concatenate([np.rint(self._model.geom_rgba[:, :3] * 255).astype(np.uint8), _SKY])
        return colors[self._geoms].reshape(self._optics.height, self._optics.width, 3)

    def _cast(self, normals: npt.NDArray[np.float64] | None = None) -> npt.NDArray[np.float64]:
        """Cast all rays, fill geoms and distances and return the directions, shape ``(n, 3)``."""
        directions: npt.NDArray[np.float64] = self._rays @ self._axes.T
        alpha = self._model.geom_rgba[self._hidden, 3]
        self._model.geom_rgba[self._hidden, 3] = 0  # rays pass through transparent geoms
        mujoco.mj_multiRay(
            self._model, self._data, self._eye, directions.ravel(), self._groups, _STATIC_TOO, _NO_BODY,
            self._geoms, self._distances, normals, len(directions), self._optics.far,
        )  # fmt: skip
        self._model.geom_rgba[self._hidden, 3] = alpha
        return directions

    def _hide(self, own_geoms: npt.NDArray[np.int64]) -> None:
        """Repeatedly hide geoms that a ray of this camera hits from inside or too near."""
        normals = np.empty(3 * len(self._rays))
        while True:
            directions = self._cast(normals)
            leaves = np.einsum("ij,ij->i", directions, normals.reshape(-1, 3)) > 0
            near = self._distances * self._depth_of_1_m < self._optics.near
            met = np.unique(self._geoms[(self._geoms >= 0) & (leaves | near)])
            more = np.intersect1d(met, own_geoms)
            if not more.size:
                return
            self._hidden = np.union1d(self._hidden, more)


def _rays(optics: Optics) -> npt.NDArray[np.float64]:
    """Return unit vectors through the pixels' centres, row by row; the camera looks along -z, y is up."""
    focal = optics.height / 2 / tan(optics.vertical_fov / 2)
    across, down = np.meshgrid(
        np.arange(optics.width) + 0.5 - optics.width / 2, np.arange(optics.height) + 0.5 - optics.height / 2
    )
    rays = np.stack([across / focal, -down / focal, -np.ones_like(across)], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return rays


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
        self._renderer = GlRenderer(built.model, headless_library() or HEADLESS_LIBRARIES[0])
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
