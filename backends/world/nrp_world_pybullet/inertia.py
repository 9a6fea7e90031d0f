"""The joint-space inertia of one multi-body.

PyBullet's own is wrong for ball joints. With these it is computed here from the velocity of each body's
centre of mass and its angular velocity for a unit velocity of one coordinate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.quiet import quiet
from nrp_core.world.rigid.matrices import rotation_matrix
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import Inertial
from nrp_world_pybullet.build import BodyHandle
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import moving

_FREE = 6


class Inertia:
    """The inertia of one multi-body.

    Args:
        bodies: all bodies of a model with their handles.
        multibody: the multi-body among them.
        client: the physics client.
    """

    def __init__(self, bodies: Sequence[tuple[Body, BodyHandle]], multibody: int, client: int) -> None:
        self._multibody, self._client = multibody, client
        own = [(n, body, place) for n, (body, place) in enumerate(bodies) if place.multibody == multibody]
        own.sort(key=lambda each: each[2].link)
        joints = [body.joint for _, body, _ in own if body.joint is not None]
        self._base = _FREE if own[0][1].floats else 0
        self._moving = _Moving(bodies, own, client) if any(j.kind == "ball" for j in joints) else None
        if self._moving is None:
            with quiet():  # PyBullet prints of each axis that it rounded, when it first computes with it
                self._matrix(np.zeros(sum(len(joint.coordinates) for joint in joints)))

    def now(self, positions: FloatArray) -> FloatArray:
        """Return the joint-space inertia with a free base, shape ``(n, n)``.

        Args:
            positions: positions of the joints; not used with ball joints.
        """
        mass = self._moving.mass() if self._moving is not None else self._matrix(positions)
        n = self._base
        inertia: FloatArray = mass[n:, n:]
        if n:  # the motion of the free base
            inertia = inertia - mass[n:, :n] @ np.linalg.solve(mass[:n, :n], mass[:n, n:])
        return inertia

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
        """Return the mass matrix, the base's translation and rotation along its own axes first."""
        frames = [frame() for frame in self._frames]
        turns = np.array([rotation_matrix(orientation) for _, orientation in frames])
        origins = np.array([position for position, _ in frames])
        centres = origins + np.einsum("kij,kj->ki", turns, self._centres)
        axes = turns @ self._axes
        moments = axes @ self._moments @ axes.transpose(0, 2, 1)
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


def _above(bodies: Sequence[tuple[Body, BodyHandle]], number: int) -> list[int]:
    """Return the numbers of a body and of all its ancestors."""
    chain = [number]
    while (parent := bodies[chain[-1]][0].parent) is not None:
        chain.append(parent)
    return chain
