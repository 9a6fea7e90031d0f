"""Poses and velocities of models, and states of their joints."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from math import isfinite
from operator import itemgetter, mul
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.rigid import (
    JointStates,
    ModelMotion,
    Pose,
    Quaternion,
    Vector,
    rotation_vector,
)
from nrp_core.world.engine import MOST_RATE
from nrp_core.world.engine_kit.joint_bounds import JointBounds
from nrp_world_pybullet.build import BASE, BodyHandle
from nrp_world_pybullet.library import bullet

PlaceOf = Callable[[], tuple[Vector, Quaternion]]


def moving(body: Body, place: BodyHandle, held: Pose, client: int) -> Moving:
    """Return a frame fixed to a moving body.

    Args:
        body: the body.
        place: its handle in the engine.
        held: pose of the frame in the body's frame.
        client: the physics client.
    """
    assert body.inertial is not None  # moving bodies have mass
    return Moving(place, body.inertial.pose.inverse() @ held, client)


def place_of(body: Body, place: BodyHandle, held: Pose, client: int) -> PlaceOf:
    """Return the reader of the pose of a frame fixed to a body, moving or not; as :func:`moving`."""
    if not body.fixed:
        return moving(body, place, held, client).place
    still = body.pose @ held
    return lambda: (still.position, still.orientation)


class Moving:
    """A frame at an offset from a body's inertial frame, which is the frame that PyBullet reports.

    Args:
        place: handle of the body.
        offset: pose of the frame in the inertial frame.
        client: the physics client.
    """

    def __init__(self, place: BodyHandle, offset: Pose, client: int) -> None:
        self._place, self._offset, self._client = place, offset, client
        self._back = offset.inverse()

    def __call__(self) -> ModelMotion:
        body, link = self._place.multibody, self._place.link
        if link == BASE:
            position, orientation = bullet.getBasePositionAndOrientation(body, self._client)
            linear, angular = bullet.getBaseVelocity(body, self._client)
        else:
            state = bullet.getLinkState(body, link, 1, 1, self._client)
            position, orientation, linear, angular = state[0], state[1], state[6], state[7]
        return ModelMotion(Pose(position, orientation), linear, angular).at(self._offset)

    def place(self) -> tuple[Vector, Quaternion]:
        """Return the pose of the frame; faster than its motion."""
        offset, body, link, client = self._offset, self._place.multibody, self._place.link, self._client
        if link == BASE:
            own = bullet.getBasePositionAndOrientation(body, client)
        else:
            own = bullet.getLinkState(body, link, 0, 1, client)[:2]
        frame: tuple[Vector, Quaternion]
        frame = bullet.multiplyTransforms(*own, offset.position, offset.orientation, client)
        return frame

    def is_possible(self) -> bool:
        """Return whether the place is finite and the speed below the limit; faster than the motion."""
        body, link, client = self._place.multibody, self._place.link, self._client
        if link == BASE:
            place = bullet.getBasePositionAndOrientation(body, client)[0]
            linear, angular = bullet.getBaseVelocity(body, client)
        else:
            state = bullet.getLinkState(body, link, 1, 1, client)
            place, linear, angular = state[0], state[6], state[7]
        squares = sum(map(mul, linear, linear)) + sum(map(mul, angular, angular))
        return squares < MOST_RATE**2 and isfinite(sum(place))

    def put(self, motion: ModelMotion) -> None:
        """Set pose and velocity of a base by those of the frame."""
        there = motion.at(self._back)
        where = there.pose.position, there.pose.orientation
        bullet.resetBasePositionAndOrientation(self._place.multibody, *where, self._client)
        bullet.resetBaseVelocity(self._place.multibody, there.linear, there.angular, self._client)

    def set_velocity(self, motion: ModelMotion) -> None:
        """Set the velocity of a base by that of the frame, at its present pose."""
        there = motion.at(self._back)
        bullet.resetBaseVelocity(self._place.multibody, there.linear, there.angular, self._client)


class JointReader:
    """Reads the movable joints of one model, once until they move.

    Args:
        joints: handles of the coordinates by name, in the order of the file.
        driven: the coordinates with commanded motors; the motors of others act as friction.
        client: the physics client.

    Attributes:
        names: the coordinates.
    """

    def __init__(self, joints: Mapping[str, BodyHandle], driven: Collection[str], client: int) -> None:
        self.names, self._places, self._client = tuple(joints), tuple(joints.values()), client
        self._driven = np.array([float(name in driven) for name in joints])
        self._links = [place.link for place in self._places]
        trees = {place.multibody if place.axis is None else None for place in self._places}
        self._tree = trees.pop() if len(trees) == 1 else None  # the only one, without ball joints
        self.forget()

    def forget(self) -> None:
        """Read the motions again, because the bodies have moved."""
        self._last: FloatArray | None = None
        self._rows: Sequence[Any] | None = None

    def are_within(self, bounds: JointBounds) -> bool:
        """Return whether positions and velocities are possible."""
        if self._tree is None:
            positions, velocities, _ = self._now()
            return bounds.contain(positions, velocities)
        if self._rows is None:
            self._rows = bullet.getJointStates(self._tree, self._links, self._client)
        for row, (low, high) in zip(self._rows, bounds.spans, strict=True):
            if not (low <= row[0] <= high and -MOST_RATE < row[1] < MOST_RATE):
                return False
        return True

    def positions(self) -> FloatArray:
        """Return the positions, shape ``(n,)``."""
        if self._rows is None:
            now: FloatArray = self._now()[0].copy()
            return now
        return np.array([*map(itemgetter(0), self._rows)])

    def states(self) -> JointStates:
        """Return positions, velocities and efforts; the efforts are those of the last physics step."""
        positions, velocities, efforts = self._now().copy()
        return JointStates(self.names, positions, velocities, efforts * self._driven)

    def efforts(self) -> FloatArray:
        """Return the efforts of the motors in the last step, commanded or not, shape ``(n,)``."""
        efforts: FloatArray = self._now()[2]
        return efforts

    def _now(self) -> FloatArray:
        """Return positions, velocities and efforts of the motors, shape ``(3, n)``."""
        if self._last is None:
            if self._tree is not None and self._rows is None:
                self._rows = bullet.getJointStates(self._tree, self._links, self._client)
            rows = list(self._each()) if self._rows is None else [*map(itemgetter(0, 1, 3), self._rows)]
            self._last = np.array(rows).reshape(-1, 3).T
        return self._last

    def _each(self) -> Iterator[tuple[float, float, float]]:
        """Yield position, velocity and effort of each coordinate."""
        for place in self._places:
            where = place.multibody, place.link
            if place.axis is None:
                position, velocity, _, effort = bullet.getJointState(*where, self._client)
                yield position, velocity, effort
            elif place.axis == 0:
                turn, velocities, _, efforts = bullet.getJointStateMultiDof(*where, self._client)
                yield from zip(rotation_vector(turn), velocities, efforts, strict=True)


def motions_of(multibody: int, links: list[int], client: int) -> list[tuple[float, ...]]:
    """Return how centres of mass move, along principal axes; the base can only be the first of the links.

    Returns:
        Position (m), orientation (x, y, z, w), linear (m/s) and angular velocity (rad/s), for each link.
    """
    found = []
    if links[0] == BASE:
        place, turn = bullet.getBasePositionAndOrientation(multibody, client)
        linear, angular = bullet.getBaseVelocity(multibody, client)
        found, links = [(*place, *turn, *linear, *angular)], links[1:]
    states = bullet.getLinkStates(multibody, links, 1, 1, client) if links else ()
    return found + [(*each[0], *each[1], *each[6], *each[7]) for each in states]
