"""An image of a scene from outside, shaded so that shapes are recognisable, drawn without an engine."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians, tan

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Rgba, Scene
from nrp_core.scene.posture import body_poses
from nrp_core.scene.rigid import BodyPath, Pose, matrix_of
from nrp_core.world.render.cameras import looking
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.render.shaded import BACKGROUND, ShadedView, sun_of
from nrp_core.world.render.tubes import Tubes, activation_rgba

FIELD_OF_VIEW = radians(40)

_FROM_ROBOT, _FROM_ROOM = (radians(35), radians(25)), (radians(60), radians(62))  # yaw and height of the eye
_FILLED, _WITH_PLACE = 0.9, 0.6  # maximum share of the image: of a whole scene, of some models in their place
_CUT = 0.7  # omit objects nearer than this share of the distance to these models, such as a wall
_CLEARANCE = 0.02  # minimum distance from the eye, in multiples of the scene's extent


@dataclass(frozen=True)
class Moment:
    """The poses of all bodies, if not the initial ones.

    Args:
        frames: writes rotation and translation to the world of bodies, shape ``(n, 3, 4)``.
        muscles: the path in the world of each muscle that is drawn, m, shape ``(k, 3)``; its radius, m; and
            its colour.
        colors: the colours of visuals that were set, by path, ``model/link/visual``.
    """

    frames: Callable[[Sequence[BodyPath], FloatArray], None]
    muscles: Sequence[tuple[FloatArray, float, Rgba]] = ()
    colors: Mapping[str, Rgba] = field(default_factory=dict)


@dataclass(frozen=True)
class _Subject:
    """The geometry to draw, in the world.

    Args:
        mesh: the visuals.
        frames: rotation and translation of its frames to the world.
        vertices: all vertices in the world.
        framed: the vertices that the image must show.
    """

    mesh: SceneMesh
    frames: FloatArray
    vertices: FloatArray
    framed: npt.NDArray[np.bool_]


def portrait(
    scene: Scene,
    width: int = 960,
    height: int = 720,
    *,
    moment: Moment | None = None,
    of: Collection[str] = (),
) -> npt.NDArray[np.uint8]:
    """Return an image of a scene; RGB, shape ``(height, width, 3)``.

    Args:
        scene: the scene.
        width: the width of the image, pixels.
        height: its height, pixels.
        moment: the poses of all bodies; by default at the initial joint positions.
        of: names of models in the middle of the image, which no other object hides; by default all
            models are in it, except endless scenery.

    Raises:
        SceneError: the scene cannot be drawn, for example because a mesh cannot be read.
    """
    subject = _subject(scene, moment or _start(scene), of)
    if not len(subject.mesh.faces):
        return np.full((height, width, 3), BACKGROUND, np.uint8)
    view = ShadedView(subject.mesh, width, height, vertical_fov=FIELD_OF_VIEW, sun=sun_of(scene.lights))
    is_robot = any(not model.static for model in scene.models)
    points = subject.vertices[subject.framed]
    filled = _WITH_PLACE if of else _FILLED
    direction = _FROM_ROBOT if is_robot else _FROM_ROOM
    eye = eye_that_sees(points, *direction, vertical_fov=FIELD_OF_VIEW, aspect=width / height, filled=filled)
    distances_m = (eye[:, 3] - points) @ eye[:, 2]
    near_m = {"near_m": _CUT * float(distances_m.min())} if of else {}
    return view.draw(subject.frames, eye, away_m=float(distances_m.mean()), **near_m)


def _subject(scene: Scene, moment: Moment, of: Collection[str]) -> _Subject:
    tubes = Tubes([len(path) for path, *_ in moment.muscles], [radius for _, radius, _ in moment.muscles])
    bodies = {model.name: bodies_of(model) for model in scene.models}
    paths = list(frames_of(bodies))
    pieces = {model.name: bodies_of(model) for model in tubes.models}
    numbers = frames_of({**bodies, **pieces})
    mesh = SceneMesh({**bodies, **pieces}, numbers)
    frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))
    moment.frames(paths, frames[1 : 1 + len(paths)])
    for name, frame in tubes.frames([path for path, *_ in moment.muscles]).items():
        frames[numbers[name, 0]] = frame
    for visual, rgba in _colors(moment, tubes):
        mesh.set_color(visual, rgba)
    vertices = mesh.in_world(frames)
    mine = np.isin(mesh.vertex_frames, [number for (name, _), number in numbers.items() if name in of])
    return _Subject(mesh, frames, vertices, mine if mine.any() else mesh.framed(vertices))


def _colors(moment: Moment, tubes: Tubes) -> Iterator[tuple[str, Rgba]]:
    """Yield the colours of visuals that are not those of the scene."""
    yield from moment.colors.items()
    for number, (*_, rgba) in enumerate(moment.muscles):
        yield from ((visual, rgba) for visual in tubes.visuals(number))


def _start(scene: Scene) -> Moment:
    """Return where everything starts."""

    def frames(paths: Sequence[BodyPath], rows: FloatArray) -> None:
        for row, (model, index) in zip(rows, paths, strict=True):
            row[:] = matrix_of(poses[model][index])

    poses = {model.name: body_poses(model, bodies_of(model)) for model in scene.models}
    muscles = [
        (np.array([(model.pose @ Pose(point)).position for point in points]), radius, activation_rgba(0.0))
        for model in scene.models
        for drive in model.drives
        for points, radius in [tube for tube in [drive.tube(model)] if tube is not None]
    ]
    return Moment(frames, muscles)


def eye_that_sees(
    points: FloatArray, yaw: float, up: float, *, vertical_fov: float, aspect: float, filled: float
) -> FloatArray:
    """Return the nearest pose of the camera from which all points are visible, shape ``(3, 4)``.

    Args:
        points: the points that must be visible, m, shape ``(n, 3)``.
        yaw: direction from the points to the camera, rad.
        up: angle of this direction above the horizon, rad.
        vertical_fov: vertical field of view, rad.
        aspect: width of the image divided by its height.
        filled: the share of the image that the points may cover.
    """
    turn = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, up, yaw + np.pi)
    axes = matrix_of(turn)[:, :3]
    points = points @ axes  # ahead, left, up
    high = filled * tan(vertical_fov / 2)
    wide = high * aspect
    eye = np.append(-points.max(), (points.min(axis=0) + points.max(axis=0))[1:] / 2)
    for _ in range(4):  # nearer objects are larger: centre the image in a few iterations
        ahead, left, above = (points - eye).T
        room = max((np.abs(left) / wide - ahead).max(), (np.abs(above) / high - ahead).max())
        eye[0] -= room + _CLEARANCE * np.ptp(points, axis=0).max()
        ahead, left, above = (points - eye).T
        for axis, seen in ((1, left / ahead), (2, above / ahead)):
            eye[axis] += (seen.min() + seen.max()) / 2 * ahead.mean()
    x, y, z = axes @ eye
    return matrix_of(looking(Pose((float(x), float(y), float(z)), turn.orientation)))
