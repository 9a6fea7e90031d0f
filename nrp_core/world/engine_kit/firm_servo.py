"""Servos that reach their targets under any load within the limits of their joints.

Joints without gains in their files have them. A target is approached along a path, which is the same in every
engine. In each step a joint gets the velocity that takes it back to this path. An engine makes this velocity
a constraint with a bounded force, and solves it together with contacts. So no load, neither gravity nor a
robot on its wheels, moves the joint off its path, unless it exceeds the joint's limit of effort.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import dist, inf
from types import MappingProxyType
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.world.engine_kit.firm_kinds import FREE, PATHS, POSITION, VELOCITY
from nrp_core.world.rigid.motion import JointAim, JointTargets
from nrp_core.world.scene.joint_inertia import STIFF_TIME_CONSTANT_S, joint_inertias
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import Joint, Model

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


def firm_joints(
    model: Model, bodies: Sequence[Body], armatures: Mapping[str, float] = _NONE
) -> Mapping[str, FirmJoint]:
    """Return the joints of a model with a controller without gains, by the names of their coordinates.

    Those without a limit of effort get one, so that they do not crush what is in their way: the effort that
    holds :data:`STRENGTH` times the whole model at the distance of its farthest body, and that moves its own
    motor as fast.

    Args:
        model: the model.
        bodies: its bodies.
        armatures: the inertia (kg m^2) or mass (kg) of the motors of joints that have one.
    """
    led = [leader.of_joint(joint) for leader in model.leaders for joint in leader.joints]
    names = {each.joint for each in (*model.controllers, *led) if each.is_firm}
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

    def aim(self, number: int, aim: JointAim) -> None:
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
