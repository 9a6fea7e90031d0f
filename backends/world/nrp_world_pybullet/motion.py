"""Poses and velocities of models, and states of their joints."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from math import isfinite

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid.motion import JointStates, ModelMotion
from nrp_core.world.rigid.pose import Pose, Quaternion, Vector, rotation_vector
from nrp_core.world.scene.merged_bodies import Body
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
        offset = self._offset
        frame: tuple[Vector, Quaternion]
        frame = bullet.multiplyTransforms(
            *self._inertial(), offset.position, offset.orientation, self._client
        )
        return frame

    def finite(self) -> bool:
        """Return whether the pose of the frame is finite; faster than the pose."""
        x, y, z = self._inertial()[0]
        return isfinite(x) and isfinite(y) and isfinite(z)

    def _inertial(self) -> tuple[Vector, Quaternion]:
        body, link, client = self._place.multibody, self._place.link, self._client
        if link == BASE:
            return bullet.getBasePositionAndOrientation(body, client)  # type: ignore[no-any-return]
        return bullet.getLinkState(body, link, 0, 1, client)[:2]  # type: ignore[no-any-return]

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
        self._last: FloatArray | None = None

    def forget(self) -> None:
        """Read them again, since they have moved."""
        self._last = None

    def finite(self) -> bool:
        """Return whether all positions are finite numbers."""
        return all(map(isfinite, self._now()[0].tolist()))

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
            self._last = np.array(list(self._rows())).reshape(-1, 3).T
        return self._last

    def _rows(self) -> Iterator[tuple[float, float, float]]:
        """Yield position, velocity and effort of each coordinate."""
        if self._tree is not None:
            for position, velocity, _, effort in bullet.getJointStates(self._tree, self._links, self._client):
                yield position, velocity, effort
            return
        for place in self._places:
            where = place.multibody, place.link
            if place.axis is None:
                position, velocity, _, effort = bullet.getJointState(*where, self._client)
                yield position, velocity, effort
            elif place.axis == 0:
                turn, velocities, _, efforts = bullet.getJointStateMultiDof(*where, self._client)
                yield from zip(rotation_vector(turn), velocities, efforts, strict=True)
