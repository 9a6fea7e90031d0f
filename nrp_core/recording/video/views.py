"""The pose of the camera for each image of a drawn video."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import exp, radians, tan

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.view import Bounds
from nrp_core.recording.video import Vector
from nrp_core.world.rigid import Pose

FIELD_OF_VIEW = radians(45)
_DISTANCE, _LEAST_M, _SMALL_M = 3.5, 0.5, 0.05
"""The distance of the following camera, in multiples of the robot's size; robots below the second size count
as if they had it, except those below the third, which are in a world of their size."""
_HEIGHTS = tuple(radians(degrees) for degrees in (27, 40, 55, 70, 88))
"""Angles above the horizon that it tries."""
_LAG_S = 0.6
"""Time constant of its rotation, s, so that quick turns of a robot do not shake the image."""
_OBLIQUE = (-1.0, -1.0, 0.9)
"""Direction from the middle of the scene to a free camera."""


class Viewpoint(ABC):
    """Returns the pose of the camera."""

    @abstractmethod
    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        """Return rotation and translation of the camera to the world, shape ``(3, 4)``."""


def look_at(
    eye: Vector | FloatArray, target: Vector | FloatArray, ahead: Vector = (0.0, 1.0, 0.0)
) -> FloatArray:
    """Return the pose of a camera that looks at a point, upright.

    Args:
        eye: its position, m.
        target: the point that it looks at, m.
        ahead: the direction that is up in the image if the camera looks straight down.
    """
    back = np.subtract(eye, target).astype(float)
    back /= max(float(np.linalg.norm(back)), 1e-9)
    up = np.array((0.0, 0.0, 1.0) if np.hypot(*back[:2]) > 1e-6 else ahead)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back, np.asarray(eye, float)])


class Still(Viewpoint):
    """A fixed camera."""

    def __init__(self, pose: FloatArray) -> None:
        self._pose = pose

    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        return self._pose


def from_above(bounds: Bounds, aspect: float) -> Viewpoint:
    """Return a camera that looks down and sees the bounds on the ground.

    Args:
        bounds: the area that it must see.
        aspect: width of the image divided by its height.
    """
    seen = bounds.widened(aspect)
    middle = ((seen.left + seen.right) / 2, (seen.bottom + seen.top) / 2, 0.0)
    height = (seen.top - seen.bottom) / 2 / tan(FIELD_OF_VIEW / 2)
    return Still(look_at((middle[0], middle[1], height), middle))


def free(bounds: Bounds, eye: Vector | None, target: Vector | None) -> Viewpoint:
    """Return a fixed camera; by default it sees the bounds from a corner."""
    middle = target or ((bounds.left + bounds.right) / 2, (bounds.bottom + bounds.top) / 2, 0.0)
    away = max(bounds.right - bounds.left, bounds.top - bounds.bottom)
    return Still(look_at(eye or tuple(np.add(middle, np.multiply(_OBLIQUE, away))), middle))


class Follower(Viewpoint):
    """A camera behind a robot that turns with it, and rises if something hides the robot.

    Args:
        frame: the frame of the robot's base.
        size_m: size of the robot.
        obstacles: boxes along the axes of the world that may hide it: lowest and highest corners, m, shape
            ``(n, 2, 3)``.
    """

    def __init__(self, frame: str, size_m: float, obstacles: FloatArray) -> None:
        small = 0.0 < size_m < _SMALL_M
        self._frame, self._distance = frame, _DISTANCE * (size_m if small else max(size_m, _LEAST_M))
        self._obstacles = obstacles
        self._way: FloatArray | None = None
        self._at_s = 0.0

    def eye(self, t_s: float, poses: Mapping[str, Pose]) -> FloatArray:
        pose = poses[self._frame]
        robot = np.array(pose.position)
        way = self._free_way(robot, pose.yaw)
        if self._way is not None:
            kept = exp(-max(t_s - self._at_s, 0.0) / _LAG_S)
            way = kept * self._way + (1 - kept) * way
        self._way, self._at_s = way, t_s
        way = way / max(float(np.linalg.norm(way)), 1e-9)
        ahead = (float(np.cos(pose.yaw)), float(np.sin(pose.yaw)), 0.0)
        return look_at(robot + self._distance * way, robot, ahead)

    def _free_way(self, robot: FloatArray, yaw: float) -> FloatArray:
        """Return the direction to the lowest camera behind the robot from which nothing hides it."""
        for height in _HEIGHTS:
            level = -np.cos(height)
            way = np.array((level * np.cos(yaw), level * np.sin(yaw), np.sin(height)))
            if not _hidden(robot, robot + self._distance * way, self._obstacles):
                break
        return way


def _hidden(start: FloatArray, end: FloatArray, boxes: FloatArray) -> bool:
    """Return whether a straight line meets a box that does not contain its start."""
    way = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = (boxes - start) / np.where(way == 0.0, 1e-12, way)
    enters, leaves = shares.min(axis=1).max(axis=1), shares.max(axis=1).min(axis=1)
    return bool(np.any((enters <= leaves) & (enters > 0.0) & (enters < 1.0)))
