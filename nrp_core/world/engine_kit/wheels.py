"""Wheels that spin as their drive commands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrp_core.world.drives.ackermann import Ackermann
from nrp_core.world.drives.mecanum import MecanumDrive
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.mass import turned
from nrp_core.world.scene.merged_bodies import Body

ROLLING_TIME_CONSTANT_S = 0.05
"""Time constant of a wheel that carries no load; slow enough not to rock the body by its reaction."""
DRIVING_TIME_CONSTANT_S = 0.001
"""Time constant of a wheel that moves its share of the robot; friction hardly slows it."""


@dataclass(frozen=True, slots=True)
class ServoedWheel:
    """A wheel that spins as its drive commands.

    Args:
        joint: its name.
        per_forward, per_turn: speed of the joint (rad/s) for each m/s forward and each rad/s of turn.
        per_left: the same for each m/s to the left; 0 for wheels without rollers.
        gain: gain of the servo, N m s/rad.
        limit: torque limit, N m.
        time_constant_s: time constant of its spin below the limit, s.
    """

    joint: str
    per_forward: float
    per_turn: float
    gain: float
    limit: float
    time_constant_s: float = ROLLING_TIME_CONSTANT_S
    per_left: float = 0.0

    def share_in(self, step_s: float) -> float:
        """Return the share of a wheel's speed error that one physics step removes."""
        return step_s / (step_s + self.time_constant_s)


def servoed_wheel(
    drive: WheelDrive | Ackermann | MecanumDrive, wheel: Body, side: float, carried: float
) -> ServoedWheel:
    """Return a wheel's servo; if the joint's axis points right, its sign is reversed.

    Args:
        drive: its drive.
        wheel: the wheel.
        side: -1 for a left wheel, 1 for a right one.
        carried: the mass (kg) that its friction moves; 0: it rolls without friction.
    """
    assert wheel.joint is not None
    assert wheel.inertial is not None
    axis = Pose(orientation=wheel.in_model.orientation).rotate(wheel.joint.axis)
    sign = 1.0 if axis[1] >= 0 else -1.0
    radius = drive.wheel_diameter / 2
    spin_axis = np.array(wheel.joint.axis)
    inertia = float(spin_axis @ turned(wheel.inertial) @ spin_axis) + carried * radius**2
    time_constant_s = DRIVING_TIME_CONSTANT_S if carried else ROLLING_TIME_CONSTANT_S
    return ServoedWheel(
        wheel.joint.name,
        per_forward=sign / radius,
        per_turn=sign * side * drive.separation / 2 / radius,
        gain=inertia / time_constant_s,
        limit=min(drive.torque, wheel.joint.effort),
        time_constant_s=time_constant_s,
        per_left=sign * _rolled(drive, wheel.joint.name, side) / radius,
    )


def _rolled(drive: WheelDrive | Ackermann | MecanumDrive, joint: str, side: float) -> float:
    """Return the share of a motion to the left that turns a wheel: that of rollers at 45 degrees."""
    if not isinstance(drive, MecanumDrive):
        return 0.0
    is_front = joint in (drive.left[-1], drive.right[-1])
    return side if is_front else -side
