"""The cameras of a scene, drawn by PyBullet's renderer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import (
    SKY,
    CameraPath,
    Cameras,
    ImageArray,
    Optics,
    bytes_of,
    camera_pose,
    flat,
)
from nrp_core.world.rigid import BodyPath, Pose, ReadFrames, matrix_of
from nrp_core.world.scene.model import Rgba
from nrp_world_pybullet.build import Built
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import PlaceOf, place_of


def frame_reader(built: Built, client: int, paths: Sequence[BodyPath]) -> ReadFrames:
    """Return a function that writes the poses of bodies."""
    places = [place_of(*built.bodies[model][index], Pose(), client) for model, index in paths]

    def read(frames: FloatArray) -> None:
        for frame, place in zip(frames, places, strict=True):
            position, orientation = place()
            frame[:, :3] = np.reshape(bullet.getMatrixFromQuaternion(orientation), (3, 3))
            frame[:, 3] = position

    return read


class TinyCameras(Cameras):
    """PyBullet's software renderer."""

    def __init__(self, built: Built, client: int, optics: Mapping[CameraPath, Optics]) -> None:
        self._client, self._optics, self._visuals = client, optics, built.visuals
        self._projections = {path: _projection(each) for path, each in optics.items()}
        self._eyes = {path: self._eye(built, path, client) for path in optics}

    def image(self, path: CameraPath) -> ImageArray:
        optics = self._optics[path]
        _, _, colors, _, shown = bullet.getCameraImage(
            optics.width,
            optics.height,
            _view(Pose(*self._eyes[path]())),
            self._projections[path],
            shadow=0,
            lightAmbientCoeff=1,
            lightDiffuseCoeff=0,
            lightSpecularCoeff=0,
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        image = np.ascontiguousarray(colors[:, :, :3])
        image[shown < 0] = bytes_of(SKY)
        return image

    def set_color(self, visual: str, rgba: Rgba) -> None:
        place, shape = self._visuals[visual]
        where = (place.multibody, place.link, shape)
        bullet.changeVisualShape(*where, rgbaColor=flat(rgba), physicsClientId=self._client)

    @staticmethod
    def _eye(built: Built, path: CameraPath, client: int) -> PlaceOf:
        """Return the reader of the pose of a camera."""
        bodies = built.bodies[path[0]]
        index, eye = camera_pose([body for body, _ in bodies], path)
        return place_of(*bodies[index], eye, client)


def _projection(optics: Optics) -> list[float]:
    aspect = optics.width / optics.height
    fov = degrees(optics.vertical_fov)
    matrix = list(bullet.computeProjectionMatrixFOV(fov, aspect, optics.near, optics.far))
    # TinyRenderer samples a pixel at its corner; an offset of half a pixel moves this to the centre
    matrix[8] += 1 / optics.width
    matrix[9] += 1 / optics.height
    return matrix


def _view(eye: Pose) -> list[float]:
    """Return the matrix from the world to a camera in OpenGL's column order."""
    matrix = np.vstack([matrix_of(eye.inverse()), (0.0, 0.0, 0.0, 1.0)])
    columns: list[float] = matrix.T.ravel().tolist()
    return columns
