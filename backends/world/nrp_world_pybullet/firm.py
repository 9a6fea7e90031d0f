"""Firm joints in PyBullet: its motors, which are constraints with a bounded force.

PyBullet solves the constraints of a step by a number of iterations that begin without forces, so a chain of
joints would sag a little. Here the remaining error is learnt slowly, and the path is shifted by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.scene.merged_bodies import STIFF_TIME_CONSTANT_S
from nrp_core.scene.rigid import multiply, rotation_by
from nrp_core.world.engine_kit.firm_joints import RETURN_S, FirmJoint, FirmJoints, JointPath, span
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_world_pybullet.build import UNLIMITED_FORCE, BodyHandle
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import JointReader

LEARNT_S = 0.1
"""Time constant with which the remaining error is learnt, s."""
LARGEST = 0.005
"""The largest error that is learnt, rad or m; larger ones are due to a load beyond the limit of effort."""


SHARE, GAIN = 0.2, 100.0
"""The share of an error that PyBullet's motors of ball joints correct in a step, and a gain of the error."""


class BulletFirmJoints(FirmJoints):
    """The firm joints of one multi-body.

    Args:
        joints: the joints with their handles, by path.
        reader: reads the joints of their model.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(
        self,
        joints: Mapping[JointPath, tuple[FirmJoint, BodyHandle]],
        reader: JointReader,
        client: int,
        step_s: float,
    ) -> None:
        super().__init__({path: firm for path, (firm, _) in joints.items()}, step_s)
        self._step_s, self._reader = step_s, reader
        self._own = [reader.names.index(name) for _, name in joints]
        self._client, self._multibody = client, next(place.multibody for _, place in joints.values())
        self._links = [place.link for _, place in joints.values()]
        self._axes: IntArray = np.array([firm.axis for firm, _ in joints.values()])
        single = np.flatnonzero(self._axes < 0).tolist()
        self._single, self._of_single = span(single), [self._links[number] for number in single]
        self._balls = np.flatnonzero(self._axes == 0).tolist()  # their first coordinates
        own = [firm.joint for firm, _ in joints.values()]
        self._frictions = [joint.friction for joint in own]
        self._limits = [min(joint.effort, UNLIMITED_FORCE) for joint in own]
        # numbers, links and limits of the joints with a target that are no ball joints
        self._led: tuple[IntArray, list[int], list[float]] = self.on, [], []
        self._learnt = np.zeros(len(joints))
        self._now, self._wanted = np.zeros((2, len(joints))), self.servos.paths["wanted"]
        self._times_s = np.array([step_s, STIFF_TIME_CONSTANT_S, RETURN_S, LEARNT_S])
        from nrp_core.world.engine_kit.firm_paths import turn_from  # compiled code takes time to load
        from nrp_world_pybullet.firm_steps import set_motor_targets

        self._aim_motors, self._turn_from = set_motor_targets, turn_from

    def _do_step(self, steps: int) -> None:
        servos, (positions, velocities) = self.servos, self._now
        states = self._states()
        positions[self._single] = [state[0] for state in states]
        if servos.moving:
            velocities[self._single] = [state[1] for state in states]
        for first in self._balls:
            three = slice(first, first + 3)
            turn, velocities[three], *_ = self._state_of_ball(first)
            self._turn_from(self.orientations[first], turn, servos.paths[three], positions[three])
        servos.moving = self._aim_motors(
            servos.moving, self._times_s, LARGEST, positions, velocities, self._learnt, servos.paths
        )
        numbers, links, limits = self._led
        wanted = self._wanted.take(numbers).tolist()
        mode, client = bullet.VELOCITY_CONTROL, self._client
        bullet.setJointMotorControlArray(
            self._multibody, links, mode, targetVelocities=wanted, forces=limits, physicsClientId=client
        )
        for first in self._balls:
            if servos.kinds[first] != FREE:
                self._turn_ball(first, self._wanted[first : first + 3].tolist(), self._limits[first])

    def _states(self) -> Sequence[Any]:
        """Return the states of the joints that are no ball joints."""
        links, client = self._of_single, self._client
        states: Sequence[Any] | None = bullet.getJointStates(self._multibody, links, client)
        return states or ()  # PyBullet returns None for none

    def _state_of_ball(self, first: int) -> Any:
        return bullet.getJointStateMultiDof(self._multibody, self._links[first], self._client)

    def _turn_ball(self, first: int, velocity: Sequence[float], limit: float, gain: float = GAIN) -> None:
        """Set the velocity of a ball joint, and the limit of its effort about each axis.

        PyBullet's motors of ball joints take no velocity. They go to an orientation: in a step by a share of
        the Euler angles to it, times a gain. With a large gain it is so near that these angles are those of a
        rotation vector. With a gain of 0 they are friction.
        """
        orientation = self._state_of_ball(first)[0]
        x, y, z = (each * self._step_s / (SHARE * GAIN) for each in velocity)
        bullet.setJointMotorControlMultiDof(
            self._multibody,
            self._links[first],
            bullet.POSITION_CONTROL,
            targetPosition=multiply(orientation, rotation_by((x, y, z))),
            positionGain=gain,
            force=[limit] * 3,
            physicsClientId=self._client,
        )

    def save(self) -> object:
        return super().save(), self._learnt.copy()

    def restore(self, saved: Any) -> None:
        common, learnt = saved
        super().restore(common)
        self._learnt[:] = learnt

    def _select(self) -> None:
        super()._select()
        on = self.on[self._axes[self.on] < 0]
        self._led = on, [self._links[number] for number in on], [self._limits[number] for number in on]

    def _do_efforts(self) -> FloatArray:
        return np.where(self.servos.kinds == FREE, 0.0, self._reader.efforts()[self._own])

    def _do_select(self, number: int) -> None:
        self._learnt[number] = 0.0
        if self.servos.kinds[number] != FREE:
            return
        friction = self._frictions[number]  # its motor acts as friction again
        if self._axes[number] == 0:
            self._turn_ball(number, (0.0, 0.0, 0.0), friction, gain=0.0)
        elif self._axes[number] < 0:
            link, mode, client = self._links[number], bullet.VELOCITY_CONTROL, self._client
            bullet.setJointMotorControl2(self._multibody, link, mode, force=friction, physicsClientId=client)
