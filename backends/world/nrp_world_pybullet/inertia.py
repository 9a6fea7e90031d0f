"""The joint-space inertia of a multi-body, and the efforts with which its joints do not accelerate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import dist
from typing import Any

import numpy as np

from nrp_core._support.arrays import BoolArray, FloatArray, IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core._support.quiet import quiet
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Inertial
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world.engine_kit.elimination import remove_first
from nrp_world_pybullet.build import BodyHandle
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import motions_of

_FREE = 6
_UNITS: tuple[Vector, ...] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class Inertia:
    """The inertia of one multi-body.

    Args:
        bodies: all bodies of a model with their handles.
        multibody: the multi-body among them.
        client: the physics client.

    Attributes:
        floats: whether its base floats freely.
        related: 1 for two coordinates one of which moves the other's body, else 0, shape ``(n, n)``.
    """

    def __init__(self, bodies: Sequence[tuple[Body, BodyHandle]], multibody: int, client: int) -> None:
        self._multibody, self._client = multibody, client
        own = [(n, body, place) for n, (body, place) in enumerate(bodies) if place.multibody == multibody]
        own.sort(key=lambda each: each[2].link)
        self.floats = own[0][1].floats
        self._base = _FREE if self.floats else 0
        self._bodies = _Bodies(bodies, own, client)
        self.related = self._bodies.related[self._base :, self._base :].astype(float)
        joints = [body.joint for _, body, _ in own if body.joint is not None]
        self._native = all(joint.kind != "ball" for joint in joints)
        if self._native:
            with quiet():  # PyBullet prints each axis that it rounds when it first uses the axis
                try:
                    self._matrix(np.zeros(sum(len(joint.coordinates) for joint in joints)))
                except SystemError:  # rounding can make the tensor of a heavy body asymmetric
                    self._native = False
        _, turn = bullet.getBasePositionAndOrientation(multibody, client)
        along_base = Pose(orientation=turn).rotate_back(self._bodies.gravity)
        self._level = dist(along_base, self._bodies.gravity) < 1e-9
        """Whether gravity is the same along the axes of the base, for which PyBullet's routine takes it."""

    def now(self, positions: FloatArray) -> FloatArray:
        """Return the joint-space inertia with a free base, shape ``(n, n)``.

        Args:
            positions: positions of the joints; not used with ball joints.
        """
        mass = self._matrix(positions) if self._native else self._bodies.find()[0]
        return remove_first(self._base, mass, np.zeros(len(mass)))[0]

    def dynamics(self, positions: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the inertia, and the efforts with which the joints do not accelerate.

        The efforts act against gravity and velocities, N m or N, shape ``(n,)``; a free base accelerates.
        """
        if self._base or not (self._native and self._level):
            return remove_first(self._base, *self._bodies.find())
        state = positions.tolist(), velocities.tolist(), [0.0] * len(positions)
        bias = bullet.calculateInverseDynamics(self._multibody, *state, physicsClientId=self._client)
        return self._matrix(positions), np.array(bias)

    def _matrix(self, positions: FloatArray) -> FloatArray:
        """Return PyBullet's own mass matrix."""
        place = self._multibody
        return np.array(bullet.calculateMassMatrix(place, positions.tolist(), physicsClientId=self._client))


@inlined
def rotate(motion: FloatArray, v: FloatArray, out: FloatArray, sign: float = 1.0) -> None:
    """Rotate a vector by the quaternion in a motion, or back with a sign of -1."""
    x, y, z, w = sign * motion[3], sign * motion[4], sign * motion[5], motion[6]
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    out[0] = v[0] + w * tx + y * tz - z * ty
    out[1] = v[1] + w * ty + z * tx - x * tz
    out[2] = v[2] + w * tz + x * ty - y * tx


@inlined
def _cross(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@inlined
def _momentum(motion: FloatArray, moments: FloatArray, rate: FloatArray, out: FloatArray) -> None:
    """Compute a body's inertia times a rate."""
    own = np.empty(3)
    rotate(motion, rate, own, -1.0)
    own *= moments
    rotate(motion, own, out)


@jit
def find_dynamics(
    motions: FloatArray,
    mass: FloatArray,
    bias: FloatArray,
    parents: IntArray,
    masses: FloatArray,
    moments: FloatArray,
    anchors: FloatArray,
    gravity: FloatArray,
    owners: IntArray,
    axes: FloatArray,
    slides: BoolArray,
    moved: BoolArray,
) -> None:
    """Compute the mass matrix and the efforts with which no coordinate accelerates.

    By the equations of Newton and Euler for each body, with the accelerations that the velocities cause
    (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 5 and 6, in coordinates of the world).

    Args:
        motions: of the ``k`` bodies, parents first, as :func:`motions_of` returns them, shape ``(k, 13)``.
        mass: receives the mass matrix, shape ``(n, n)``.
        bias: receives the efforts, shape ``(n,)``.
        parents: the parent of each body; -1 if it has none that moves.
        masses: of the bodies, kg.
        moments: their principal moments of inertia, kg m^2, shape ``(k, 3)``.
        anchors: their joints in their inertial frames, m, shape ``(k, 3)``.
        gravity: m/s^2.
        owners: the body that each of ``n`` coordinates moves relative to its parent.
        axes: the axes of the coordinates in the inertial frames of these bodies, shape ``(n, 3)``.
        slides: whether a coordinate slides.
        moved: whether a coordinate moves a body, shape ``(n, k)``.
    """
    count, n = len(motions), len(owners)
    origins, rates, falls = np.empty((count, 3)), np.empty((count, 3)), np.zeros((count, 3))
    swings, forces, torques = np.zeros((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    a, b, c = np.empty(3), np.empty(3), np.empty(3)
    for k in range(count):
        spin, p = motions[k, 10:], parents[k]
        rotate(motions[k], anchors[k], origins[k])
        _cross(spin, origins[k], rates[k])
        rates[k] += motions[k, 7:10]
        origins[k] += motions[k, :3]
        if p >= 0:
            turn = motions[p, 10:]
            _cross(turn, spin, swings[k])
            swings[k] += swings[p]
            arm = origins[k] - origins[p]
            _cross(swings[p], arm, a)
            _cross(turn, arm, b)
            _cross(turn, 2.0 * (rates[k] - rates[p]) - b, c)
            falls[k] = falls[p] + a + c
        lever = motions[k, :3] - origins[k]
        _cross(spin, lever, a)
        _cross(spin, a, b)
        _cross(swings[k], lever, c)
        forces[k] = masses[k] * (falls[k] + b + c - gravity)
        _momentum(motions[k], moments[k], spin, b)
        _cross(spin, b, torques[k])
        _momentum(motions[k], moments[k], swings[k], b)
        torques[k] += b
        _cross(motions[k, :3] - motions[0, :3], forces[k], a)
        torques[k] += a
    along, places = np.empty((n, 3)), np.empty((n, 3))
    for e in range(n):
        rotate(motions[owners[e]], axes[e], along[e])
        places[e] = origins[owners[e]] - motions[0, :3]
        push, twist, load, moment = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
        for k in range(count):
            if not moved[e, k]:
                continue
            centre = motions[k, :3] - motions[0, :3]
            if slides[e]:
                a[:] = along[e]
            else:
                _cross(along[e], centre - places[e], a)
                _momentum(motions[k], moments[k], along[e], c)
                twist += c
            a *= masses[k]
            push += a
            _cross(centre, a, b)
            twist += b
            load += forces[k]
            moment += torques[k]
        bias[e] = _along(along[e], places[e], slides[e], load, moment, a)
        for d in range(e + 1):
            mass[d, e] = mass[e, d] = 0.0
            if moved[d, owners[e]]:
                mass[d, e] = mass[e, d] = _along(along[d], places[d], slides[d], push, twist, a)


@inlined
def _along(
    axis: FloatArray, place: FloatArray, slides: bool, force: FloatArray, torque: FloatArray, own: FloatArray
) -> float:
    """Return the part of a wrench along a coordinate."""
    if slides:
        own[:] = force
    else:
        _cross(place, force, own)
        own -= torque
        own *= -1.0
    return float(axis[0] * own[0] + axis[1] * own[1] + axis[2] * own[2])


class _Bodies:
    """The dynamics of a multi-body from its bodies' motions.

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
        self._client, self._multibody = client, own[0][2].multibody
        self._links = [place.link for *_, place in heavy]
        inertials = [body.inertial or Inertial(0.0) for _, body, _ in heavy]
        backs = [inertial.pose.inverse() for inertial in inertials]
        rows = {number: row for row, (number, *_) in enumerate(heavy)}
        parents = [-1 if body.parent is None else rows.get(body.parent, -1) for _, body, _ in heavy]
        ways = [(row, *way) for row, (_, body, _) in enumerate(heavy) for way in _ways(body)]
        owners = np.array([row for row, *_ in ways], np.int64)
        above = [{rows[each] for each in _above(bodies, number) if each in rows} for number, *_ in heavy]
        moved = np.array([[row in line for line in above] for row, *_ in ways], bool)
        moved = moved.reshape(len(ways), len(heavy))
        engine = bullet.getPhysicsEngineParameters(client)
        self.gravity = tuple(engine[f"gravityAcceleration{axis}"] for axis in "XYZ")
        """m/s^2."""
        self._shape: tuple[Any, ...] = (
            np.array(parents, np.int64),
            np.array([inertial.mass for inertial in inertials]),
            np.array([inertial.inertia[:3] for inertial in inertials], float).reshape(-1, 3),
            np.array([back.position for back in backs], float).reshape(-1, 3),
            np.array(self.gravity),
            owners,
            np.array([backs[row].rotate(axis) for row, axis, _ in ways], float).reshape(-1, 3),
            np.array([sliding for *_, sliding in ways], bool),
            moved,
        )
        self.related: BoolArray = moved[:, owners] | moved[:, owners].T
        """Of two coordinates, whether one moves the other's body."""

    def find(self) -> tuple[FloatArray, FloatArray]:
        """Return the mass matrix and the efforts; the base's motion along and about its own axes is first."""
        n = len(self.related)
        mass, bias = np.empty((n, n)), np.empty(n)
        motions = np.array(motions_of(self._multibody, self._links, self._client), float)
        find_dynamics(motions, mass, bias, *self._shape)
        return mass, bias


def _ways(body: Body) -> Iterator[tuple[Vector, bool]]:
    """Yield the degrees of freedom of a body relative to its parent: each axis, and whether it slides."""
    if body.joint is None:
        yield from ((axis, slides) for slides in (True, False) for axis in _UNITS)
    elif body.joint.kind == "ball":
        yield from ((axis, False) for axis in _UNITS)
    else:
        yield from ((body.joint.axis, body.joint.kind == "prismatic") for _ in body.joint.coordinates)


def _above(bodies: Sequence[tuple[Body, BodyHandle]], number: int) -> list[int]:
    """Return the numbers of a body and of all its ancestors."""
    chain = [number]
    while (parent := bodies[chain[-1]][0].parent) is not None:
        chain.append(parent)
    return chain
