"""An image of a scene from outside, shaded so that shapes are recognisable, drawn without an engine."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.optics import Optics, looking
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.render.shaded import ShadedView
from nrp_core.world.rigid.matrices import matrix_of
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Scene
from nrp_core.world.scene.starts import body_poses

FIELD_OF_VIEW = radians(40)

_FROM_ROBOT, _FROM_ROOM = (radians(35), radians(25)), (radians(60), radians(62))  # yaw and height of the eye
_FILLED = 0.9  # maximum share of the image
_CLEARANCE = 0.02  # minimum distance from the eye, in multiples of the scene's extent


@dataclass(frozen=True)
class _Subject:
    """The geometry to draw, in the world.

    Args:
        mesh: the visuals.
        vertices: all vertices in the world.
        framed: the vertices that the image must show.
    """

    mesh: SceneMesh
    vertices: FloatArray
    framed: npt.NDArray[np.bool_]


def portrait(scene: Scene, width: int = 960, height: int = 720) -> npt.NDArray[np.uint8]:
    """Return an image of a scene, all joints where they start; RGB, shape ``(height, width, 3)``.

    Raises:
        SceneError: the scene cannot be drawn, for example because a mesh cannot be read.
    """
    subject = _subject(scene)
    view = ShadedView(subject.mesh, width, height, vertical_fov=FIELD_OF_VIEW)
    eye = np.eye(3, 4)
    if len(subject.mesh.faces):
        eye = _eye(subject, view.optics, any(not model.static for model in scene.models))
    return view.draw(subject.vertices, eye)


def _subject(scene: Scene) -> _Subject:
    bodies = {model.name: bodies_of(model) for model in scene.models}
    numbers = frames_of(bodies)
    mesh = SceneMesh(bodies, numbers)
    frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))
    poses = {model.name: body_poses(model, bodies[model.name]) for model in scene.models}
    for (name, index), number in numbers.items():
        frames[number] = matrix_of(poses[name][index])
    vertices = mesh.in_world(frames)
    return _Subject(mesh, vertices, mesh.framed(vertices))


def _eye(subject: _Subject, optics: Optics, is_robot: bool) -> FloatArray:
    """Return the pose of the camera: outside, above, and as near as possible with everything in view."""
    yaw, up = _FROM_ROBOT if is_robot else _FROM_ROOM
    turn = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, up, yaw + np.pi)
    axes = matrix_of(turn)[:, :3]
    points = subject.vertices[subject.framed] @ axes  # ahead, left, up
    high = _FILLED * tan(optics.vertical_fov / 2)
    wide = high * optics.width / optics.height
    eye = np.append(-points.max(), (points.min(axis=0) + points.max(axis=0))[1:] / 2)
    for _ in range(4):  # nearer objects are larger: centre the image in a few iterations
        ahead, left, up = (points - eye).T
        room = max((np.abs(left) / wide - ahead).max(), (np.abs(up) / high - ahead).max())
        eye[0] -= room + _CLEARANCE * np.ptp(points, axis=0).max()
        ahead, left, up = (points - eye).T
        for axis, seen in ((1, left / ahead), (2, up / ahead)):
            eye[axis] += (seen.min() + seen.max()) / 2 * ahead.mean()
    x, y, z = axes @ eye
    return matrix_of(looking(Pose((float(x), float(y), float(z)), turn.orientation)))
