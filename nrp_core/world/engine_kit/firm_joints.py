"""Servos that reach their targets under any load within the limits of their joints.

Joints without gains in their files have them. A target is approached along a path, which is the same in every
engine. In each step a joint gets the velocity that takes it back to this path. An engine makes this velocity
a constraint with a bounded force, and solves it together with contacts. So no load, neither gravity nor a
robot on its wheels, moves the joint off its path, unless it exceeds the joint's limit of effort.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import dist, inf
from types import MappingProxyType
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.scene.merged_bodies import STIFF_TIME_CONSTANT_S, Body, joint_inertias
from nrp_core.scene.model import Joint, Model
from nrp_core.scene.rigid import JointStates, JointTargets, Quaternion, ServoTarget
from nrp_core.world.engine_kit.firm_kinds import FREE, PATHS, POSITION, VELOCITY

RETURN_S = 0.005
"""Time constant with which a joint that was pushed off its path returns to it, s."""
STRENGTH = 10.0
"""How many times the model's weight a joint without a limit of effort can hold."""
BRAKING = 0.5
"""The share of a joint's effort with which it can brake; gravity and the other joints may take the rest."""
GRAVITY = 9.81
_NONE: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class FirmJoint:
    """A joint with a controller without gains.

    Args:
        joint: the joint, with its limits.
        inertia: the inertia (kg m^2) or mass (kg) that it moves, with all joints at 0.
        axis: the coordinate of a ball joint; -1 for that of another joint.
    """

    joint: Joint
    inertia: float = 0.0
    axis: int = -1

    @property
    def braking(self) -> float:
        """The acceleration with which it can brake, rad/s^2 or m/s^2."""
        return BRAKING * self.joint.effort / self.inertia if self.inertia else inf


def firm_names(model: Model) -> set[str]:
    """Return the joints of a model that have a controller without gains."""
    led = [leader.of_joint(joint) for leader in model.leaders for joint in leader.joints]
    return {each.joint for each in (*model.controllers, *led) if each.is_firm}


def firm_joints(
    model: Model, bodies: Sequence[Body], armatures: Mapping[str, float] = _NONE
) -> Mapping[str, FirmJoint]:
    """Return the joints of a model with a controller without gains, by the names of their coordinates.

    Joints without a limit of effort get one, so that they do not crush obstacles: the effort that
    holds :data:`STRENGTH` times the whole model at the distance of its farthest body, and that moves its own
    motor as fast.

    Args:
        model: the model.
        bodies: its bodies.
        armatures: the inertia (kg m^2) or mass (kg) of the motors of joints that have one.
    """
    names = firm_names(model)
    masses = [(body.inertial.mass, body.in_model @ body.inertial.pose) for body in bodies if body.inertial]
    weight = STRENGTH * GRAVITY * sum(mass for mass, _ in masses)
    inertias = joint_inertias(bodies) if names else {}
    joints = {}
    for joint in model.joints:
        if joint.name in names and joint.coordinates:
            lever = max((dist(pose.position, joint.pose.position) for _, pose in masses), default=0.0)
            motor = armatures.get(joint.name, 0.0)
            largest = weight * (1.0 if joint.kind == "prismatic" else lever) + STRENGTH * GRAVITY * motor
            limited = replace(joint, effort=largest) if joint.effort == inf and largest else joint
            inertia, is_ball = inertias[joint.name] + motor, joint.kind == "ball"
            for axis, name in enumerate(joint.coordinates):
                joints[name] = FirmJoint(limited, inertia, axis if is_ball else -1)
    return joints


class FirmServos:
    """The paths of all firm joints of a scene, computed together.

    Args:
        joints: the joints.
        step_s: the physics step.

    Attributes:
        paths: the path of each joint, of the type :data:`~.firm_kinds.PATHS`.
        kinds: for each joint ``FREE``, ``VELOCITY`` or ``POSITION``; a view of the paths, as are the next.
        positions, speeds: position and velocity of each path at the end of the next step.
        moving: whether any path has not arrived.
    """

    def __init__(self, firm: Sequence[FirmJoint], step_s: float) -> None:
        if firm:  # compiled code takes time to load
            from nrp_core.world.engine_kit.firm_paths import advance, velocities_to

            self._advance, self._velocities_to = advance, velocities_to
        self._step_s = step_s
        self.paths = np.zeros(len(firm), PATHS)
        self.kinds: IntArray = self.paths["kind"]
        self.positions: FloatArray = self.paths["path"]
        self.speeds: FloatArray = self.paths["speed"]
        self._targets, self._rates = self.paths["target"], self.paths["rate"]
        self._smooth, self._fresh = self.paths["smooth"], self.paths["fresh"]
        self._wanted: FloatArray = self.paths["wanted"]
        self._smoothed: slice | IntArray | None = None
        """The joints that are known to approach targets at rest, so that only these have to be set."""
        self.paths["braking"] = [each.braking for each in firm]
        self.paths["limit"] = [each.joint.velocity for each in firm]
        self.paths["lowest"] = [each.joint.lower for each in firm]
        self.paths["highest"] = [each.joint.upper for each in firm]
        self.moving = False

    def set_target(self, number: int, aim: ServoTarget) -> None:
        """Set the target of a joint, or release it."""
        kind = FREE if aim.firm is None else POSITION if aim.stiffness else VELOCITY
        target = aim.position if kind == POSITION else aim.velocity
        rate = aim.velocity if kind == POSITION else 0.0
        before = self.kinds[number], self._targets[number], self._rates[number]
        if kind != before[0]:
            self._fresh[number], self.kinds[number] = True, kind
        self._targets[number], self._rates[number], self._smooth[number] = target, rate, bool(aim.firm)
        self._smoothed = None
        self.moving |= kind != FREE and (kind, target, rate) != before

    def retarget(self, numbers: slice | IntArray, targets: JointTargets) -> None:
        """Set the targets of joints that have some of the same kind."""
        self._targets[numbers] = targets.values
        if targets.rates or not targets.smooth or numbers is not self._smoothed:
            self._rates[numbers] = targets.rates or 0.0
            self._smooth[numbers] = targets.smooth
            self._smoothed = numbers if targets.smooth and not targets.rates else None
        self.moving = True

    def forget(self, numbers: Sequence[int]) -> None:
        """Restart paths at the positions of their joints, because these were set from outside."""
        self._fresh[numbers] = self.kinds[numbers] != FREE
        self.moving |= bool(self._fresh.any())

    def step(self, positions: FloatArray, velocities: FloatArray) -> None:
        """Advance all paths by a step.

        Args:
            positions: positions of the joints now, where new paths begin, shape ``(n,)``.
            velocities: their velocities, shape ``(n,)``.
        """
        self.moving = self._advance(self._step_s, STIFF_TIME_CONSTANT_S, positions, velocities, self.paths)

    def velocities(self, positions: FloatArray) -> FloatArray:
        """Return the velocities at the end of the next step, from the positions at its start.

        This is ``speed + (position of the path - position) / RETURN_S``, by backward Euler, but never so fast
        that the joint could not brake before the path. It takes no joint over an end of its range, because
        the force behind it can exceed that of the end.
        """
        self._velocities_to(self._step_s, RETURN_S, positions, self.paths)
        return self._wanted

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self.paths.copy(), self.moving

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self.paths[:], self.moving = saved
        self._smoothed = None


JointPath = tuple[str, str]
"""A model and its joint."""
Span = slice | IntArray
"""Places in an array."""


class FirmJoints(ABC):
    """Firm joints that an engine moves together.

    Args:
        joints: the joints, by path.
        step_s: the physics step.

    Attributes:
        paths: the joints, which are numbered in this order.
        servos: computes their velocities.
        orientations: the orientation (x, y, z, w) to which each coordinate of a ball joint is led, shape
            ``(n, 4)``; its position is that of the rotation vector from there, along the child's axes.
        on: numbers of the joints that have a target, ascending.
        active: whether there are any.
    """

    def __init__(self, joints: Mapping[JointPath, FirmJoint], step_s: float) -> None:
        self.paths = list(joints)
        self.servos = FirmServos(list(joints.values()), step_s)
        self.on: IntArray = np.zeros(0, dtype=int)
        self.active = False
        self.orientations: FloatArray = np.tile([0.0, 0.0, 0.0, 1.0], (len(joints), 1))
        self._numbers = {path: number for number, path in enumerate(self.paths)}
        self._groups: dict[tuple[str, tuple[str, ...]], Span] = {}
        self._columns: dict[str, tuple[Span, Span]] = {}
        self._restored: FloatArray | None = None

    def set_target(self, path: JointPath, aim: ServoTarget) -> bool:
        """Set the target of a joint, or release it; return whether it was led before and after."""
        number = self._numbers[path]
        before = self.servos.kinds[number]
        self.servos.set_target(number, aim)
        after = self.servos.kinds[number]
        if before != after:
            if self._restored is not None:
                self._restored[number] = 0.0
            self._select()
            self._do_select(number)
        return bool(before != FREE != after)

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation of its child, or release it."""
        numbers = [self._numbers[model, f"{joint}_{axis}"] for axis in "xyz"]
        aim = ServoTarget() if orientation is None else ServoTarget(stiffness=1.0, firm=True)
        for number in numbers:
            self.set_target(self.paths[number], aim)
        if orientation is not None and (self.orientations[numbers] != orientation).any():
            self.orientations[numbers] = orientation
            self.servos.forget(numbers)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        """Change the targets of joints of a model, if all have a target; return whether they have."""
        places = model, targets.joints
        if places not in self._groups:
            numbers = [self._numbers.get((model, joint), -1) for joint in targets.joints]
            if -1 in numbers or not self.servos.kinds[numbers].all():
                return False
            self._groups[places] = span(numbers)
        self.servos.retarget(self._groups[places], targets)
        return True

    def forget(self, model: str) -> None:
        """Restart the paths of a model's joints at their positions, because these were set from outside."""
        self.servos.forget([number for (owner, _), number in self._numbers.items() if owner == model])

    def step(self, steps: int = 1) -> None:
        """Prepare or take the next physics steps, as the engine requires."""
        self._do_step(steps)
        self._restored = None

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the last step to the states of a model's joints."""
        if self.active:
            if model not in self._columns:
                own = [number for number in self.on.tolist() if self.paths[number][0] == model]
                places = [states.names.index(self.paths[number][1]) for number in own]
                self._columns[model] = span(own), span(places)
            numbers, columns = self._columns[model]
            states.efforts[columns] += self._efforts()[numbers]

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self.servos.save(), self.orientations.copy(), self._efforts().copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, self.orientations[:], efforts = saved
        self._restored = efforts.copy()
        self.servos.restore(servos)
        self._select()

    def _efforts(self) -> FloatArray:
        return self._do_efforts() if self._restored is None else self._restored

    def _select(self) -> None:
        self.on = np.flatnonzero(self.servos.kinds != FREE)
        self.active = bool(self.on.size)
        self._columns.clear()
        self._groups.clear()

    @abstractmethod
    def _do_step(self, steps: int) -> None: ...

    @abstractmethod
    def _do_efforts(self) -> FloatArray:
        """Return the efforts of all joints in the last step, shape ``(n,)``; 0 without a target."""

    @abstractmethod
    def _do_select(self, number: int) -> None:
        """Constrain or release a joint, after it got its first target or lost its last one."""


def span(places: Sequence[int]) -> Span:
    """Return places, as a slice if they are neighbours, which is faster."""
    first = min(places, default=0)
    neighbours = slice(first, first + len(places))
    return neighbours if list(places) == list(range(neighbours.start, neighbours.stop)) else np.array(places)
