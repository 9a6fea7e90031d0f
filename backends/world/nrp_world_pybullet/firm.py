"""Firm joints in PyBullet: its motors, which are constraints with a bounded force.

PyBullet solves the constraints of a step by a number of iterations that begin without forces, so a chain of
joints would sag a little. Here the remaining error is learnt slowly, and the path is shifted by it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine_kit.firm_joints import FirmJoints, JointPath
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_servo import RETURN_S, FirmJoint
from nrp_core.world.scene.joint_inertia import STIFF_TIME_CONSTANT_S
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
        self._limits = [min(joint.effort, UNLIMITED_FORCE) for joint in own]
        self._led: tuple[list[int], list[float]] = [], []  # links and limits of the joints with a target
        self._learnt = np.zeros(len(joints))
        self._now, self._wanted = np.zeros((2, len(joints))), self.servos.paths["wanted"]
        self._times_s = np.array([step_s, STIFF_TIME_CONSTANT_S, RETURN_S, LEARNT_S])
        from nrp_world_pybullet.firm_steps import aim_motors  # compiled code takes time to load

        self._aim_motors = aim_motors

    def _do_step(self, steps: int) -> None:
        servos, (positions, velocities) = self.servos, self._now
        states = bullet.getJointStates(self._multibody, self._links, self._client)
        positions[:] = [state[0] for state in states]
        if servos.moving:
            velocities[:] = [state[1] for state in states]
        servos.moving = self._aim_motors(
            servos.moving, self._times_s, LARGEST, positions, velocities, self._learnt, servos.paths
        )
        links, limits = self._led
        wanted = self._wanted.take(self.on).tolist()
        mode, client = bullet.VELOCITY_CONTROL, self._client
        bullet.setJointMotorControlArray(
            self._multibody, links, mode, targetVelocities=wanted, forces=limits, physicsClientId=client
        )

    def save(self) -> object:
        return super().save(), self._learnt.copy()

    def restore(self, saved: Any) -> None:
        common, learnt = saved
        super().restore(common)
        self._learnt[:] = learnt

    def _select(self) -> None:
        super()._select()
        on = self.on.tolist()
        self._led = [self._links[number] for number in on], [self._limits[number] for number in on]

    def _do_efforts(self) -> FloatArray:
        states = bullet.getJointStates(self._multibody, self._links, self._client)
        return np.where(self.servos.kinds == FREE, 0.0, [state[3] for state in states])

    def _do_select(self, number: int) -> None:
        self._learnt[number] = 0.0
        if self.servos.kinds[number] == FREE:  # its motor acts as friction again
            link, mode = self._links[number], bullet.VELOCITY_CONTROL
            friction, client = self._frictions[number], self._client
            bullet.setJointMotorControl2(self._multibody, link, mode, force=friction, physicsClientId=client)
