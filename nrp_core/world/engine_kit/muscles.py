"""Muscles along straight lines, for engines that apply wrenches to bodies.

The equations are those of MuJoCo (``engine_util_misc.c``), so that a muscle is the same in all engines.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.drives.muscles import muscles_of
from nrp_core.world.rigid import BodyPath, JointStates, Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.merged_bodies import Body, body_of, tree_of
from nrp_core.world.scene.model import Model, Scene

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MOTION = 13
"""Position, orientation (x, y, z, w), linear and angular velocity of a body's centre of mass."""
LENGTH, VELOCITY, TENSION, ACTIVATION = range(4)
_FORCE, _OPTIMAL, _SLACK, _LMIN, _LMAX, _VMAX, _FPMAX, _FVMAX, _RISE, _FALL, _SMOOTH = range(11)
_PARAMETERS = ("force", "optimal_length", "slack_length", "lmin", "lmax", "vmax", "fpmax", "fvmax",
               "activation_s", "deactivation_s", "smoothing")  # fmt: skip


@inlined
def force_length(length: float, lmin: float, lmax: float) -> float:
    """Return the active force at a normalised length, a share of the peak force."""
    if length < lmin or length > lmax:
        return 0.0
    a, b = 0.5 * (lmin + 1.0), 0.5 * (1.0 + lmax)
    if length <= a:
        x = (length - lmin) / (a - lmin)
        return 0.5 * x * x
    if length <= 1.0:
        x = (1.0 - length) / (1.0 - a)
        return 1.0 - 0.5 * x * x
    if length <= b:
        x = (length - 1.0) / (b - 1.0)
        return 1.0 - 0.5 * x * x
    x = (lmax - length) / (lmax - b)
    return 0.5 * x * x


@inlined
def force_velocity(velocity: float, fvmax: float) -> float:
    """Return the factor of the active force at a normalised velocity."""
    y = fvmax - 1.0
    if velocity <= -1.0:
        return 0.0
    if velocity <= 0.0:
        return (velocity + 1.0) * (velocity + 1.0)
    if velocity <= y:
        return fvmax - (y - velocity) * (y - velocity) / y
    return fvmax


@inlined
def passive_force(length: float, lmax: float, fpmax: float) -> float:
    """Return the passive force at a normalised length, a share of the peak force."""
    b = 0.5 * (1.0 + lmax)
    if length <= 1.0:
        return 0.0
    if length <= b:
        x = (length - 1.0) / (b - 1.0)
        return 0.5 * fpmax * x * x
    return fpmax * (0.5 + (length - b) / (b - 1.0))


@inlined
def activation_rate(control: float, activation: float, rise: float, fall: float, smooth: float) -> float:
    """Return the derivative of an activation, 1/s."""
    excitation = min(max(control, 0.0), 1.0)
    factor = 0.5 + 1.5 * min(max(activation, 0.0), 1.0)
    difference = excitation - activation
    up, down = rise * factor, fall / factor
    if smooth > 0.0:
        x = min(max(difference / smooth + 0.5, 0.0), 1.0)
        constant = down + (up - down) * x * x * x * (3.0 * x * (2.0 * x - 5.0) + 10.0)
    else:
        constant = up if difference > 0.0 else down
    return difference / constant


@inlined
def _rotated(q: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Rotate a vector by the quaternion in a motion."""
    x, y, z, w = q[3], q[4], q[5], q[6]
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    out[0] = v[0] + w * tx + y * tz - z * ty
    out[1] = v[1] + w * ty + z * tx - x * tz
    out[2] = v[2] + w * tz + x * ty - y * tx


@jit
def pull(
    motions: FloatArray,
    carriers: IntArray,
    points: FloatArray,
    ends: IntArray,
    parameters: FloatArray,
    states: FloatArray,
    wrenches: FloatArray,
) -> None:
    """Compute lengths, velocities and tensions of muscles, and their wrenches on bodies.

    Args:
        motions: of the bodies, shape ``(b, 13)``.
        carriers: the body of each point, shape ``(k,)``.
        points: the points in the frames of their bodies, m, shape ``(k, 3)``.
        ends: index of the first point of each muscle and after its last, shape ``(n, 2)``.
        parameters: of each muscle, shape ``(n, 11)``.
        states: the states of the muscles, shape ``(4, n)``; of these the activations are read.
        wrenches: receives forces and torques at the frames of the bodies, N and N m, shape ``(b, 6)``.
    """
    wrenches[:] = 0.0
    arms, places, rates = np.empty_like(points), np.empty_like(points), np.empty_like(points)
    for k in range(len(points)):
        motion, arm = motions[carriers[k]], arms[k]
        _rotated(motion, points[k], arm)
        for i in range(3):
            places[k, i] = motion[i] + arm[i]
        rates[k, 0] = motion[7] + motion[11] * arm[2] - motion[12] * arm[1]
        rates[k, 1] = motion[8] + motion[12] * arm[0] - motion[10] * arm[2]
        rates[k, 2] = motion[9] + motion[10] * arm[1] - motion[11] * arm[0]
    for n in range(len(ends)):
        length, velocity = 0.0, 0.0
        for k in range(ends[n, 0], ends[n, 1] - 1):
            segment, closing = 0.0, 0.0
            for i in range(3):
                d = places[k + 1, i] - places[k, i]
                segment += d * d
                closing += d * (rates[k + 1, i] - rates[k, i])
            segment = sqrt(segment)
            length += segment
            velocity += closing / segment if segment > 0.0 else 0.0
        p = parameters[n]
        relative = (length - p[_SLACK]) / p[_OPTIMAL]
        active = force_length(relative, p[_LMIN], p[_LMAX])
        active *= force_velocity(velocity / (p[_OPTIMAL] * p[_VMAX]), p[_FVMAX]) * states[ACTIVATION, n]
        tension = p[_FORCE] * (active + passive_force(relative, p[_LMAX], p[_FPMAX]))
        states[LENGTH, n], states[VELOCITY, n], states[TENSION, n] = length, velocity, tension
        for k in range(ends[n, 0], ends[n, 1] - 1):
            segment = 0.0
            for i in range(3):
                segment += (places[k + 1, i] - places[k, i]) ** 2
            share = tension / sqrt(segment) if segment > 0.0 else 0.0
            for end in range(2):
                at, sign = k + end, share * (1 - 2 * end)
                arm, wrench = arms[at], wrenches[carriers[at]]
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
def activate(controls: FloatArray, parameters: FloatArray, states: FloatArray, step_s: float) -> None:
    """Advance the activations by a step of Euler's method, as MuJoCo does.

    Args:
        controls: of the muscles, shape ``(n,)``.
        parameters: of each muscle, shape ``(n, 11)``.
        states: the states of the muscles, shape ``(4, n)``.
        step_s: the step, s.
    """
    for n in range(len(controls)):
        p, now = parameters[n], states[ACTIVATION, n]
        states[ACTIVATION, n] += step_s * activation_rate(controls[n], now, p[_RISE], p[_FALL], p[_SMOOTH])


@dataclass(frozen=True, slots=True)
class _Lever:
    """A joint that muscles can move.

    Args:
        names: its coordinates.
        child: the row of its child in the motions.
        anchor: the joint in the inertial frame of the child, shape ``(3,)``.
        axes: its axes there, shape ``(n, 3)``.
        slides: whether it is prismatic.
        moved: the rows of the bodies that it moves and muscles pull at.
    """

    names: tuple[str, ...]
    child: int
    anchor: FloatArray
    axes: FloatArray
    slides: bool
    moved: list[int]

    def efforts(self, motions: FloatArray, wrenches: FloatArray) -> FloatArray:
        """Return the efforts of wrenches on bodies along the axes, N m or N, shape ``(n,)``."""
        motion, at = motions[self.child], np.empty(3)
        axes = np.empty_like(self.axes)
        for axis, turned in zip(self.axes, axes, strict=True):
            _rotated(motion, axis, turned)
        forces = wrenches[self.moved, :3]
        if self.slides:
            total = forces.sum(axis=0)
        else:
            _rotated(motion, self.anchor, at)
            arms = motions[self.moved, :3] - (motion[:3] + at)
            total = (np.cross(arms, forces) + wrenches[self.moved, 3:]).sum(axis=0)
        efforts: FloatArray = axes @ total
        return efforts


class ViaPointMuscles(ABC):
    """The muscles of a scene, for an engine that reads motions of bodies and applies wrenches to them.

    Before each physics step the engine calls :meth:`step`, and applies the wrenches for one step. When bodies
    have moved in another way, it calls :meth:`forget`.

    Args:
        scene: the scene; its muscles go along straight lines.
        bodies: the bodies of each model.
        step_s: the physics step, s.

    Attributes:
        carriers: the bodies that muscles pull at and that can move.
    """

    def __init__(self, scene: Scene, bodies: Mapping[str, Sequence[Body]], step_s: float) -> None:
        self._step_s, self._pulled = step_s, False
        muscles = [(model, muscle) for model in scene.models for muscle in muscles_of(model)]
        self._numbers = {(model.name, muscle.name): n for n, (model, muscle) in enumerate(muscles)}
        places = [
            _place(model, bodies[model.name], point.link, point.position)
            for model, muscle in muscles
            for point in muscle.path
        ]
        pulled = list(dict.fromkeys(body for body, _ in places if body is not None))
        trees = {model: _trees(model, bodies[model], pulled) for model in {model for model, _ in pulled}}
        jointed = [(model, child) for model, found in trees.items() for child in found]
        self.carriers = list(dict.fromkeys((*pulled, *jointed)))
        rows = {body: row for row, body in enumerate(self.carriers)}
        self._levers = {
            model: [
                _lever(bodies[model][child], rows[model, child], [rows[model, each] for each in moved])
                for child, moved in found.items()
            ]
            for model, found in trees.items()
        }
        last = len(self.carriers)  # the row of all that is fixed to the world
        self._rows = np.array([rows[body] if body else last for body, _ in places], np.int64)
        self._points = np.array([point for _, point in places], float).reshape(-1, 3)
        after = np.cumsum([0, *(len(muscle.path) for _, muscle in muscles)])
        self._ends = np.stack([after[:-1], after[1:]], axis=1)
        numbers = [[getattr(muscle, name) for name in _PARAMETERS] for _, muscle in muscles]
        self._parameters = np.array(numbers, float).reshape(-1, len(_PARAMETERS))
        self._motions = np.zeros((last + 1, MOTION))
        self._motions[last, 6] = 1.0
        self._wrenches = np.zeros((last + 1, 6))
        self._last: tuple[FloatArray, FloatArray] | None = None  # motions and wrenches of the last step
        self._controls, self._states = np.zeros(len(muscles)), np.zeros((4, len(muscles)))
        self._groups: dict[tuple[str, tuple[str, ...]], IntArray] = {}

    def __bool__(self) -> bool:
        return bool(self._numbers)

    def step(self) -> FloatArray:
        """Return the wrenches on :attr:`carriers` in the next step, and advance the activations.

        Returns:
            Forces (N) and torques (N m) at the centres of mass along the world's axes, shape ``(b, 6)``.
        """
        self._pull()
        self._last = self._motions.copy(), self._wrenches.copy()
        activate(self._controls, self._parameters, self._states, self._step_s)
        self._pulled = False
        return self._wrenches[:-1]

    def forget(self) -> None:
        """Forget the motions of the bodies, because they were moved."""
        self._pulled = False

    def _pull(self) -> None:
        if self._pulled:
            return
        self._read(self._motions[:-1])
        pull(self._motions, self._rows, self._points, self._ends, self._parameters, self._states,
             self._wrenches)  # fmt: skip
        self._pulled = True

    @abstractmethod
    def _read(self, motions: FloatArray) -> None:
        """Write the motions of :attr:`carriers`, of their centres of mass along principal axes."""

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
        levers = self._levers.get(model, ())
        if levers and self._last is None:
            self._pull()
        motions, wrenches = self._last or (self._motions, self._wrenches)
        for lever in levers:
            states.efforts[[states.names.index(name) for name in lever.names]] += lever.efforts(
                motions, wrenches
            )

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


def _trees(model: str, bodies: Sequence[Body], pulled: Sequence[BodyPath]) -> dict[int, list[int]]:
    """Return the bodies whose joints muscles can move, each with the pulled ones among its descendants."""
    trees = {}
    for child, body in enumerate(bodies):
        if body.joint is not None and body.joint.coordinates and body.inertial is not None:
            trees[child] = [each for each in tree_of(child, bodies) if (model, each) in pulled]
    return {child: moved for child, moved in trees.items() if moved}


def _lever(body: Body, child: int, moved: list[int]) -> _Lever:
    joint, inertial = body.joint, body.inertial
    assert joint is not None
    assert inertial is not None
    back = inertial.pose.inverse()
    axes = (X, Y, Z) if joint.kind == "ball" else (joint.axis,)
    turned = np.array([back.rotate(axis) for axis in axes])
    return _Lever(joint.coordinates, child, np.array(back.position), turned, joint.kind == "prismatic", moved)
