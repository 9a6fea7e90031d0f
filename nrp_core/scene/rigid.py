"""Poses, rotations and motions of rigid bodies, used by all other packages of a world."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, pi, sin, sqrt
from typing import Any, Final, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.small_matrices import product

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

ROUNDED_TURN_RAD: Final = 2.02 * pi
"""A full turn as files round it; an orientation needs half of one."""

_LEVEL = 1e-300  # the direction of shorter vectors is inaccurate
_GIMBAL_LOCK = 1e-7  # below this cosine of the pitch, roll and yaw cannot be separated numerically


@dataclass(frozen=True, slots=True)
class Pose:
    """A position in metres and an orientation as a unit quaternion (x, y, z, w).

    ``a @ b`` is the pose ``b``, given in the frame ``a``, in the frame in which ``a`` is given.
    """

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    @checks_arguments()
    def from_rpy(cls, position: Vector, roll: float, pitch: float, yaw: float) -> Pose:
        """Build a pose from roll, pitch and yaw in radians, about fixed axes x, y, z (as SDF, URDF)."""
        cr, sr = cos(roll / 2), sin(roll / 2)
        cp, sp = cos(pitch / 2), sin(pitch / 2)
        cy, sy = cos(yaw / 2), sin(yaw / 2)
        orientation = (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
        return cls(position, orientation)

    @classmethod
    @checks_arguments()
    def pointing(cls, direction: Vector) -> Pose:
        """Build the shortest rotation that takes z to a unit vector."""
        x, y, z = direction
        level = hypot(x, y)
        half = atan2(level, z) / 2
        along_x, along_y = (-y / level, x / level) if level > _LEVEL else (1.0, 0.0)
        return cls(orientation=(along_x * sin(half), along_y * sin(half), 0.0, cos(half)))

    @property
    def rpy(self) -> Vector:
        """Roll, pitch and yaw in radians; where the pitch is 90 degrees up or down, the roll is 0."""
        x, y, z, w = self.orientation
        forward = 1 - 2 * (y * y + z * z), 2 * (w * z + x * y)  # of the turned x axis, in the plane
        up = 2 * (w * y - z * x)
        level = hypot(*forward)
        if level < _GIMBAL_LOCK:
            return 0.0, atan2(up, level), -2 * copysign(1, up) * atan2(x, w)
        roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        return roll, atan2(up, level), atan2(forward[1], forward[0])

    @property
    def yaw(self) -> float:
        """Heading in radians, counter-clockwise from x."""
        return self.rpy[2]

    def __matmul__(self, other: Pose) -> Pose:
        x, y, z = self.rotate(other.position)
        px, py, pz = self.position
        return Pose((px + x, py + y, pz + z), multiply(self.orientation, other.orientation))

    def inverse(self) -> Pose:
        """Return the inverse pose."""
        x, y, z, w = self.orientation
        turned_back = Pose(orientation=(-x, -y, -z, w))
        px, py, pz = turned_back.rotate(self.position)
        return Pose((-px, -py, -pz), turned_back.orientation)

    def rotate(self, vector: Vector) -> Vector:
        """Rotate a vector by the orientation."""
        x, y, z, w = self.orientation
        return rotate_vector(x, y, z, w, vector)

    def rotate_back(self, vector: Vector) -> Vector:
        """Rotate a vector by the inverse orientation."""
        x, y, z, w = self.orientation
        return rotate_vector(-x, -y, -z, w, vector)


def rotation_vector(orientation: Quaternion) -> Vector:
    """Return a rotation as a rotation vector: along its axis, with its angle as length (rad, at most pi)."""
    x, y, z, w = orientation
    half = hypot(x, y, z)
    if half < _LEVEL:
        return 0.0, 0.0, 0.0
    times = 2 * atan2(copysign(half, w), abs(w)) / half
    return times * x, times * y, times * z


def rotation_by(vector: Vector) -> Quaternion:
    """Return the rotation about a vector by its length in radians."""
    x, y, z = vector
    angle = hypot(x, y, z)
    times = sin(angle / 2) / angle if angle > _LEVEL else 0.5
    return x * times, y * times, z * times, cos(angle / 2)


def rotate_vector(x: float, y: float, z: float, w: float, vector: Vector) -> Vector:
    """Return a vector rotated by a unit quaternion."""
    vx, vy, vz = vector
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation ``b`` followed by ``a``, normalised."""
    x, y, z, w = _product(a, b)
    norm = sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


def _product(a: Any, b: Any) -> tuple[Any, Any, Any, Any]:
    """Return the product of quaternions, each of four numbers or four arrays."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotation_matrix(orientation: Quaternion) -> FloatArray:
    """Return the rotation matrix of a quaternion."""
    pose = Pose(orientation=orientation)
    return np.array([pose.rotate(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]).T


def matrix_of(pose: Pose) -> FloatArray:
    """Return a pose as rotation and translation, shape ``(3, 4)``."""
    return np.column_stack([rotation_matrix(pose.orientation), pose.position])


def transform(points: FloatArray, place: FloatArray) -> FloatArray:
    """Return points of a frame in the frame in which its pose is given.

    Args:
        points: shape ``(n, 3)``, m.
        place: the pose as :func:`matrix_of` returns it.
    """
    moved: FloatArray = product(points, place[:3, :3].T) + place[:3, 3]
    return moved


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


class LinkMotions(NamedTuple):
    """Poses and velocities of ``n`` links in the world's frame.

    Args:
        positions: m, shape ``(n, 3)``.
        orientations: quaternions x, y, z, w, shape ``(n, 4)``.
        velocities: m/s and rad/s, shape ``(n, 2, 3)``.
    """

    positions: FloatArray
    orientations: FloatArray
    velocities: FloatArray

    @classmethod
    def of(cls, motions: Sequence[ModelMotion]) -> LinkMotions:
        """Return the motions of single links as arrays."""
        return cls(
            np.array([each.pose.position for each in motions]),
            np.array([each.pose.orientation for each in motions]),
            np.array([(each.linear, each.angular) for each in motions]).reshape(-1, 2, 3),
        )

    def at(self, offsets: LinkMotions) -> LinkMotions:
        """Return the motions of frames at fixed offsets in these links: :meth:`ModelMotion.at` for each."""
        turn, held = cast(Any, self.orientations.T), cast(Any, offsets.positions.T)
        qx, qy, qz, qw = turn
        positions = self.positions + np.array(rotate_vector(qx, qy, qz, qw, held)).T
        x, y, z = (positions - self.positions).T
        turned = np.array(_product(turn, offsets.orientations.T))
        turned /= np.sqrt(turned[0] ** 2 + turned[1] ** 2 + turned[2] ** 2 + turned[3] ** 2)
        (vx, vy, vz), (wx, wy, wz) = self.velocities.transpose(1, 2, 0)
        linear = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
        return LinkMotions(positions, turned.T, np.array([linear, (wx, wy, wz)]).transpose(2, 0, 1))


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
        smooth: whether the targets are approached smoothly, see :class:`ServoTarget`.
    """

    joints: tuple[str, ...]
    values: Sequence[float]
    rates: Sequence[float]
    smooth: bool


@dataclass(frozen=True, slots=True)
class ServoTarget:
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
