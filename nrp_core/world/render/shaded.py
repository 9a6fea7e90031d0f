"""Images in which each face is brighter the more it faces a light, so that shapes are recognisable."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.faces import FaceView
from nrp_core.world.render.optics import Optics
from nrp_core.world.render.scene_mesh import SceneMesh

_LIGHT = np.array([0.45, -0.1, 0.9])  # towards it
_DARKEST = 0.45
_BACKGROUND = (240, 243, 247)
_NEAR_M = 1e-4  # depths are kept as reciprocals, so a short distance costs no precision


class ShadedView:
    """Draws a mesh from any place, smoothly.

    Args:
        mesh: the visuals.
        width, height: the size of the images, pixels.
        vertical_fov: vertical field of view, rad.
        samples: a pixel is the mean of so many by so many.
    """

    def __init__(
        self, mesh: SceneMesh, width: int, height: int, *, vertical_fov: float, samples: int = 3
    ) -> None:
        self._mesh, self._size = mesh, (width, height)
        self._faces = FaceView(mesh)
        self.optics = Optics(width * samples, height * samples, vertical_fov, near=_NEAR_M, far=1e4)
        self._nearness = np.empty((self.optics.height, self.optics.width), np.float32)

    def draw(self, vertices: FloatArray, eye: FloatArray) -> npt.NDArray[np.uint8]:
        """Return an image, RGB, shape ``(height, width, 3)``.

        Args:
            vertices: those of the mesh, in the world, shape ``(n, 3)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        """
        import cv2

        optics = self.optics
        seen = self._faces.draw(vertices, eye, optics.focal, optics.near, optics.far, self._nearness)
        shade = self._shade(vertices)
        large = np.take(self._palette(shade), seen, axis=0)
        textures = self._mesh.textures
        if textures is not None:
            image = np.empty_like(large)
            textures.lay(seen, self._nearness, optics.focal, eye, vertices, self._mesh.faces, image)
            covered = textures.covered(seen)
            large[covered] = (image[covered] * shade[seen[covered]][:, None]).round()
        return cv2.resize(large, self._size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)

    def _shade(self, vertices: FloatArray) -> FloatArray:
        """Return the brightness of each face, more if it faces the light."""
        mesh = self._mesh
        a, b, c = (vertices[mesh.faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        lit = np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), -1, 1)
        shade: FloatArray = _DARKEST + (1 - _DARKEST) * (lit + 1) / 2
        return shade

    def _palette(self, shade: FloatArray) -> npt.NDArray[np.uint8]:
        """Return the colour of each face, and last the background."""
        mesh = self._mesh
        colors = mesh.palette[mesh.surfaces] * shade[:, None]
        return np.vstack([colors.round(), _BACKGROUND]).astype(np.uint8)
