"""Where the links of a model are at positions of its joints, and positions that close its loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import cos, inf, sin

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.loops import Loop
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Joint, Model
from nrp_core.scene.rigid import Pose, Vector

_PULL_M = 1e-4
"""How far (m) a loop would open for one joint to stay 1 rad or 1 m nearer to where it is."""
_CLOSED_M = 1e-6
_ROUNDS, _STEP = 30, 0.3
"""How many steps are tried, and the largest change of a position in one, rad or m."""


class Posture:
    """The motions of links, in the frame of their model, from their poses with all joints at 0.

    Args:
        model: the model.
        positions: of its joints, rad or m; others are at 0, as are ball joints.
    """

    def __init__(self, model: Model, positions: Mapping[str, float]) -> None:
        self._holders = {joint.child: joint for joint in model.joints}
        self._positions = positions
        self._moved: dict[str, Pose] = {}

    def of(self, link: str) -> Pose:
        """Return the motion of a link, or of the world."""
        if link not in self._moved:
            joint = self._holders.get(link)
            self._moved[link] = Pose() if joint is None else self.of(joint.parent) @ self._joint_motion(joint)
        return self._moved[link]

    def _joint_motion(self, joint: Joint) -> Pose:
        position = self._positions.get(joint.name, 0.0)
        return joint.pose @ _motion(joint, position) @ joint.pose.inverse() if position else Pose()

    def gaps(self, loops: Sequence[Loop]) -> FloatArray:
        """Return the offsets between the points that links of loops share, m, shape ``(m, 3)``."""
        ends = [
            (self._place(loop.parent, p), self._place(loop.child, p)) for loop in loops for p in loop.points
        ]
        return np.array([here - there for here, there in ends])

    def slopes(self, loops: Sequence[Loop], joints: Sequence[str]) -> FloatArray:
        """Return the derivatives of the gaps by the positions of joints, shape ``(m, 3, n)``."""
        numbers = {name: number for number, name in enumerate(joints)}
        points = [(loop, point) for loop in loops for point in loop.points]
        slopes = np.zeros((len(points), 3, len(joints)))
        for slope, (loop, point) in zip(slopes, points, strict=True):
            for link, sign in ((loop.parent, 1.0), (loop.child, -1.0)):
                place = self._place(link, point)
                for joint in self._above(link):
                    if joint.name in numbers:
                        slope[:, numbers[joint.name]] += sign * self._velocity(joint, place)
        return slopes

    def _place(self, link: str, point: Vector) -> FloatArray:
        return np.array((self.of(link) @ Pose(point)).position)

    def _above(self, link: str) -> Iterator[Joint]:
        while link in self._holders:
            yield self._holders[link]
            link = self._holders[link].parent

    def _velocity(self, joint: Joint, place: FloatArray) -> FloatArray:
        """Return the velocity of a place by the unit velocity of a joint that moves it."""
        frame = self.of(joint.parent) @ joint.pose
        axis = np.array(frame.rotate(joint.axis))
        return axis if joint.kind == "prismatic" else np.cross(axis, place - frame.position)


def closing(model: Model, starts: Mapping[str, float], fixed: Sequence[str]) -> Mapping[str, float]:
    """Return positions of joints near the given ones, within limits, that close all loops.

    Each round is a step of the method of Gauss and Newton with bounds.

    Args:
        model: the model.
        starts: positions at which loops may be open; other joints are at 0.
        fixed: joints that do not move.

    Returns:
        The positions that are not 0, with the smallest gaps that were found if none closes the loops.
    """
    from scipy.optimize import lsq_linear

    leaders = {joint.mimic.leader for joint in model.joints if joint.mimic is not None}
    free = {
        joint.name: joint
        for joint in model.joints
        if joint.takes_commands and joint.mimic is None and joint.name not in {*fixed, *leaders}
        if joint.lower < joint.upper
    }
    bounds = np.array([(joint.lower, joint.upper) for joint in free.values()]).reshape(-1, 2).T
    before = np.array([starts.get(name, 0.0) for name in free])
    values, best, widest_m = before, dict(starts), inf
    for _ in range(_ROUNDS if free else 0):
        positions = {**starts, **dict(zip(free, values.tolist(), strict=True))}
        posture = Posture(model, positions)
        gaps = posture.gaps(model.loops).ravel()
        if np.abs(gaps).max() < widest_m:
            best, widest_m = positions, float(np.abs(gaps).max())
        if widest_m < _CLOSED_M:
            break
        slopes = posture.slopes(model.loops, list(free)).reshape(gaps.size, -1)
        rows = np.vstack([slopes, _PULL_M * np.eye(len(free))])
        wanted = np.concatenate([-gaps, _PULL_M * (before - values)])
        within = np.clip(bounds - values, -_STEP, _STEP)
        values = values + lsq_linear(rows, wanted, within, method="bvls").x
    return {name: value for name, value in best.items() if abs(value) > _CLOSED_M}


def _motion(joint: Joint, position: float) -> Pose:
    """Return the motion of a joint from 0 to a position, in its own frame."""
    x, y, z = joint.axis
    if joint.kind == "prismatic":
        return Pose((position * x, position * y, position * z))
    half = sin(position / 2)
    return Pose((0.0, 0.0, 0.0), (half * x, half * y, half * z, cos(position / 2)))


def start_positions(model: Model) -> Mapping[str, float]:
    """Return the start positions (rad, m) of the joints of a model that do not start at 0.

    A joint that follows another one starts at the position that this gives it.
    """
    given = dict(model.starts)
    movable = {joint.name: joint for joint in model.joints if joint.takes_commands}
    led = {
        name: given.get(name, _within(joint, 0.0))
        for name, joint in movable.items()
        if joint.mimic is None or name in given
    }
    every = with_followers(model, led)
    starts = {name: every[name] for name in movable if every.get(name)}
    return closing(model, starts, list(given)) if starts and model.loops else starts


def with_followers(model: Model, positions: Mapping[str, float]) -> dict[str, float]:
    """Return positions of joints and those of the joints that follow them, which are not given."""
    every = dict(positions)
    following = {joint: joint.mimic for joint in model.joints if joint.mimic and joint.name not in every}
    while ready := {joint: mimic for joint, mimic in following.items() if mimic.leader in every}:
        for joint, mimic in ready.items():
            every[joint.name] = _within(joint, mimic.multiplier * every[mimic.leader] + mimic.offset)
            del following[joint]
    return every


def body_poses(model: Model, bodies: Sequence[Body]) -> list[Pose]:
    """Return the poses of a model's bodies in the world, at the initial positions of its joints."""
    posture = Posture(model, start_positions(model))
    moved = [posture.of(body.links[0].name if body.links else WORLD) for body in bodies]
    return [model.pose @ motion @ body.in_model for motion, body in zip(moved, bodies, strict=True)]


def at_start(model: Model) -> Model:
    """Return a model with its links at the initial joint positions, only for its geometry.

    The poses of the result are not those with all joints at 0, so its joints cannot be moved further.
    """
    starts = start_positions(model)
    if not starts:
        return model
    posture = Posture(model, starts)
    links = tuple(replace(link, pose=posture.of(link.name) @ link.pose) for link in model.links)
    joints = tuple(replace(one, pose=posture.of(one.parent) @ one.pose) for one in model.joints)
    return replace(model, links=links, joints=joints)


def moved_into_limits(model: Model) -> list[Joint]:
    """Return the joints whose limits exclude 0 and for which no start position is given."""
    given = dict(model.starts)
    free = [joint for joint in model.joints if joint.takes_commands and joint.mimic is None]
    return [joint for joint in free if joint.name not in given and _within(joint, 0.0)]


def _within(joint: Joint, position: float) -> float:
    return min(max(position, joint.lower), joint.upper)
