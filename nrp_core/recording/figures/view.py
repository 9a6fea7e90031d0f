"""The room from above as outlines: objects, trajectories of robots, and the area of a map."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf

import cv2
import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import Coloured, Story
from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.recording.reading.shapes import Shape, ShapeKind
from nrp_core.world.rigid import Pose, rotation_matrix
from nrp_core.world.scene.meshes.stl import parse_stl

_OVERHEAD_M = 2.2
"""Shapes that start above this height (m) hide the scene and are left out."""
_FLAT_M = 0.06
"""Shapes that end below this height (m) are ground."""
_MARGIN_M, _MARGIN_SIZE, _MARGIN = 0.3, 0.3, 0.08
"""Margin of a map: at least this distance (m), or this share of a small robot's size; and this share of the
map's larger side."""
_STILL_M, _STILL_RAD = 0.05, 0.1
"""A robot with less motion (m, or a fifth of a small robot's size) and rotation (rad) counts as standing."""
_FIFTH = 0.2
_FAINTEST = 0.05
"""Shapes less opaque than this are not drawn."""


@dataclass(frozen=True)
class GroundOutline:
    """The outline of a shape seen from above, m, shape ``(n, 2)``, with its lowest and highest point."""

    outline: FloatArray
    bottom: float
    top: float
    shape: Shape

    @property
    def is_ground(self) -> bool:
        """Whether a robot could drive over it."""
        return self.top < _FLAT_M

    @property
    def is_overhead(self) -> bool:
        """Whether a person could walk below it."""
        return self.bottom > _OVERHEAD_M


def footprint(shape: Shape, frame: Pose) -> GroundOutline:
    """Return the outline of a shape whose frame has this pose in the world."""
    pose = frame @ shape.pose
    corners = _corners(shape) @ rotation_matrix(pose.orientation).T + pose.position
    hull = cv2.convexHull(corners[:, :2].astype(np.float32)).reshape(-1, 2)
    heights = corners[:, 2]
    return GroundOutline(np.asarray(hull, float), float(heights.min()), float(heights.max()), shape)


def _corners(shape: Shape) -> FloatArray:
    """Return points of a shape's hull in its own frame, shape ``(n, 3)``."""
    if shape.kind is ShapeKind.MESH:
        triangles = np.zeros((1, 3)) if shape.mesh is None else parse_stl(shape.mesh.tobytes())
        return triangles.reshape(-1, 3) * shape.size
    x, y, z = np.divide(shape.size, 2)
    if shape.kind is ShapeKind.BOX:
        rim = np.array([(x, y), (-x, y), (-x, -y), (x, -y)])
    else:
        turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        rim = np.column_stack([x * np.cos(turns), y * np.sin(turns)])
    return np.vstack([np.column_stack([rim, np.full(len(rim), height)]) for height in (-z, z)])


@dataclass(frozen=True)
class RoomView:
    """The room from above: its objects, and the trajectories of robots.

    Args:
        story: of the run.
        fixed: the outlines of static objects.
        robots: outlines of each robot at its first and last pose.
    """

    story: Story
    fixed: list[GroundOutline]
    robots: dict[str, tuple[list[FloatArray], list[FloatArray]]]

    @classmethod
    def of(cls, story: Story) -> RoomView:
        """Return the view of a run."""
        seen = [shape for shape in story.scene.shapes if shape.rgba[3] > _FAINTEST]
        fixed = [footprint(shape, Pose()) for shape in seen if shape.frame == WORLD_FRAME]
        robots = {
            name: (_outlines(seen, name, story.first_poses), _outlines(seen, name, story.last_poses))
            for name in story.tracks
        }
        return cls(story, [piece for piece in fixed if not piece.is_overhead], robots)

    @property
    def moves(self) -> bool:
        """Whether a robot as a whole moved, so that a map of it shows something."""
        return any(
            max(np.ptp(track.xs), np.ptp(track.ys)) > min(_STILL_M, _FIFTH * self.size_m(name))
            or np.ptp(track.yaws) > _STILL_RAD
            for name, track in self.story.tracks.items()
        )

    def size_m(self, robot: str) -> float:
        """Return the larger side of a robot, m; infinity if it has no shapes."""
        first, _ = self.robots[robot]
        return float(np.ptp(np.concatenate(first), axis=0).max()) if first else inf

    @property
    def _margin_m(self) -> float:
        return min((_MARGIN_M, *(_MARGIN_SIZE * self.size_m(robot) for robot in self.robots)))

    def focus(self, coloured: Iterable[Coloured] = ()) -> Bounds:
        """Return the area of a map: robots, their trajectories, and changes of colours; with a margin."""
        return _bounds(self.foreground(coloured), self._margin_m)

    def whole(self) -> Bounds:
        """Return the bounds of all objects in the room."""
        standing = [piece.outline for piece in self.fixed if not piece.is_ground]
        return _bounds([*standing, *self.travelled()], self._margin_m)

    def foreground(self, coloured: Iterable[Coloured]) -> list[FloatArray]:
        """Return the outlines of objects that changed their colour, of the robots, and their trajectories."""
        bright = {interval.visual for interval in coloured}
        outlines = [piece.outline for piece in self.fixed if piece.shape.visual in bright]
        return outlines + self.travelled()

    def travelled(self) -> list[FloatArray]:
        """Return the outlines of the robots at both ends of their trajectories, and the trajectories."""
        outlines = [outline for both in self.robots.values() for each in both for outline in each]
        tracks = self.story.tracks.values()
        return outlines + [np.column_stack([track.xs, track.ys]) for track in tracks]


@dataclass(frozen=True)
class Bounds:
    """A rectangle on the ground, m."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def aspect(self) -> float:
        """Width divided by height."""
        return (self.right - self.left) / (self.top - self.bottom)

    def widened(self, aspect: float) -> Bounds:
        """Return the smallest bounds with another aspect ratio and the same middle that contain these."""
        width = max(self.right - self.left, (self.top - self.bottom) * aspect)
        x, y, height = (self.left + self.right) / 2, (self.bottom + self.top) / 2, width / aspect
        return Bounds(x - width / 2, x + width / 2, y - height / 2, y + height / 2)

    @property
    def area(self) -> float:
        """In m^2."""
        return (self.right - self.left) * (self.top - self.bottom)


def _bounds(outlines: Sequence[FloatArray], margin_m: float) -> Bounds:
    points = np.concatenate(outlines) if outlines else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(margin_m, _MARGIN * float((high - low).max()))
    (left, bottom), (right, top) = low - margin, high + margin
    return Bounds(float(left), float(right), float(bottom), float(top))


def _outlines(seen: Iterable[Shape], model: str, poses: Mapping[str, Pose]) -> list[FloatArray]:
    return [
        footprint(shape, poses[shape.frame]).outline
        for shape in seen
        if shape.model == model and shape.frame != WORLD_FRAME and shape.frame in poses
    ]
