"""Wheel drives: a force on the body in each physics step, and motors that spin the wheels."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core.scene.rigid import BodyVelocity, Vector, rotate_vector
from nrp_core.world.engine_kit.planar_servo import PlanarServo
from nrp_world_drake.build import Motor
from nrp_world_drake.motion import Base, Running


class Drive:
    """One drive.

    Args:
        running: the plant.
        servo: its planar servo.
        base: the body that it drives.
        wheels: the motors of the wheels, in the servo's order.
        step_s: the physics step.
        gravity: the gravity of the scene, m/s^2.
    """

    def __init__(
        self,
        running: Running,
        servo: PlanarServo,
        base: Base,
        wheels: Sequence[Motor],
        step_s: float,
        gravity: Vector,
    ) -> None:
        self._running, self._servo, self._base, self._step_s = running, servo, base, step_s
        self._numbers = [wheel.number for wheel in wheels]
        self._fall = gravity[0] * step_s, gravity[1] * step_s, gravity[2] * step_s
        self._gain, self._limit = servo.explicit_gain(step_s), servo.limit
        self._place = slice(base.coordinate, base.coordinate + 6)
        self._command: BodyVelocity | None = None
        self.set_velocity(BodyVelocity())

    @property
    def pushes(self) -> bool:
        """Whether a force moves the body; otherwise its wheels do, or it has no traction."""
        return bool(self._limit)

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        if self._limit and self._command not in (None, velocity):
            self._base.set_velocity(self._servo.changed(self._base(), self._command, velocity))
        self._command = velocity
        self._aims = self._servo.aims(velocity, self._step_s)
        self._running.desired[1, self._numbers] = self._servo.spins(velocity)
        self._running.touch()

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self._command = None

    def push(self) -> None:
        """Set the force of the next physics step."""
        motion, servo = self._base(), self._servo
        x, y, z, w = motion.pose.orientation
        (vx, vy, vz), (fx, fy, fz), (cx, cy, cz) = motion.linear, self._fall, servo.centre
        vx, vy, vz = rotate_vector(-x, -y, -z, w, (vx + fx, vy + fy, vz + fz))
        wx, wy, wz = rotate_vector(-x, -y, -z, w, motion.angular)
        ahead, side, swing = vx + wy * cz - wz * cy, vy + wz * cx - wx * cz, servo.lever * wz
        left, right, front, rear = self._aims
        gain, limit = self._gain, self._limit
        left = max(-limit, min(limit, gain * (left - ahead + swing)))
        right = max(-limit, min(limit, gain * (right - ahead - swing)))
        front = max(-limit, min(limit, gain * (front - side - swing)))
        rear = max(-limit, min(limit, gain * (rear - side + swing)))
        along, across = left + right, front + rear
        turn = servo.lever * (right - left + front - rear)
        force = rotate_vector(x, y, z, w, (along, across, 0.0))
        torque = (-across * cz, along * cz, across * cx - along * cy + turn)  # about the frame's origin
        self._running.forces[self._place] = (*rotate_vector(x, y, z, w, torque), *force)
