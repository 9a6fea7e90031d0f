"""The cameras of a scene, drawn by PyBullet's software renderer."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees

import numpy as np

from nrp_core.world.interface import ImageArray
from nrp_core.world.physics.bodies import Body, body_of
from nrp_core.world.physics.mass import rotation_matrix
from nrp_core.world.physics.optics import SKY, CameraPath, Optics, bytes_of, looking
from nrp_core.world.scene.pose import Pose
from nrp_world_pybullet.build import Built, Place
from nrp_world_pybullet.engine import bullet
from nrp_world_pybullet.motion import pose_of


class TinyCameras:
    """Draws the pictures of all cameras."""

    def __init__(self, built: Built, optics: Mapping[CameraPath, Optics], client: int) -> None:
        self._client, self._optics = client, optics
        self._projections = {path: _projection(each) for path, each in optics.items()}
        self._eyes = {path: _eye(built, path) for path in optics}

    def picture(self, path: CameraPath) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, a fresh array."""
        optics = self._optics[path]
        body, place, in_body = self._eyes[path]
        _, _, colors, _, shown = bullet.getCameraImage(
            optics.width,
            optics.height,
            _view(pose_of(body, place, self._client) @ in_body),
            self._projections[path],
            shadow=0,
            lightAmbientCoeff=1,
            lightDiffuseCoeff=0,
            lightSpecularCoeff=0,
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        picture = np.ascontiguousarray(colors[:, :, :3])
        picture[shown < 0] = bytes_of(SKY)
        return picture


def _eye(built: Built, path: CameraPath) -> tuple[Body, Place, Pose]:
    """Return the body that holds a camera, where that is in the engine, and how the camera looks from it."""
    model, link_name, sensor_name = path
    bodies = built.bodies[model]
    body, place = bodies[body_of([each for each, _ in bodies], link_name)]
    link = next(link for link in body.links if link.name == link_name)
    sensor = next(sensor for sensor in link.sensors if sensor.name == sensor_name)
    return body, place, looking(link.pose @ sensor.pose)


def _projection(optics: Optics) -> list[float]:
    aspect = optics.width / optics.height
    matrix = list(
        bullet.computeProjectionMatrixFOV(degrees(optics.vertical_fov), aspect, optics.near, optics.far)
    )
    # TinyRenderer samples a pixel at its corner; half a pixel more, and it does so at the centre
    matrix[8] += 1 / optics.width
    matrix[9] += 1 / optics.height
    return matrix


def _view(eye: Pose) -> list[float]:
    """Return the matrix from the world to a camera, column by column as OpenGL has it."""
    to_camera = eye.inverse()
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(to_camera.orientation)
    matrix[:3, 3] = to_camera.position
    flat: list[float] = matrix.T.ravel().tolist()
    return flat
