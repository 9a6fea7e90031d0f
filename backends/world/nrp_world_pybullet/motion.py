"""Poses and velocities of models, states of their joints, and the joint-space inertia of a model."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from math import isfinite
from operator import itemgetter, mul
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.quiet import quiet
from nrp_core._support.small_matrices import product
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Inertial
from nrp_core.scene.rigid import (
    JointStates,
    ModelMotion,
    Pose,
    Quaternion,
    Vector,
    rotation_matrix,
    rotation_vector,
)
from nrp_core.world.engine import MOST_RATE
from nrp_core.world.engine_kit.elimination import solve
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
        offset = self._offset
        frame: tuple[Vector, Quaternion]
        frame = bullet.multiplyTransforms(
            *self._inertial(), offset.position, offset.orientation, self._client
        )
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


_FREE = 6


class Inertia:
    """The inertia of one multi-body.

    Args:
        bodies: all bodies of a model with their handles.
        multibody: the multi-body among them.
        client: the physics client.

    Attributes:
        related: 1 for two coordinates one of which moves the other's body, else 0, shape ``(n, n)``.
    """

    def __init__(self, bodies: Sequence[tuple[Body, BodyHandle]], multibody: int, client: int) -> None:
        self._multibody, self._client = multibody, client
        own = [(n, body, place) for n, (body, place) in enumerate(bodies) if place.multibody == multibody]
        own.sort(key=lambda each: each[2].link)
        joints = [body.joint for _, body, _ in own if body.joint is not None]
        self._base = _FREE if own[0][1].floats else 0
        chains = [(n, {*_above(bodies, n)}) for n, body, _ in own for _ in _coordinates(body)]
        self.related = np.array(
            [[n in above or m in line for m, above in chains] for n, line in chains], float
        )
        self._moving = _Moving(bodies, own, client) if any(j.kind == "ball" for j in joints) else None
        if self._moving is None:
            with quiet():  # PyBullet prints of each axis that it rounded, when it first computes with it
                try:
                    self._matrix(np.zeros(sum(len(joint.coordinates) for joint in joints)))
                except SystemError:  # it refuses the tensor of a heavy body if rounding made it unsymmetric
                    self._moving = _Moving(bodies, own, client)

    def now(self, positions: FloatArray) -> FloatArray:
        """Return the joint-space inertia with a free base, shape ``(n, n)``.

        Args:
            positions: positions of the joints; not used with ball joints.
        """
        mass = self._moving.mass() if self._moving is not None else self._matrix(positions)
        n = self._base
        inertia: FloatArray = mass[n:, n:]
        if n:  # the motion of the free base
            inertia = inertia - product(mass[n:, :n], solve(mass[:n, :n], mass[:n, n:]))
        return inertia

    def bias(self, positions: FloatArray, velocities: FloatArray) -> FloatArray | None:
        """Return the efforts with which the joints do not accelerate, against gravity and velocities.

        Returns:
            Efforts, N m or N, shape ``(n,)``; None with a free base or ball joints.
        """
        if self._base or self._moving is not None:
            return None
        state = positions.tolist(), velocities.tolist(), [0.0] * len(positions)
        return np.array(
            bullet.calculateInverseDynamics(self._multibody, *state, physicsClientId=self._client)
        )

    def _matrix(self, positions: FloatArray) -> FloatArray:
        """Return PyBullet's own mass matrix."""
        place = self._multibody
        return np.array(bullet.calculateMassMatrix(place, positions.tolist(), physicsClientId=self._client))


class _Moving:
    """The mass matrix of a multi-body from its bodies' motions.

    Args:
        bodies: all bodies of a model with their handles.
        own: number, body and handle of the bodies of the multi-body, in PyBullet's order.
        client: the physics client.
    """

    def __init__(
        self,
        bodies: Sequence[tuple[Body, BodyHandle]],
        own: Sequence[tuple[int, Body, BodyHandle]],
        client: int,
    ) -> None:
        heavy = [(number, body, place) for number, body, place in own if not body.fixed]
        self._frames = [moving(body, place, Pose(), client).place for _, body, place in heavy]
        inertials = [body.inertial or Inertial(0.0) for _, body, _ in heavy]
        self._masses = np.array([inertial.mass for inertial in inertials])
        self._moments = np.array([np.diag(inertial.inertia[:3]) for inertial in inertials])
        self._centres = np.array([inertial.pose.position for inertial in inertials])
        self._axes = np.array([rotation_matrix(inertial.pose.orientation) for inertial in inertials])
        ways = [(k, *way) for k, (_, body, _) in enumerate(heavy) for way in _ways(body)]
        self._bodies = np.array([k for k, _, _ in ways])
        self._along = np.array([axis for _, axis, _ in ways])
        self._slides = np.array([slides for _, _, slides in ways])[:, None, None]
        above = [set(_above(bodies, number)) for number, _, _ in heavy]
        carried = [[heavy[k][0] in each for each in above] for k in self._bodies]
        self._carried = np.array(carried, dtype=float)[:, :, None]

    def mass(self) -> FloatArray:
        """Return the mass matrix; its first rows are the base's motion along and about its own axes."""
        frames = [frame() for frame in self._frames]
        turns = np.array([rotation_matrix(orientation) for _, orientation in frames])
        origins = np.array([position for position, _ in frames])
        centres = origins + np.einsum("kij,kj->ki", turns, self._centres)
        axes = product(turns, self._axes)
        moments = product(product(axes, self._moments), axes.transpose(0, 2, 1))
        along = np.einsum("dij,dj->di", turns[self._bodies], self._along)[:, None, :]
        levers = centres[None] - origins[self._bodies][:, None]
        linear = self._carried * np.where(self._slides, along, np.cross(along, levers))
        angular = self._carried * np.where(self._slides, 0.0, along)
        mass: FloatArray = np.einsum("dki,k,eki->de", linear, self._masses, linear)
        mass += np.einsum("dki,kij,ekj->de", angular, moments, angular)
        return mass


def _ways(body: Body) -> list[tuple[tuple[float, ...], bool]]:
    """Return the degrees of freedom of a body relative to its parent: each axis, and whether it slides."""
    units = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    if body.joint is None:
        return [(axis, slides) for slides in (True, False) for axis in units]
    if body.joint.kind == "ball":
        return [(axis, False) for axis in units]
    return [(body.joint.axis, body.joint.kind == "prismatic") for _ in body.joint.coordinates]


def _coordinates(body: Body) -> Sequence[str]:
    return () if body.joint is None else body.joint.coordinates


def _above(bodies: Sequence[tuple[Body, BodyHandle]], number: int) -> list[int]:
    """Return the numbers of a body and of all its ancestors."""
    chain = [number]
    while (parent := bodies[chain[-1]][0].parent) is not None:
        chain.append(parent)
    return chain
