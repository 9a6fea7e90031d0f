"""Wheel drives: MuJoCo's actuators act as the servo in each physics step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrp_core.world.engine_kit.planar_servo import PlanarServo
from nrp_core.world.rigid.motion import BodyVelocity
from nrp_world_mujoco.motion import Floating, change_velocities


class Drive:
    """One drive.

    Args:
        data: MuJoCo's state.
        servo: its planar servo.
        base: the body that it drives.
        actuators: ids of the actuators: those of the servo's points, then those of the wheels.
        step_s: the physics step.

    Attributes:
        servo, base, step_s: as given.
        command: the present target velocity of the body; None: the next one counts as in force before.
    """

    def __init__(
        self, data: Any, servo: PlanarServo, base: Floating, actuators: list[int], step_s: float
    ) -> None:
        self.servo, self.base, self.step_s = servo, base, step_s
        places = np.array(actuators)
        first, end = places[0], places[0] + len(places)
        # a range, as it usually is, is written several times as fast
        in_a_row = np.array_equal(places, np.arange(first, end))
        self._controls = data.ctrl[first:end] if in_a_row else data.ctrl
        self._places: Any = ... if in_a_row else places
        self.command: BodyVelocity | None = BodyVelocity()

    def aim(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        servo, before = self.servo, self.command
        if before == velocity:
            return
        if servo.limit and before is not None:
            self.base.change_velocity(lambda v, w: servo.change(v, w, before, velocity))
        self.command = velocity
        self.control((*servo.aims(velocity, self.step_s), *servo.spins(velocity)))

    def control(self, controls: Any) -> None:
        """Set the controls of the actuators, in their order."""
        self._controls[self._places] = controls

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self.command = None


def aim_all(drives: Sequence[Drive], velocities: Sequence[BodyVelocity]) -> None:
    """Set the target velocities of the same drive in copies of a scene, as :meth:`Drive.aim` does of one."""
    servo, step_s = drives[0].servo, drives[0].step_s
    new = [(drive, v) for drive, v in zip(drives, velocities, strict=True) if drive.command != v]
    moved = [(drive, v) for drive, v in new if drive.command is not None]
    if servo.limit and moved:
        before, after = _together([drive.command for drive, _ in moved]), _together([v for _, v in moved])
        change_velocities([drive.base for drive, _ in moved], lambda v, w: servo.changes(v, w, before, after))
    if new:
        target = _together([v for _, v in new])
        controls = np.array([*servo.aims(target, step_s), *servo.spins(target)]).T
        for (drive, v), row in zip(new, controls, strict=True):
            drive.command = v
            drive.control(row)


def _together(velocities: Sequence[Any]) -> Any:
    """Return velocities as one, whose components are arrays."""
    return BodyVelocity(*np.array([(v.forward, v.left, v.turn) for v in velocities]).T)
