"""Where models are, how they move, and how their joints stand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from math import isfinite

import numpy as np

from nrp_core.world.rigid.motion import JointStates, ModelMotion
from nrp_core.world.rigid.pose import Pose, Quaternion, Vector, rotation_vector
from nrp_core.world.scene.merged_bodies import Body
from nrp_world_pybullet.build import BASE, Place
from nrp_world_pybullet.library import bullet

PlaceOf = Callable[[], tuple[Vector, Quaternion]]


def moving(body: Body, place: Place, held: Pose, client: int) -> Moving:
    """Return a frame that is held by a body that moves.

    Args:
        body: the body.
        place: where that is in the engine.
        held: the frame in the body's frame.
        client: the physics client.
    """
    assert body.inertial is not None  # what moves has mass
    return Moving(place, body.inertial.pose.inverse() @ held, client)


def place_of(body: Body, place: Place, held: Pose, client: int) -> PlaceOf:
    """Return what reads where a frame is that is held by a body, moving or not; as :func:`moving`."""
    if not body.fixed:
        return moving(body, place, held, client).place
    still = body.pose @ held
    return lambda: (still.position, still.orientation)


class Moving:
    """A frame that is held at an offset to a body's inertial frame, which is what PyBullet knows.

    Args:
        place: of the body.
        offset: the frame in the inertial frame.
        client: the physics client.
    """

    def __init__(self, place: Place, offset: Pose, client: int) -> None:
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
        """Return where the frame is; quicker than its motion."""
        offset = self._offset
        frame: tuple[Vector, Quaternion]
        frame = bullet.multiplyTransforms(
            *self._inertial(), offset.position, offset.orientation, self._client
        )
        return frame

    def finite(self) -> bool:
        """Tell whether the frame is somewhere; quicker than its place."""
        x, y, z = self._inertial()[0]
        return isfinite(x) and isfinite(y) and isfinite(z)

    def _inertial(self) -> tuple[Vector, Quaternion]:
        body, link, client = self._place.multibody, self._place.link, self._client
        if link == BASE:
            return bullet.getBasePositionAndOrientation(body, client)  # type: ignore[no-any-return]
        return bullet.getLinkState(body, link, 0, 1, client)[:2]  # type: ignore[no-any-return]

    def put(self, motion: ModelMotion) -> None:
        """Put a base where a motion of the frame says and let it move so."""
        there = motion.at(self._back)
        where = there.pose.position, there.pose.orientation
        bullet.resetBasePositionAndOrientation(self._place.multibody, *where, self._client)
        bullet.resetBaseVelocity(self._place.multibody, there.linear, there.angular, self._client)

    def set_velocity(self, motion: ModelMotion) -> None:
        """Let a base move as a motion of the frame says, from where it is."""
        there = motion.at(self._back)
        bullet.resetBaseVelocity(self._place.multibody, there.linear, there.angular, self._client)


class JointReader:
    """Reads the movable joints of one model.

    Args:
        joints: places of the coordinates by name, in the order of the file.
        driven: those of them whose motors PyBullet drives; the motors of others are friction.
        client: the physics client.
    """

    def __init__(self, joints: Mapping[str, Place], driven: Collection[str], client: int) -> None:
        self._names, self._places, self._client = tuple(joints), tuple(joints.values()), client
        self._driven = np.array([float(name in driven) for name in joints])

    def finite(self) -> bool:
        """Tell whether all positions are finite numbers."""
        return all(isfinite(position) for position, _, _ in self._rows())

    def states(self) -> JointStates:
        """Return positions, velocities and efforts; the efforts are those of the last physics step."""
        positions, velocities, efforts = np.array(list(self._rows())).reshape(-1, 3).T
        return JointStates(self._names, positions, velocities, efforts * self._driven)

    def _rows(self) -> Iterator[tuple[float, float, float]]:
        """Yield position, velocity and effort of each coordinate."""
        for place in self._places:
            where = place.multibody, place.link
            if place.axis is None:
                position, velocity, _, effort = bullet.getJointState(*where, self._client)
                yield position, velocity, effort
            elif place.axis == 0:
                turn, velocities, _, efforts = bullet.getJointStateMultiDof(*where, self._client)
                yield from zip(rotation_vector(turn), velocities, efforts, strict=True)
