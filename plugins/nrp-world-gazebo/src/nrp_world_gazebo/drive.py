"""Wheel drives: the planar servo in our plugin, in each physics step, or a plugin of Gazebo itself."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core.world import BodyVelocity
from nrp_core.world.engine_kit.planar_servo import PlanarServo
from nrp_world_gazebo.build import BodyHandle, Coordinate
from nrp_world_gazebo.motion import Tree
from nrp_world_gazebo.process import Gazebo
from nrp_world_gazebo.wire import named, operation

STRONG = 1e9


class Drive:
    """One drive.

    Args:
        gazebo: the process.
        number: the number of the drive there.
        servo: its planar servo.
        base: the body that it drives, with all that hangs on it.
        place: the handle of that body.
        wheels: handles of the wheels, in the servo's order.
        step_s: the physics step.
    """

    def __init__(
        self,
        gazebo: Gazebo,
        number: int,
        servo: PlanarServo,
        base: Tree,
        place: BodyHandle,
        wheels: Sequence[Coordinate],
        step_s: float,
    ) -> None:
        self._gazebo, self._number, self._servo, self._base = gazebo, number, servo, base
        self._wheels, self._step_s = wheels, step_s
        self._command: BodyVelocity | None = None
        frame = (*place.held.position, *place.held.orientation)
        gain = servo.explicit_gain(step_s)
        row = (*frame, *servo.centre, servo.lever, gain, servo.limit)
        gazebo.do(operation("d", place.link, values=row))
        self.set_velocity(BodyVelocity())

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        servo, known = self._servo, self._command
        if servo.limit and known not in (None, velocity):
            self._base.put(servo.changed(self._base(), known, velocity))
        if velocity == known:
            return
        self._command = velocity
        self._gazebo.do(operation("a", self._number, values=servo.aims(velocity, self._step_s)))
        for coordinate, wheel, spin in zip(self._wheels, servo.wheels, servo.spins(velocity), strict=True):
            row = (spin, wheel.share_in(self._step_s), min(wheel.limit, STRONG))
            self._gazebo.do(operation("m", coordinate.number, values=row))

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self._command = None


class PluginDrive:
    """One drive by a plugin of Gazebo itself.

    Args:
        gazebo: the process.
        model: the model, which the plugin's topic is named after.
        left: the sign with which the plugin takes a turn to the left.
    """

    def __init__(self, gazebo: Gazebo, model: str, left: float) -> None:
        self._gazebo, self._model, self._left = gazebo, model, left
        self._command: BodyVelocity | None = BodyVelocity()

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Send the plugin a velocity of the body."""
        if velocity != self._command:
            self._command = velocity
            self._gazebo.do(named("v", self._model, (velocity.forward, self._left * velocity.turn)))

    def forget(self) -> None:
        """Send the next command even if it is the last one."""
        self._command = None
