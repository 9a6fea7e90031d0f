"""The operations of an engine on joints and actuators."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import Any, final

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import CapabilityError
from nrp_core.findings.refusals import JOINT_CONTROL, refusal
from nrp_core.scene.rigid import JointTargets, Quaternion, ServoTarget, Vector


class JointCommands(ABC):
    """The operations of an :class:`~nrp_core.world.engine.Engine` on joints and actuators."""

    @final
    def lacks(self, what: str) -> CapabilityError:
        """Return the error for an operation that the engine does not have."""
        return refusal(self, what)

    @final
    def set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo; only joints with a controller have one."""
        self._do_set_servo_target(model, joint, aim)

    @final
    def set_ball_target(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint with a controller to an orientation of its child, or release it."""
        self._do_set_ball_target(model, joint, orientation)

    @final
    def set_servo_efforts(self, model: str, joints: tuple[str, ...], efforts: Sequence[float]) -> None:
        """Set the targets of servos to efforts alone, N m or N; faster than :meth:`set_servo_target`."""
        self._do_set_servo_efforts(model, joints, efforts)

    @classmethod
    def set_servo_efforts_of(
        cls, engines: Sequence[Any], model: str, joints: tuple[str, ...], rows: FloatArray
    ) -> None:
        """Set efforts in several engines, shape ``(engines, joints)``; see :meth:`set_servo_efforts`."""
        for engine, row in zip(engines, rows.tolist(), strict=True):
            engine._do_set_servo_efforts(model, joints, row)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        """Change the targets of firm joints at once, if the engine can, and return whether it did.

        It is faster than a call of :meth:`set_servo_target` for each, which gave them their present targets.

        Args:
            model: the model.
            targets: its joints, and their targets.
        """
        return False

    @final
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort (N m, N) to a joint from now on, in addition to its servo."""
        self._do_set_joint_effort(model, joint, effort)

    def set_control(self, model: str, actuator: str, value: float) -> None:
        """Set the control of an actuator; implemented where ``own_actuators`` or ``muscles`` is declared."""
        raise self.lacks("has no actuators of its own")

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        """Set the controls of several actuators; an engine may override it with a faster one.

        Args:
            model: the model.
            actuators: their names.
            values: their controls, shape ``(n,)``.
        """
        for actuator, value in zip(actuators, values.tolist(), strict=True):
            self.set_control(model, actuator, value)

    @final
    def actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        """Return the states of actuators of a model at the present time, shape ``(4, n)``.

        Returns:
            The lengths (m), velocities (m/s, positive where they lengthen), tensions (N, positive where they
            pull) and activations. Where an actuator turns a joint, rad and N m are in place of m and N.

        Raises:
            CapabilityError: the engine has neither ``muscles`` nor ``own_actuators``.
        """
        return self._do_actuator_states(model, actuators)

    def muscle_path(self, model: str, muscle: str) -> Sequence[Vector]:
        """Return the points of a muscle's path in the world, m; empty if its own points are all."""
        return ()

    @final
    def sensor_values(self, model: str, sensor: str) -> FloatArray:
        """Return the present values of one of the engine's own sensors, in its order.

        Raises:
            CapabilityError: the engine does not have ``own_actuators``.
        """
        return self._do_sensor_values(model, sensor)

    # -- for backends

    def _do_set_servo_efforts(self, model: str, joints: tuple[str, ...], efforts: Sequence[float]) -> None:
        """Set the targets of servos to efforts; an engine may override it with a faster one."""
        for joint, effort in zip(joints, efforts, strict=True):
            self._do_set_servo_target(model, joint, ServoTarget(effort=effort))

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of the servo of a joint with a controller."""
        raise self.lacks(JOINT_CONTROL)

    def _do_set_ball_target(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint with a controller to an orientation, or release it."""
        raise self.lacks("cannot lead ball joints to orientations")

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint from now on, in addition to its servo."""
        raise self.lacks(JOINT_CONTROL)

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        """Return lengths, velocities, tensions and activations of actuators, a new array."""
        raise self.lacks("does not report the states of actuators")

    def _do_sensor_values(self, model: str, sensor: str) -> FloatArray:
        """Return the values of a sensor among the engine's own elements, as a new array."""
        raise self.lacks("has no sensors of its own")
