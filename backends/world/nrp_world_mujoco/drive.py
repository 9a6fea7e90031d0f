"""What acts in each physics step: the servos of wheel drives and velocity decay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.rigid import BodyVelocity, Pose
from nrp_core.world.engine_kit.planar_servo import PlanarServo, towards_each
from nrp_core.world.engine_kit.simulated import Decay
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.motion import Floating, change_velocities


class Drive:
    """One drive.

    Args:
        state: the state.
        servo: its planar servo.
        base: the body that it drives.
        actuators: ids of the actuators: those of the servo's points, then those of the wheels.
        step_s: the physics step.

    Attributes:
        servo, base, step_s: as given.
        command: the present target velocity of the body; None: the next one counts as in force before.
    """

    def __init__(
        self, state: Any, servo: PlanarServo, base: Floating, actuators: list[int], step_s: float
    ) -> None:
        self.servo, self.base, self.step_s = servo, base, step_s
        places = np.array(actuators)
        first, end = places[0], places[0] + len(places)
        # a range, as it usually is, is written several times as fast
        in_a_row = np.array_equal(places, np.arange(first, end))
        self._controls = state.ctrl[first:end] if in_a_row else state.ctrl
        self._places: Any = ... if in_a_row else places
        self.command: BodyVelocity | None = BodyVelocity()

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""
        servo, before = self.servo, self.command
        if before == velocity:
            return
        if servo.limit and before is not None:
            self.base.change_velocity(partial(servo.change, before=before, after=velocity))
        self.command = velocity
        self.control((*servo.aims(velocity, self.step_s), *servo.spins(velocity)))

    def control(self, controls: Any) -> None:
        """Set the controls of the actuators, in their order."""
        self._controls[self._places] = controls

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""
        self.command = None


def set_velocities(drives: Sequence[Drive], velocities: Sequence[BodyVelocity]) -> None:
    """Set the target velocities of several drives, as :meth:`Drive.set_velocity` does, by arrays."""
    changing = [
        (drive, velocity)
        for drive, velocity in zip(drives, velocities, strict=True)
        if drive.command != velocity
    ]
    servo, step_s = drives[0].servo, drives[0].step_s  # of one engine and its copies, if they share a servo
    if any(drive.servo is not servo or drive.command is None for drive, _ in changing):
        for drive, velocity in changing:
            drive.set_velocity(velocity)
        return
    if not changing:
        return
    drives, velocities = zip(*changing, strict=True)
    before, after = _in_arrays([drive.command for drive in drives]), _in_arrays(velocities)
    with np.errstate(all="ignore"):  # as numbers of Python
        if servo.limit:
            change = partial(servo.change, before=before, after=after, towards=towards_each)
            change_velocities([drive.base for drive in drives], change)
        controls = np.array([*servo.aims(after, step_s), *servo.spins(after)]).T
    for drive, velocity, row in zip(drives, velocities, controls, strict=True):
        drive.command = velocity
        drive.control(row)


def _in_arrays(velocities: Sequence[Any]) -> Any:
    """Return velocities as one of arrays."""
    return BodyVelocity(*np.array([(each.forward, each.left, each.turn) for each in velocities]).T)


class Decays:
    """The bodies of a scene whose velocities decay.

    Args:
        built: the scene.
        step_s: the physics step.
    """

    def __init__(self, built: Built, step_s: float) -> None:
        self._model = built.model
        places = [each for bodies in built.bodies.values() for each in bodies]
        found = [(ident, Decay.of(body, step_s)) for body, ident in places]
        self._decays = [(ident, decay) for ident, decay in found if decay is not None]
        self._ids = [ident for ident, _ in self._decays]
        self._velocity = np.empty(6)
        self._last = np.zeros((len(self._ids), 6))

    def __bool__(self) -> bool:
        return bool(self._decays)

    def advance(self, data: Any, steps: int, step: Callable[[Any, int], None]) -> None:
        """Take steps; apply the given wrenches, and those of the velocities at the start of each step.

        Args:
            data: MuJoCo's data.
            steps: the number of steps.
            step: takes a number of steps with the data.
        """
        wrenches = data.xfrc_applied
        given = wrenches[self._ids]
        for _ in range(steps):
            mujoco.mj_kinematics(self._model, data)
            mujoco.mj_comPos(self._model, data)
            mujoco.mj_comVel(self._model, data)
            wrenches[self._ids] = given
            for ident, decay in self._decays:
                self._slow(data, ident, decay)
            step(data, 1)
        self._last = wrenches[self._ids]
        wrenches[self._ids] = given

    def act_again(self, wrenches: FloatArray) -> None:
        """Write the last step's wrenches on bodies with velocity decay, for sensors that measure it."""
        wrenches[self._ids] = self._last

    def _slow(self, data: Any, ident: int, decay: Decay) -> None:
        kind = mujoco.mjtObj.mjOBJ_BODY  # its centre of mass
        mujoco.mj_objectVelocity(self._model, data, kind, ident, self._velocity, 0)
        wx, wy, wz, vx, vy, vz = self._velocity.tolist()
        turn = np.empty(4)
        mujoco.mju_mat2Quat(turn, data.ximat[ident])
        w, x, y, z = turn.tolist()
        wrench = decay.wrench(Pose(orientation=(x, y, z, w)), (vx, vy, vz), (wx, wy, wz))
        data.xfrc_applied[ident] += (*wrench.force, *wrench.torque)
