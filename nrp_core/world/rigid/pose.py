"""Poses: SI units, x forward, y left, z up, quaternions x, y, z, w."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, pi, sin, sqrt
from typing import Final

from nrp_core._support.checked_arguments import checks_arguments

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
        return rotated(x, y, z, w, vector)

    def rotate_back(self, vector: Vector) -> Vector:
        """Rotate a vector by the inverse orientation."""
        x, y, z, w = self.orientation
        return rotated(-x, -y, -z, w, vector)


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


def rotated(x: float, y: float, z: float, w: float, vector: Vector) -> Vector:
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
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    w = aw * bw - ax * bx - ay * by - az * bz
    norm = sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm
