"""Robots that move on a plane as commanded, and slide along solid objects.

A robot is an ideal unicycle: its velocity is the commanded one from the next step on, its path an arc. If its
footprint then overlaps another, it is moved out by the shortest way, which follows from the separating axes
of the two rectangles (Gottschalk, Lin & Manocha 1996, SIGGRAPH, 171-180).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.world import (
    BodyVelocity,
    Collision,
    Engine,
    FloatArray,
    Model,
    ModelMotion,
    Plane,
    Pose,
    Scene,
    Vector,
    WorldBackend,
    WorldCapabilities,
    WorldOptions,
    drawn,
    matrix_of,
    triangles_of,
)

STEP_NS = 5_000_000
STEP_S = seconds(STEP_NS)
CLEARANCE_M = 0.05
"""Shapes that end this little above the lowest point of a robot are ground, m."""
ATTEMPTS = 4
"""Number of footprints a robot is moved out of in one step; a corner has two."""
REST = BodyVelocity()
CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])


@dataclass(frozen=True)
class Footprint:
    """An upright box around a solid object: its corners, shape ``(4, 2)``, and heights, m."""

    corners: FloatArray
    low: float
    high: float

    @classmethod
    def around(cls, points: FloatArray, yaw: float = 0.0) -> Footprint:
        """Return the rectangle with sides along ``yaw`` around points, shape ``(n, 3)``."""
        turn = rotation(yaw)
        flat = points[:, :2] @ turn
        low, high = flat.min(0), flat.max(0)
        corners = (low + CORNERS * (high - low)) @ turn.T
        return cls(corners, points[:, 2].min(), points[:, 2].max())

    def at(self, x: float, y: float, yaw: float) -> FloatArray:
        """Return its corners at the pose of a robot."""
        return self.corners @ rotation(yaw).T + (x, y)


def rotation(yaw: float) -> FloatArray:
    """Return the rotation matrix of an angle."""
    return np.array([(cos(yaw), -sin(yaw)), (sin(yaw), cos(yaw))])


def points_of(collision: Collision, place: Pose) -> FloatArray:
    """Return the vertices of a solid shape."""
    geometry, pose = drawn(collision.geometry, place @ collision.pose)
    matrix = matrix_of(pose)
    return triangles_of(geometry)[0] @ matrix[:, :3].T + matrix[:, 3]


def solids(model: Model) -> Iterator[tuple[Collision, Pose]]:
    """Return the solid shapes of a model with the poses of their links; infinite planes are ground."""
    for link in model.links:
        for collision in link.collisions:
            if not isinstance(collision.geometry, Plane):
                yield collision, link.pose


def still(model: Model) -> Iterator[Footprint]:
    """Return the footprints of a static model, one for each shape."""
    for collision, place in solids(model):
        place = model.pose @ place
        yield Footprint.around(points_of(collision, place), (place @ collision.pose).yaw)


def carried(model: Model) -> Footprint:
    """Return the footprint of a robot about its own frame, in its own frame."""
    roll, pitch, _ = model.pose.rpy
    upright = Pose.from_rpy((0.0, 0.0, model.pose.position[2]), roll, pitch, 0.0)
    points = [points_of(collision, upright @ place) for collision, place in solids(model)]
    return Footprint.around(np.concatenate(points) if points else np.zeros((1, 3)))


def way_out(mine: FloatArray, theirs: FloatArray) -> FloatArray:
    """Return the shortest move that takes a rectangle out of others.

    Args:
        mine: corners, shape ``(4, 2)``.
        theirs: corners of others, shape ``(n, 4, 2)``.

    Returns:
        The move out of the one with the deepest overlap, shape ``(2,)``; 0 without overlap.
    """
    rectangles = np.concatenate([theirs, np.broadcast_to(mine, theirs.shape)], axis=1).reshape(-1, 2, 4, 2)
    sides = rectangles[:, :, (1, 3)] - rectangles[:, :, :1]  # two axes of each rectangle
    axes = sides.reshape(-1, 4, 2) / np.maximum(np.linalg.norm(sides, axis=-1), 1e-12).reshape(-1, 4, 1)
    here, there = axes @ mine.T, axes @ theirs.transpose(0, 2, 1)
    ahead, back = there.max(2) - here.min(2), here.max(2) - there.min(2)
    depths = np.minimum(ahead, back)
    nearest = depths.argmin(1)
    every = np.arange(len(theirs))
    deepest = int(depths[every, nearest].argmax())
    axis = nearest[deepest]
    depth = max(0.0, depths[deepest, axis])
    sign = 1.0 if ahead[deepest, axis] < back[deepest, axis] else -1.0
    move: FloatArray = sign * depth * axes[deepest, axis]
    return move


@dataclass(frozen=True, slots=True)
class Robot:
    """The pose of a robot, its motion in the last step, and its command."""

    x: float
    y: float
    yaw: float
    linear: Vector = (0.0, 0.0, 0.0)
    turn: float = 0.0
    command: BodyVelocity = REST

    def moved(self) -> tuple[float, float, float]:
        """Return the pose after one step of the command; the chord of the arc lies along its mean heading."""
        angle = self.command.turn * STEP_S
        middle = self.yaw + angle / 2
        length = STEP_S * float(np.sinc(angle / 2 / np.pi))
        x = self.x + length * (self.command.forward * cos(middle) - self.command.left * sin(middle))
        y = self.y + length * (self.command.forward * sin(middle) + self.command.left * cos(middle))
        return x, y, self.yaw + angle


class MinimalEngine(Engine):
    """Moves one robot after the other."""

    def __init__(self, scene: Scene, capabilities: WorldCapabilities, *, seed: int) -> None:
        super().__init__(scene, capabilities, seed=seed, identity="minimal")
        self._static = [footprint for model in scene.models if model.static for footprint in still(model)]
        self._footprints = {model.name: carried(model) for model in scene.models if not model.static}
        self._do_reset(seed)

    # -- required by the interface

    def _do_advance(self, steps: int) -> None:
        for _ in range(steps):
            for name in self._robots:
                self._move(name)

    def _do_reset(self, seed: int) -> None:
        models = map(self.scene.model, self._footprints)
        self._robots = {m.name: Robot(*m.pose.position[:2], m.pose.yaw) for m in models}

    def _do_model_motion(self, model: str) -> ModelMotion:
        start = self.scene.model(model).pose
        if model not in self._robots:
            return ModelMotion(start)
        robot, (roll, pitch, _) = self._robots[model], start.rpy
        pose = Pose.from_rpy((robot.x, robot.y, start.position[2]), roll, pitch, robot.yaw)
        return ModelMotion(pose, robot.linear, (0.0, 0.0, robot.turn))

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._robots[model] = replace(self._robots[model], command=velocity)

    # -- optional

    def _do_save(self) -> object:
        return dict(self._robots)

    def _do_restore(self, saved: Any) -> None:
        self._robots = dict(saved)

    # -- a step

    def _move(self, name: str) -> None:
        robot = self._robots[name]
        if robot.command == REST and not any(robot.linear) and not robot.turn:
            return
        x, y, yaw = robot.moved()
        footprint, others = self._footprints[name], self._others(name)
        for _ in range(ATTEMPTS if len(others) else 0):
            dx, dy = way_out(footprint.at(x, y, yaw), others).tolist()
            x, y = x + dx, y + dy
        linear = (x - robot.x) / STEP_S, (y - robot.y) / STEP_S, 0.0
        self._robots[name] = replace(robot, x=x, y=y, yaw=yaw, linear=linear, turn=(yaw - robot.yaw) / STEP_S)

    def _others(self, name: str) -> FloatArray:
        """Return the corners of the footprints that a robot can collide with, shape ``(n, 4, 2)``."""
        mine, others = self._footprints[name], list(self._static)
        for other, robot in self._robots.items():
            if other != name:
                footprint = self._footprints[other]
                others.append(replace(footprint, corners=footprint.at(robot.x, robot.y, robot.yaw)))
        met = [o.corners for o in others if o.low < mine.high and o.high > mine.low + CLEARANCE_M]
        return np.array(met).reshape(-1, 4, 2)


class MinimalBackend(WorldBackend):
    """Builds a :class:`MinimalEngine`."""

    interface_version = 2

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return WorldCapabilities(
            step_ns=STEP_NS, renderers=("raster",), snapshot=True, dynamics=False, links=True
        )

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return MinimalEngine(scene, self.capabilities(options), seed=seed)
