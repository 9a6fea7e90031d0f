"""Muscles, which PyBullet does not have: their forces are set before each step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, sqrt
from typing import Any

import numpy as np

from nrp_core._support.arrays import BoolArray, FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core._support.small_matrices import product
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.merged_bodies import Body, body_of, tree_of
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import BodyPath, JointStates, Pose
from nrp_core.world.drives.muscles import Muscle, ViaPoint, muscles_of
from nrp_core.world.engine_kit.muscles import (
    ACTIVATION,
    LENGTH,
    TENSION,
    VELOCITY,
    activate,
    exert,
    parameters_of,
)
from nrp_core.world.engine_kit.wrapping import WrappingMuscles
from nrp_world_pybullet.build import BodyHandle, Built
from nrp_world_pybullet.inertia import rotate
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import motions_of

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MOTION = 13
"""Position, orientation (x, y, z, w), linear and angular velocity of a body's centre of mass."""


@jit
def locate(motions: FloatArray, carriers: IntArray, points: FloatArray, places: FloatArray) -> None:
    """Compute the positions and velocities of the points of paths.

    Args:
        motions: of the bodies, shape ``(b, 13)``.
        carriers: the body of each point, shape ``(k,)``.
        points: the points in the frames of their bodies, m, shape ``(k, 3)``.
        places: receives positions (m), velocities (m/s) and arms from the centres of mass (m), ``(k, 9)``.
    """
    for k in range(len(points)):
        motion, place = motions[carriers[k]], places[k]
        arm = place[6:]
        rotate(motion, points[k], arm)
        for i in range(3):
            place[i] = motion[i] + arm[i]
        place[3] = motion[7] + motion[11] * arm[2] - motion[12] * arm[1]
        place[4] = motion[8] + motion[12] * arm[0] - motion[10] * arm[2]
        place[5] = motion[9] + motion[10] * arm[1] - motion[11] * arm[0]


@jit
def measure(places: FloatArray, ends: IntArray, states: FloatArray) -> None:
    """Compute lengths and velocities of muscles along straight lines; those without points are left.

    Args:
        places: of the points, as :func:`locate` computes them.
        ends: index of the first point of each muscle and after its last, shape ``(n, 2)``.
        states: the states of the muscles, shape ``(4, n)``.
    """
    for n in range(len(ends)):
        if ends[n, 0] == ends[n, 1]:
            continue
        length, velocity = 0.0, 0.0
        for k in range(ends[n, 0], ends[n, 1] - 1):
            segment, closing = 0.0, 0.0
            for i in range(3):
                d = places[k + 1, i] - places[k, i]
                segment += d * d
                closing += d * (places[k + 1, 3 + i] - places[k, 3 + i])
            segment = sqrt(segment)
            length += segment
            velocity += closing / segment if segment > 0.0 else 0.0
        states[LENGTH, n], states[VELOCITY, n] = length, velocity


@jit
def pull(
    places: FloatArray,
    carriers: IntArray,
    ends: IntArray,
    tensions: FloatArray,
    wrenches: FloatArray,
) -> None:
    """Compute the wrenches on bodies of muscles along straight lines.

    Args:
        places: of the points, as :func:`locate` computes them.
        carriers: the body of each point, shape ``(k,)``.
        ends: index of the first point of each muscle and after its last, shape ``(n, 2)``.
        tensions: of the muscles, N, shape ``(n,)``.
        wrenches: receives forces and torques at the frames of the bodies, N and N m, shape ``(b, 6)``.
    """
    wrenches[:] = 0.0
    for n in range(len(ends)):
        for k in range(ends[n, 0], ends[n, 1] - 1):
            segment = 0.0
            for i in range(3):
                segment += (places[k + 1, i] - places[k, i]) ** 2
            share = tensions[n] / sqrt(segment) if segment > 0.0 else 0.0
            for end in range(2):
                at, sign = k + end, share * (1 - 2 * end)
                arm, wrench = places[at, 6:], wrenches[carriers[at]]
                fx = sign * (places[k + 1, 0] - places[k, 0])
                fy = sign * (places[k + 1, 1] - places[k, 1])
                fz = sign * (places[k + 1, 2] - places[k, 2])
                wrench[0] += fx
                wrench[1] += fy
                wrench[2] += fz
                wrench[3] += arm[1] * fz - arm[2] * fy
                wrench[4] += arm[2] * fx - arm[0] * fz
                wrench[5] += arm[0] * fy - arm[1] * fx


@jit
def find_moments(
    motions: FloatArray,
    places: FloatArray,
    carriers: IntArray,
    ends: IntArray,
    levers: FloatArray,
    moved: BoolArray,
    moments: FloatArray,
) -> None:
    """Compute the derivatives of the lengths of muscles by the coordinates of joints.

    Args:
        motions: of the bodies, shape ``(b, 13)``.
        places: of the points, as :func:`locate` computes them.
        carriers: the body of each point, shape ``(k,)``.
        ends: index of the first point of each muscle and after its last, shape ``(n, 2)``.
        levers: of each coordinate the axis and the joint in the inertial frame of its child, the number of
            this body, and 1 if it slides, shape ``(c, 8)``.
        moved: whether a coordinate moves a body, shape ``(c, b)``.
        moments: receives the derivatives, m, or 1 where a joint slides, shape ``(n, c + 1)``; the last column
            remains.
    """
    axis, anchor = np.empty(3), np.empty(3)
    rates = np.empty((len(places), 3))
    for c in range(len(levers)):
        motion, slides = motions[int(levers[c, 6])], levers[c, 7] > 0.0
        rotate(motion, levers[c, :3], axis)
        rotate(motion, levers[c, 3:6], anchor)
        for k in range(len(places)):
            rate, at = rates[k], places[k]
            x, y, z = (
                at[0] - motion[0] - anchor[0],
                at[1] - motion[1] - anchor[1],
                at[2] - motion[2] - anchor[2],
            )
            if not moved[c, carriers[k]]:
                rate[:] = 0.0
            elif slides:
                rate[:] = axis
            else:
                rate[0] = axis[1] * z - axis[2] * y
                rate[1] = axis[2] * x - axis[0] * z
                rate[2] = axis[0] * y - axis[1] * x
        for n in range(len(ends)):
            moments[n, c] = 0.0
            for k in range(ends[n, 0], ends[n, 1] - 1):
                segment, closing = 0.0, 0.0
                for i in range(3):
                    d = places[k + 1, i] - places[k, i]
                    segment += d * d
                    closing += d * (rates[k + 1, i] - rates[k, i])
                moments[n, c] += closing / sqrt(segment) if segment > 0.0 else 0.0


class Muscles:
    """The muscles of a scene; those that wrap act on joints, all others on bodies.

    Before each physics step the engine calls :meth:`push`. When bodies have moved in another way, it calls
    :meth:`forget`.

    Args:
        scene: the scene.
        built: its handles.
        client: the physics client.
        step_s: the physics step, s.
    """

    def __init__(self, scene: Scene, built: Built, client: int, step_s: float) -> None:
        self._client, self._step_s, self._pulled = client, step_s, False
        bodies = {model: [body for body, _ in each] for model, each in built.bodies.items()}
        muscles = [(model, muscle) for model in scene.models for muscle in muscles_of(model)]
        self._numbers = {(model.name, muscle.name): n for n, (model, muscle) in enumerate(muscles)}
        places = [
            _place(model, bodies[model.name], point.link, point.position)
            for model, muscle in muscles
            for point in _path(muscle)
        ]
        pulled = list(dict.fromkeys(body for body, _ in places if body is not None))
        wrapped = {model.name for model, muscle in muscles if muscle.wraps}
        trees = {
            model: _trees(model, bodies[model], pulled, whole=model in wrapped)
            for model in dict.fromkeys([*(model for model, _ in pulled), *wrapped])
        }
        jointed = [(model, child) for model, found in trees.items() for child in found]
        carriers = list(dict.fromkeys((*pulled, *jointed)))
        rows = {body: row for row, body in enumerate(carriers)}
        last = len(carriers)  # the row of all that is fixed to the world
        levers: list[list[float]] = []
        movable: list[list[bool]] = []
        self._columns: dict[tuple[str, str], int] = {}
        for model, found in trees.items():
            for child, below in found.items():
                for name, lever in _levers(bodies[model][child], rows[model, child]):
                    self._columns[model, name] = len(levers)
                    levers.append(lever)
                    movable.append([owner == model and each in below for owner, each in carriers])
        self._levers = np.array(levers, float).reshape(-1, 8)
        self._moved = np.array([[*each, False] for each in movable], bool).reshape(-1, last + 1)
        self._coordinates = {
            model: [name for owner, name in self._columns if owner == model] for model in trees
        }
        self._rows = np.array([rows[body] if body else last for body, _ in places], np.int64)
        self._points = np.array([point for _, point in places], float).reshape(-1, 3)
        after = np.cumsum([0, *(len(_path(muscle)) for _, muscle in muscles)])
        self._ends = np.stack([after[:-1], after[1:]], axis=1)
        self._parameters = parameters_of(muscle for _, muscle in muscles)
        self._motions = np.zeros((last + 1, MOTION))
        self._motions[last, 6] = 1.0
        self._wrenches, self._spots = np.zeros((last + 1, 6)), np.zeros((len(places), 9))
        self._controls, self._states = np.zeros(len(muscles)), np.zeros((4, len(muscles)))
        self._slopes, self._moments = np.zeros(len(muscles)), np.zeros((len(muscles), len(levers) + 1))
        self._last: FloatArray | None = None  # efforts in the last step, shape (c + 1,)
        self._groups: dict[tuple[str, tuple[str, ...]], IntArray] = {}
        self._places = [built.bodies[model][index][1] for model, index in carriers]
        self._links: dict[int, tuple[list[int], list[int]]] = {}  # rows and links of each multi-body
        for row, place in sorted(enumerate(self._places), key=lambda each: each[1].link):  # the base first
            held, links = self._links.setdefault(place.multibody, ([], []))
            held.append(row)
            links.append(place.link)

        self._wrapping = [self._wrap(model, built) for model in scene.models if model.name in wrapped]

    def _wrap(self, model: Model, built: Built) -> tuple[WrappingMuscles, _JointTable, IntArray, IntArray]:
        """Return the muscles of a model that wrap, their joints, numbers and those of coordinates."""
        import mujoco

        joints = {name: built.joints[model.name][name] for name in self._coordinates[model.name]}
        columns = np.array([self._columns[model.name, name] for name in joints], np.int64)
        muscles = WrappingMuscles(mujoco, "PyBullet", model, [*joints])
        numbers = np.array([self._numbers[model.name, name] for name in muscles.names], np.int64)
        return muscles, _JointTable([*joints.values()], self._client), numbers, columns

    def __bool__(self) -> bool:
        return bool(self._numbers)

    def is_finite(self) -> bool:
        """Return whether the states of all muscles are finite."""
        return isfinite(self._states.sum())

    def push(self) -> None:
        """Apply the forces of the next step, and advance the activations."""
        self._pull()
        self._last = -product(self._states[TENSION], self._moments)
        activate(self._controls, self._parameters, self._states, self._step_s)
        self._pulled = False
        client, frame = self._client, bullet.WORLD_FRAME
        wrenches, motions = self._wrenches[:-1].tolist(), self._motions  # at which they were computed
        for place, wrench, at in zip(self._places, wrenches, motions[:-1, :3].tolist(), strict=True):
            where = place.multibody, place.link
            bullet.applyExternalForce(*where, wrench[:3], at, frame, physicsClientId=client)
            bullet.applyExternalTorque(*where, wrench[3:], frame, physicsClientId=client)

    def forget(self) -> None:
        """Forget the motions of the bodies, because they were moved."""
        self._pulled = False

    def _pull(self) -> None:
        if self._pulled:
            return
        self._read(self._motions[:-1])
        motions, places, rows, ends = self._motions, self._spots, self._rows, self._ends
        locate(motions, rows, self._points, places)
        measure(places, ends, self._states)
        find_moments(motions, places, rows, ends, self._levers, self._moved, self._moments)
        for muscles, joints, numbers, columns in self._wrapping:
            lengths, velocities, moments = muscles.find(*joints.read())
            self._states[LENGTH, numbers], self._states[VELOCITY, numbers] = lengths, velocities
            self._moments[np.ix_(numbers, columns)] = moments
        exert(self._parameters, self._states, self._slopes)
        pull(places, rows, ends, self._states[TENSION], self._wrenches)
        self._pulled = True

    def pull_at_world(self, model: str) -> bool:
        """Return whether a muscle of a model has a point that does not move."""
        last = len(self._motions) - 1
        own = [self._ends[n] for (owner, _), n in self._numbers.items() if owner == model]
        return any(last in self._rows[start:end] for start, end in own)

    def columns(self, paths: Sequence[tuple[str, str]]) -> IntArray | None:
        """Return the numbers of coordinates for :meth:`loads`; None if muscles move none of them."""
        if not any(path in self._columns for path in paths):
            return None
        return np.array([self._columns.get(path, len(self._columns)) for path in paths], np.int64)

    def loads(self, columns: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the efforts of muscles at coordinates in the next step, and the damping that they have.

        The damping is the derivative of the efforts by the velocities, without its sign.

        Returns:
            Efforts, N m or N, shape ``(n,)``, and damping, shape ``(n, n)``.
        """
        self._pull()
        moments = self._moments[:, columns]
        return -product(self._states[TENSION], moments), product(moments.T * self._slopes, moments)

    def wrapping_loads(self, columns: IntArray) -> FloatArray | float:
        """Return the efforts at coordinates of those muscles that act on joints, after :meth:`loads`."""
        efforts: FloatArray | float = 0.0
        for _, _, numbers, _ in self._wrapping:
            efforts = efforts - product(
                self._states[TENSION, numbers], self._moments[np.ix_(numbers, columns)]
            )
        return efforts

    def _read(self, motions: FloatArray) -> None:
        """Write the motions of the bodies' centres of mass along principal axes."""
        for body, (rows, links) in self._links.items():
            motions[rows] = motions_of(body, links, self._client)

    def set_control(self, model: str, muscle: str, value: float) -> None:
        """Set the control of a muscle."""
        self._controls[self._numbers[model, muscle]] = value

    def set_controls(self, model: str, muscles: Sequence[str], values: FloatArray) -> None:
        """Set the controls of several muscles, shape ``(n,)``."""
        self._controls[self._group(model, tuple(muscles))] = values

    def states(self, model: str, muscles: Sequence[str]) -> FloatArray:
        """Return lengths, velocities, tensions and activations now, shape ``(4, n)``."""
        self._pull()
        return self._states[:, self._group(model, tuple(muscles))]

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the muscles in the last step to the states of a model's joints."""
        if self._last is None:
            self._pull()
        efforts = -product(self._states[TENSION], self._moments) if self._last is None else self._last
        for name in self._coordinates.get(model, ()):
            states.efforts[states.names.index(name)] += efforts[self._columns[model, name]]

    def _group(self, model: str, muscles: tuple[str, ...]) -> IntArray:
        """Return the numbers of muscles."""
        path = model, muscles
        if path not in self._groups:
            self._groups[path] = np.array([self._numbers[model, muscle] for muscle in muscles], np.int64)
        return self._groups[path]

    def save(self) -> object:
        """Return controls and activations."""
        return self._controls.copy(), self._states[ACTIVATION].copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._controls[:], self._states[ACTIVATION] = saved
        self.forget()


class _JointTable:
    """The positions and velocities of joints, read in one call for each multi-body.

    Args:
        joints: their handles.
        client: the physics client.
    """

    def __init__(self, joints: Sequence[BodyHandle], client: int) -> None:
        self._client, self._trees = client, dict[int, list[int]]()
        for place in joints:
            self._trees.setdefault(place.multibody, []).append(place.link)
        read = [(body, link) for body, links in self._trees.items() for link in links]
        self._order = np.array([read.index((place.multibody, place.link)) for place in joints], int)

    def read(self) -> FloatArray:
        """Return positions and velocities, shape ``(2, n)``."""
        rows = [
            state[:2]
            for body, links in self._trees.items()
            for state in bullet.getJointStates(body, links, self._client)
        ]
        found: FloatArray = np.array(rows, float).reshape(-1, 2)[self._order].T
        return found


def _place(
    model: Model, bodies: Sequence[Body], link: str, point: tuple[float, float, float]
) -> tuple[BodyPath | None, tuple[float, float, float]]:
    """Return the body of a point and where it is in the body's inertial frame, in the world's if fixed."""
    if link == WORLD:
        return None, (model.pose @ Pose(point)).position
    index = body_of(bodies, link)
    body = bodies[index]
    held = next(each.pose for each in body.links if each.name == link) @ Pose(point)
    if body.inertial is None:
        return None, (body.pose @ held).position
    return (model.name, index), (body.inertial.pose.inverse() @ held).position


def _path(muscle: Muscle) -> Sequence[ViaPoint]:
    """Return the path of a muscle along straight lines; empty if it wraps."""
    return () if muscle.wraps else muscle.path


def _trees(
    model: str, bodies: Sequence[Body], pulled: Sequence[BodyPath], *, whole: bool
) -> dict[int, list[int]]:
    """Return the bodies whose joints muscles can move, each with the pulled ones among its descendants.

    Muscles that wrap can move the whole of a model.
    """
    trees = {}
    for child, body in enumerate(bodies):
        if body.joint is not None and body.joint.coordinates and body.inertial is not None:
            trees[child] = [each for each in tree_of(child, bodies) if (model, each) in pulled]
    return {child: moved for child, moved in trees.items() if moved or whole}


def _levers(body: Body, row: int) -> Iterator[tuple[str, list[float]]]:
    """Yield the coordinates of a body's joint, each with its lever for :func:`find_moments`."""
    joint, inertial = body.joint, body.inertial
    assert joint is not None
    assert inertial is not None
    back = inertial.pose.inverse()
    axes = (X, Y, Z) if joint.kind == "ball" else (joint.axis,)
    for name, axis in zip(joint.coordinates, axes, strict=True):
        yield name, [*back.rotate(axis), *back.position, row, float(joint.kind == "prismatic")]
