"""Wheel drives: forces are set before each physics step, joint motors spin the wheels."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.rigid import BodyVelocity, Pose, Vector
from nrp_core.world.engine_kit.planar_servo import PlanarServo
from nrp_world_pybullet.build import BASE, BodyHandle
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import Moving

_STRONG = 1e9


class Drive:
    """One drive.

    Args:
        client: the physics client.
        servo: its planar servo.
        body: the body it drives, the base of a multi-body.
        multibody: the multi-body.
        wheels: handles of the wheels, in the servo's order.
        step_s: the physics step.
        gravity: the gravity of the scene, m/s^2.
    """

    def __init__(
        self,
        client: int,
        servo: PlanarServo,
        body: Body,
        multibody: int,
        wheels: Sequence[BodyHandle],
        step_s: float,
        gravity: Vector,
    ) -> None:
        assert body.inertial is not None
        self._client, self._servo = client, servo
        in_engine = body.inertial.pose.inverse()  # PyBullet's base frame is the inertial frame
        self._base = Moving(BodyHandle(multibody, BASE), in_engine, client)
        self._multibody = multibody
        self._wheels = [wheel.link for wheel in wheels]
        self._forces = [min(wheel.limit, _STRONG) for wheel in servo.wheels]
        self._shares = [wheel.share_in(step_s) for wheel in servo.wheels]
        self._step_s = step_s
        self._fall = gravity[0] * step_s, gravity[1] * step_s, gravity[2] * step_s
        self._gain, self._limit = servo.explicit_gain(step_s), servo.limit
        self._ahead, self._aside = in_engine.rotate((1.0, 0.0, 0.0)), in_engine.rotate((0.0, 1.0, 0.0))
        self._up = in_engine.rotate((0.0, 0.0, 1.0))
        self._centre = (in_engine @ Pose(servo.centre)).position
        self._left, self._right = ((in_engine @ Pose(point)).position for point in servo.points[:2])
        self._command: BodyVelocity | None = None
        self.set_velocity(BodyVelocity())

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        if self._limit and self._command not in (None, velocity):
            self._base.set_velocity(self._servo.changed(self._base(), self._command, velocity))
        self._command = velocity
        self._aims = self._servo.aims(velocity, self._step_s)
        if not self._wheels:
            return
        bullet.setJointMotorControlArray(
            self._multibody,
            self._wheels,
            bullet.VELOCITY_CONTROL,
            targetVelocities=self._servo.spins(velocity),
            forces=self._forces,
            velocityGains=self._shares,
            physicsClientId=self._client,
        )

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self._command = None

    def push(self) -> None:
        """Set the forces of the next physics step, in the base's frame."""
        if not self._limit:
            return  # the wheels move the robot, or it has no traction
        body, client = self._multibody, self._client
        ahead, side, turn = self._velocities()
        left, right, front, rear = self._aims
        gain, limit, swing = self._gain, self._limit, self._servo.lever * turn
        left = max(-limit, min(limit, gain * (left - ahead + swing)))
        right = max(-limit, min(limit, gain * (right - ahead - swing)))
        front = max(-limit, min(limit, gain * (front - side - swing)))
        rear = max(-limit, min(limit, gain * (rear - side + swing)))
        # two calls suffice: the left and right point also get the forces and the moment of the front and rear
        # one
        twist, across = (front - rear) / 2, (front + rear) / 2
        (ax, ay, az), (bx, by, bz) = self._ahead, self._aside
        bx, by, bz = across * bx, across * by, across * bz
        for force, point in ((left - twist, self._left), (right + twist, self._right)):
            pull = (force * ax + bx, force * ay + by, force * az + bz)
            bullet.applyExternalForce(body, BASE, pull, point, bullet.LINK_FRAME, client)

    def _velocities(self) -> Vector:
        """Return the centre's forward and leftward velocity and the turn rate, after a step of free fall."""
        _, (x, y, z, w) = bullet.getBasePositionAndOrientation(self._multibody, self._client)
        (vx, vy, vz), (wx, wy, wz) = bullet.getBaseVelocity(self._multibody, self._client)
        fx, fy, fz = self._fall
        vx, vy, vz = vx + fx, vy + fy, vz + fz
        # the rows of the matrix from the base to the world
        rxx, rxy, rxz = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        ryx, ryy, ryz = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        rzx, rzy, rzz = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        wx, wy, wz = (
            rxx * wx + ryx * wy + rzx * wz,
            rxy * wx + ryy * wy + rzy * wz,
            rxz * wx + ryz * wy + rzz * wz,
        )
        cx, cy, cz = self._centre
        vx, vy, vz = (
            rxx * vx + ryx * vy + rzx * vz + wy * cz - wz * cy,
            rxy * vx + ryy * vy + rzy * vz + wz * cx - wx * cz,
            rxz * vx + ryz * vy + rzz * vz + wx * cy - wy * cx,
        )
        (ax, ay, az), (bx, by, bz), (ux, uy, uz) = self._ahead, self._aside, self._up
        return ax * vx + ay * vy + az * vz, bx * vx + by * vy + bz * vz, ux * wx + uy * wy + uz * wz
