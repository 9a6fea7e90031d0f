"""Wheel drives: MuJoCo's actuators act as the servo in each physics step."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.world.engine_kit.planar_servo import PlanarServo
from nrp_core.world.rigid.motion import BodyVelocity
from nrp_world_mujoco.motion import Floating


class Drive:
    """One drive.

    Args:
        data: MuJoCo's state.
        servo: its planar servo.
        base: the body that it drives.
        actuators: ids of the actuators: those of the servo's points, then those of the wheels.
        step_s: the physics step.
    """

    def __init__(
        self, data: Any, servo: PlanarServo, base: Floating, actuators: list[int], step_s: float
    ) -> None:
        self._servo, self._base, self._step_s = servo, base, step_s
        self._controls = data.ctrl
        self._actuators = np.array(actuators)
        self._command: BodyVelocity | None = BodyVelocity()

    def aim(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        servo, base, before = self._servo, self._base, self._command
        if servo.limit and before is not None and before != velocity:
            base.change_velocity(lambda v, w: servo.change(v, w, before, velocity))
        self._command = velocity
        self._controls[self._actuators] = (*servo.aims(velocity, self._step_s), *servo.spins(velocity))

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self._command = None
