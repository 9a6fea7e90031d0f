"""Images by casting one ray for each pixel, without a graphics library."""

from __future__ import annotations

from math import tan
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.render.optics import SKY, Optics, bytes_of
from nrp_world_mujoco.library import VISUALS, mujoco

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
