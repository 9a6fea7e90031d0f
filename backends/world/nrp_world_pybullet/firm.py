"""Firm joints in PyBullet: its motors, which are constraints with a bounded force.

PyBullet solves the constraints of a step by a number of iterations that begin without forces, so a chain of
joints would sag a little. Here the remaining error is learnt slowly, and the path is shifted by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine_kit.firm_joints import FirmJoints, JointPath
from nrp_core.world.engine_kit.firm_kinds import FREE, POSITION
from nrp_core.world.engine_kit.firm_servo import FirmJoint
from nrp_world_pybullet.build import UNLIMITED_FORCE, BodyHandle
from nrp_world_pybullet.library import bullet

LEARNT_S = 0.1
"""Time constant with which the remaining error is learnt, s."""
LARGEST = 0.005
"""The largest error that is learnt, rad or m; larger ones are due to a load beyond the limit of effort."""


class BulletFirmJoints(FirmJoints):
    """The firm joints of one multi-body.

    Args:
        joints: the joints with their handles, by path.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(
        self, joints: Mapping[JointPath, tuple[FirmJoint, BodyHandle]], client: int, step_s: float
    ) -> None:
        super().__init__({path: firm for path, (firm, _) in joints.items()}, step_s)
        self._client, self._multibody = client, next(place.multibody for _, place in joints.values())
        self._links = [place.link for _, place in joints.values()]
        own = [firm.joint for firm, _ in joints.values()]
        self._frictions = [joint.friction for joint in own]
        self._limits = np.array([min(joint.effort, UNLIMITED_FORCE) for joint in own])
        self._step_s, self._learnt = step_s, np.zeros(len(joints))

    def _do_step(self) -> None:
        servos, on = self.servos, self.on
        positions, velocities, _ = self._states()
        if servos.moving:
            servos.step(positions, velocities)
        more = self._learnt + (servos.positions - positions) * self._step_s / LEARNT_S
        self._learnt = np.where(servos.kinds == POSITION, more.clip(-LARGEST, LARGEST), 0.0)
        wanted = servos.velocities(positions - self._learnt)[on]
        self._set(on.tolist(), targetVelocities=wanted.tolist(), forces=self._limits[on].tolist())

    def save(self) -> object:
        return super().save(), self._learnt.copy()

    def restore(self, saved: Any) -> None:
        common, learnt = saved
        super().restore(common)
        self._learnt = learnt.copy()

    def _do_efforts(self) -> FloatArray:
        efforts: FloatArray = self._states()[2][self.on]
        return efforts

    def _do_select(self, number: int) -> None:
        self._learnt[number] = 0.0
        if self.servos.kinds[number] == FREE:  # its motor acts as friction again
            self._set([number], targetVelocities=[0.0], forces=[self._frictions[number]])

    def _states(self) -> FloatArray:
        """Return positions, velocities and efforts of the motors, shape ``(3, n)``."""
        states = bullet.getJointStates(self._multibody, self._links, self._client)
        rows: FloatArray = np.array([(state[0], state[1], state[3]) for state in states]).T
        return rows

    def _set(self, numbers: Sequence[int], **values: Sequence[float]) -> None:
        links, mode = [self._links[number] for number in numbers], bullet.VELOCITY_CONTROL
        bullet.setJointMotorControlArray(self._multibody, links, mode, **values, physicsClientId=self._client)
