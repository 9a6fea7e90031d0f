"""A picture of a scene from outside, shaded so that its shapes can be told, drawn without any engine."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.faces import FaceView
from nrp_core.world.render.optics import Optics, looking
from nrp_core.world.render.pixels import NOTHING
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.rigid.matrices import matrix_of
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Scene

FIELD_OF_VIEW = radians(40)

_SAMPLES = 3  # a pixel is the mean of so many squared
_FROM_ROBOT, _FROM_ROOM = (radians(35), radians(25)), (radians(60), radians(62))  # yaw and height of the eye
_FILLED = 0.9  # of the picture, at most
_CLEARANCE = 0.02  # of the extent of what is drawn, kept from the eye
_LIGHT = np.array([0.45, -0.1, 0.9])  # towards it
_DARKEST = 0.45
_BACKGROUND = (240, 243, 247)


@dataclass(frozen=True)
class _Subject:
    """What is drawn, in the world.

    Args:
        mesh: the visuals.
        vertices: all of them, in the world.
        framed: which vertices the picture must show.
    """

    mesh: SceneMesh
    vertices: FloatArray
    framed: npt.NDArray[np.bool_]


def portrait(scene: Scene, width: int = 960, height: int = 720) -> npt.NDArray[np.uint8]:
    """Return a picture of a scene, all joints at 0; RGB, shape ``(height, width, 3)``.

    Raises:
        SceneError: the scene cannot be drawn; a mesh of it cannot be read, for example.
    """
    import cv2

    subject = _subject(scene)
    optics = Optics(width * _SAMPLES, height * _SAMPLES, FIELD_OF_VIEW, near=0.01, far=1e4)
    seen = np.full((optics.height, optics.width), NOTHING, np.int32)
    if len(subject.mesh.faces):
        eye = _eye(subject, optics, any(not model.static for model in scene.models))
        lens = (optics.focal, optics.near, optics.far)
        seen = FaceView(subject.mesh).draw(subject.vertices, eye, *lens, np.empty(seen.shape, np.float32))
    large = np.take(_palette(subject), seen, axis=0)
    return cv2.resize(large, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)


def _subject(scene: Scene) -> _Subject:
    bodies = {model.name: bodies_of(model) for model in scene.models}
    numbers = frames_of(bodies)
    mesh = SceneMesh(bodies, numbers)
    frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))
    for (name, index), number in numbers.items():
        frames[number] = matrix_of(scene.model(name).pose @ bodies[name][index].in_model)
    held = frames[mesh.vertex_frames]
    vertices = np.einsum("nij,nj->ni", held[:, :, :3], mesh.vertices) + held[:, :, 3]
    return _Subject(mesh, vertices, mesh.framed(vertices))


def _eye(subject: _Subject, optics: Optics, is_robot: bool) -> FloatArray:
    """Return where the camera is: outside, above, and as near as shows everything."""
    yaw, up = _FROM_ROBOT if is_robot else _FROM_ROOM
    turn = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, up, yaw + np.pi)
    axes = matrix_of(turn)[:, :3]
    points = subject.vertices[subject.framed] @ axes  # ahead, left, up
    high = _FILLED * tan(optics.vertical_fov / 2)
    wide = high * optics.width / optics.height
    eye = np.append(-points.max(), (points.min(axis=0) + points.max(axis=0))[1:] / 2)
    for _ in range(4):  # what is nearer is larger: the middle of the picture is found in a few steps
        ahead, left, up = (points - eye).T
        room = max((np.abs(left) / wide - ahead).max(), (np.abs(up) / high - ahead).max())
        eye[0] -= room + _CLEARANCE * np.ptp(points, axis=0).max()
        ahead, left, up = (points - eye).T
        for axis, seen in ((1, left / ahead), (2, up / ahead)):
            eye[axis] += (seen.min() + seen.max()) / 2 * ahead.mean()
    x, y, z = axes @ eye
    return matrix_of(looking(Pose((float(x), float(y), float(z)), turn.orientation)))


def _palette(subject: _Subject) -> npt.NDArray[np.uint8]:
    """Return the colour of each face, brighter where it is turned to the light; last the background."""
    mesh = subject.mesh
    a, b, c = (subject.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    lit = np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), -1, 1)
    shade = _DARKEST + (1 - _DARKEST) * (lit + 1) / 2
    colors = mesh.palette[mesh.surfaces] * shade[:, None]
    return np.vstack([colors.round(), _BACKGROUND]).astype(np.uint8)
