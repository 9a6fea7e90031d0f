"""An image of a scene from outside, shaded so that shapes are recognisable, drawn without an engine."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import Optics, looking
from nrp_core.world.render.raster import FaceView
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.render.tubes import Tubes
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Scene
from nrp_core.world.scene.posture import body_poses

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
    tubes, tube_frames = _muscles(scene)
    bodies = {model.name: bodies_of(model) for model in (*scene.models, *tubes.models)}
    numbers = frames_of(bodies)
    mesh = SceneMesh(bodies, numbers)
    frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))
    poses = {model.name: body_poses(model, bodies[model.name]) for model in scene.models}
    for (name, index), number in numbers.items():
        frames[number] = matrix_of(poses[name][index]) if name in poses else tube_frames[name]
    vertices = mesh.in_world(frames)
    return _Subject(mesh, vertices, mesh.framed(vertices))


def _muscles(scene: Scene) -> tuple[Tubes, dict[str, FloatArray]]:
    """Return the muscles of a scene as tubes, and their frames where all joints start."""
    drawn = [(model, drive.tube(model)) for model in scene.models for drive in model.drives]
    shapes = [(model.pose, *tube) for model, tube in drawn if tube is not None]
    tubes = Tubes([len(points) for _, points, _ in shapes], [radius for *_, radius in shapes])
    paths = [np.array([(place @ Pose(point)).position for point in points]) for place, points, _ in shapes]
    return tubes, tubes.frames(paths)


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
