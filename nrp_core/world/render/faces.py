"""Find the triangle visible at each pixel, from any place in the world."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.pixels import NearnessArray, draw
from nrp_core.world.render.scene_mesh import SceneMesh
from nrp_core.world.scene.merged_bodies import WORLD_FRAME

_WORLD = np.eye(3, 4)[np.newaxis]


class FaceView:
    """Draws the triangles of a mesh, each as a separate surface.

    Args:
        mesh: the visuals.
    """

    def __init__(self, mesh: SceneMesh) -> None:
        self._mesh = mesh
        self._numbers = np.arange(len(mesh.faces), dtype=np.int32)
        self._frames = np.full(len(mesh.vertices), WORLD_FRAME, np.int32)
        self._seen: dict[tuple[int, ...], npt.NDArray[np.int32]] = {}

    def draw(
        self,
        points: FloatArray,
        eye: FloatArray,
        focal: float,
        near: float,
        far: float,
        nearness: NearnessArray,
    ) -> npt.NDArray[np.int32]:
        """Return the number of the face at each pixel, -1 for none; valid until the next call.

        Args:
            points: the vertices in the world, shape ``(n, 3)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            focal: focal length, in pixels.
            near: distance in front of which nothing is seen.
            far: distance beyond which nothing is seen.
            nearness: filled with the reciprocals of the depths; its shape is the image's.
        """
        mesh = self._mesh
        if nearness.shape not in self._seen:
            self._seen[nearness.shape] = np.empty(nearness.shape, np.int32)
        seen = self._seen[nearness.shape]
        scene = (points, self._frames, mesh.faces, self._numbers, mesh.shown[mesh.surfaces], _WORLD)
        draw(*scene, WORLD_FRAME, eye, focal, near, far, nearness, seen)
        return seen
