"""The geometry of a car: how far its wheels turn for a curve, and how its body moves then."""

from __future__ import annotations

from math import atan, copysign, inf, tan

from nrp_core.world.rigid.motion import BodyVelocity
from nrp_core.world.scene.acting import Ackermann


def ackermann_velocity(drive: Ackermann, forward: float, turn: float) -> BodyVelocity:
    """Return how the middle of the rear axle moves on a command.

    Args:
        drive: the car.
        forward: m/s.
        turn: the steering angle (rad; to the other side in reverse) where the drive ``steers``, else the turn
            rate (rad/s); as far as the steering goes. A car that stands does not turn.
    """
    if drive.steers:
        angle = min(max(copysign(1.0, forward) * turn, -drive.max_steer), drive.max_steer)
    elif forward:
        angle = atan(drive.wheel_base * turn / forward)
        angle = min(max(angle, -drive.max_steer), drive.max_steer)
    else:
        angle = 0.0
    return BodyVelocity(forward, turn=forward * tan(angle) / drive.wheel_base, steer=angle)


def wheel_angles(drive: Ackermann, steer: float) -> tuple[float, float]:
    """Return the angles of the left and right front wheel, whose axles meet that of the rear wheels."""
    radius = drive.wheel_base / tan(steer) if steer else inf
    if radius == inf:
        return 0.0, 0.0
    left, right = radius - drive.separation / 2, radius + drive.separation / 2
    return _angle(drive.wheel_base, left, steer), _angle(drive.wheel_base, right, steer)


def _angle(wheel_base: float, radius: float, steer: float) -> float:
    return copysign(atan(wheel_base / abs(radius)), steer) if radius else steer
