"""Motions of bodies and joints, their commands, and the forces on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid.pose import Pose, Vector

BodyPath = tuple[str, int]
"""A model and the index of one of its bodies."""


@dataclass(frozen=True, slots=True)
class ModelMotion:
    """Pose of a model's frame and its linear (m/s) and angular (rad/s) velocity, in the world's frame."""

    pose: Pose
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)

    def at(self, offset: Pose) -> ModelMotion:
        """Return the motion of a frame fixed at ``offset`` in this one."""
        pose = self.pose @ offset
        (px, py, pz), (ox, oy, oz) = pose.position, self.pose.position
        x, y, z = px - ox, py - oy, pz - oz
        vx, vy, vz = self.linear
        wx, wy, wz = self.angular
        linear = (vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x)
        return ModelMotion(pose, linear, self.angular)


@dataclass(frozen=True, slots=True)
class BodyVelocity:
    """A velocity in the body's frame: forward and left in m/s, turn (about z) in rad/s.

    ``steer`` is the corresponding angle (rad) of steered wheels.
    """

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    steer: float = 0.0


@dataclass(frozen=True, slots=True)
class JointStates:
    """Names, positions (rad, m), velocities and efforts of joints, each of shape ``(n,)``."""

    names: tuple[str, ...]
    positions: npt.NDArray[np.float64]
    velocities: npt.NDArray[np.float64]
    efforts: npt.NDArray[np.float64]


class JointTargets(NamedTuple):
    """New targets of joints of a model.

    Args:
        joints: the joints.
        values: positions or velocities, as before.
        rates: the rates of change of positions; none for 0.
        smooth: whether the targets are approached smoothly, see :class:`JointAim`.
    """

    joints: tuple[str, ...]
    values: Sequence[float]
    rates: Sequence[float]
    smooth: bool


@dataclass(frozen=True, slots=True)
class JointAim:
    """The target of a joint's servo.

    Its effort is ``stiffness * (position - q) + damping * (velocity - dq/dt) + effort``, taken at the end of
    each physics step (backward Euler, so that any gains are stable) and bounded by the joint's limit.

    Args:
        stiffness, damping: N m/rad (N/m), N m s/rad (N s/m).
        position, velocity: the target, rad (m), rad/s (m/s).
        effort: an additional effort, N m (N).
        firm: None: the effort is as above. Otherwise the joint follows with any load within its limits of
            effort and velocity, to the position if there is a stiffness, else to the velocity; the gains are
            for engines without such servos. True: the target is approached smoothly. False: it is a point of
            a path, for the end of the next step.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0
    firm: bool | None = None


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact of two bodies in the last physics step.

    Args:
        bodies: model and body index of both.
        position: position in the world, m.
        normal: unit vector out of the second body.
        depth: penetration depth, m.
        force: force of the second on the first, N, along the world's axes.
    """

    bodies: tuple[BodyPath, BodyPath]
    position: Vector
    normal: Vector
    depth: float
    force: Vector


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force (N) and a torque (N m), along the world's axes."""

    force: Vector = (0.0, 0.0, 0.0)
    torque: Vector = (0.0, 0.0, 0.0)


ReadFrames = Callable[[FloatArray], None]
"""A function that writes rotation and translation of bodies to the world, shape ``(n, 3, 4)``."""
