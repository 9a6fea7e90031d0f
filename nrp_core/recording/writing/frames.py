"""The moving frames of a scene: those of links, or those of models if the engine does not report links."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from math import sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit
from nrp_core.errors import CapabilityError, SceneError
from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.scene.merged_bodies import Body, bodies_of, body_of, place_in_frame
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import Pose, matrix_of
from nrp_core.world.render.scene_mesh import frames_of
from nrp_core.world.world import World


class Frames(ABC):
    """The frames of one scene.

    Attributes:
        names: names of the moving frames.
    """

    names: tuple[str, ...] = ()

    @abstractmethod
    def place(self, model: str, link: str) -> tuple[str, Pose]:
        """Return the frame that a link moves with, and its pose in that frame."""

    @abstractmethod
    def poses(self) -> FloatArray:
        """Return the poses of the frames: positions and orientations (x, y, z, w), shape ``(n, 7)``."""


class SceneFrames:
    """The frames of a world, whose scene may change.

    Args:
        world: the world; its engine reports the poses of bodies.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._scene: Scene | None = None

    @property
    def now(self) -> Frames:
        """The frames of the current scene."""
        if self._world.scene is not self._scene:
            self._scene = self._world.scene
            self._frames = _frames(self._world)
        return self._frames


def _frames(world: World) -> Frames:
    try:
        return _LinkFrames(world)
    except (
        CapabilityError,
        SceneError,
    ):  # an engine without joints does not need masses, and reports only models
        return _ModelFrames(world)


class _LinkFrames(Frames):
    """The frames of bodies that move, named after their first links, ``model/link``, and of all sensors."""

    def __init__(self, world: World) -> None:
        self._bodies = {model.name: bodies_of(model) for model in world.scene.models}
        found = [
            (path, *frame)
            for path in frames_of(self._bodies)
            for frame in _in_body(path[0], self._bodies[path[0]][path[1]]).items()
        ]
        paths = [path for path, _, _ in found]
        still = [frame for model in world.scene.models for frame in _fixed_sensors(model.name, self._bodies)]
        self.names = (*(name for _, name, _ in found), *(name for name, _ in still))
        self._in_body = np.array([matrix_of(pose) for _, _, pose in found]).reshape(-1, 3, 4)
        self._at, self._poses = np.empty((len(paths), 3, 4)), np.empty((len(self.names), 7))
        for row, (_, pose) in enumerate(still, start=len(paths)):
            self._poses[row] = *pose.position, *pose.orientation
        self._read = world.engine.frames(paths)
        self._read(self._at)  # an engine without this capability raises its error now

    def place(self, model: str, link: str) -> tuple[str, Pose]:
        bodies = self._bodies[model]
        body = bodies[body_of(bodies, link)]
        pose = next(each.pose for each in body.links if each.name == link)
        if body.fixed:
            return WORLD_FRAME, place_in_frame(body) @ pose
        return f"{model}/{body.name}", body.links[0].pose.inverse() @ pose

    def poses(self) -> FloatArray:
        self._read(self._at)
        to_poses(self._at, self._in_body, self._poses[: len(self._at)])
        return self._poses


def _fixed_sensors(model: str, bodies: Mapping[str, Sequence[Body]]) -> Iterator[tuple[str, Pose]]:
    """Yield the frames of sensors on bodies that never move, with their poses in the world."""
    for body in bodies[model]:
        for link in body.links if body.fixed else ():
            for sensor in link.sensors:
                place = place_in_frame(body) @ link.pose @ (sensor.offset or Pose())
                yield sensor.frame_on(model, link.name), place


def _in_body(model: str, body: Body) -> dict[str, Pose]:
    """Return the frames of a body with their poses in it: of its first link, and of its sensors' messages."""
    frames = {f"{model}/{body.name}": body.links[0].pose}
    for link in body.links:
        for sensor in link.sensors:
            place = link.pose @ (sensor.offset or Pose())
            frames.setdefault(sensor.frame_on(model, link.name), place)
    return frames


class _ModelFrames(Frames):
    """A frame for each model that is not static, under its name."""

    def __init__(self, world: World) -> None:
        self._world, self._scene = world, world.scene
        if world.engine.capabilities.poses:
            self.names = tuple(model.name for model in world.scene.models if not model.static)

    def place(self, model: str, link: str) -> tuple[str, Pose]:
        found = self._scene.model(model)
        pose = found.link(link).pose
        return (WORLD_FRAME, found.pose @ pose) if found.static else (model, pose)

    def poses(self) -> FloatArray:
        at = [self._world.model_motion(name).pose for name in self.names]
        return np.array([(*pose.position, *pose.orientation) for pose in at]).reshape(-1, 7)


@jit
def to_poses(frames: FloatArray, in_frames: FloatArray, poses: FloatArray) -> None:
    """Write positions and orientations (x, y, z, w) of poses fixed in frames.

    Args:
        frames: rotation and translation of the frames, shape ``(n, 3, 4)``.
        in_frames: rotation and translation of a pose in each frame, shape ``(n, 3, 4)``.
        poses: the result, shape ``(n, 7)``.
    """
    r = np.empty((3, 3))
    for n in range(len(frames)):
        for i in range(3):
            poses[n, i] = frames[n, i, 3]
            for k in range(3):
                poses[n, i] += frames[n, i, k] * in_frames[n, k, 3]
                r[i, k] = 0.0
                for j in range(3):
                    r[i, k] += frames[n, i, j] * in_frames[n, j, k]
        poses[n, 3:] = orientation(r)


@inlined
def orientation(r: FloatArray) -> tuple[float, float, float, float]:
    """Return a rotation matrix as a quaternion (x, y, z, w), from its largest component (Shepperd, 1978)."""
    x, y, z = r[0, 0], r[1, 1], r[2, 2]
    w = x + y + z
    if w >= max(x, y, z):
        s = 2.0 * sqrt(1.0 + w)
        return (r[2, 1] - r[1, 2]) / s, (r[0, 2] - r[2, 0]) / s, (r[1, 0] - r[0, 1]) / s, s / 4
    if x >= max(y, z):
        s = 2.0 * sqrt(1.0 + x - y - z)
        return s / 4, (r[0, 1] + r[1, 0]) / s, (r[0, 2] + r[2, 0]) / s, (r[2, 1] - r[1, 2]) / s
    if y >= z:
        s = 2.0 * sqrt(1.0 + y - x - z)
        return (r[0, 1] + r[1, 0]) / s, s / 4, (r[1, 2] + r[2, 1]) / s, (r[0, 2] - r[2, 0]) / s
    s = 2.0 * sqrt(1.0 + z - x - y)
    return (r[0, 2] + r[2, 0]) / s, (r[1, 2] + r[2, 1]) / s, s / 4, (r[1, 0] - r[0, 1]) / s
