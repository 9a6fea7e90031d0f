"""Firm joints in PyBullet: its motors, which are constraints with a bounded force.

PyBullet solves all constraints of a step by some iterations that begin without forces, so that a chain of
joints would sag a little. Here the error that remains is learnt slowly, and the path moved by it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine_kit.firm_servo import FREE, POSITION, FirmServos
from nrp_core.world.rigid.motion import JointAim
from nrp_core.world.scene.model import Joint
from nrp_world_pybullet.build import UNLIMITED_FORCE, Place
from nrp_world_pybullet.library import bullet

JointPath = tuple[str, str]

LEARNT_S = 0.1
"""Time constant with which the error that remains is learnt, s."""
LARGEST = 0.005
"""The largest error that is learnt, rad or m; a joint that is pushed away further is not."""


class FirmJoints:
    """The firm joints of one multi-body.

    Args:
        joints: the joints with their handles, by model and joint.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(self, joints: Mapping[JointPath, tuple[Joint, Place]], client: int, step_s: float) -> None:
        self.numbers = {path: number for number, path in enumerate(joints)}
        self._client, self._multibody = client, next(place.multibody for _, place in joints.values())
        self._links = [place.link for _, place in joints.values()]
        self._frictions = [joint.friction for joint, _ in joints.values()]
        self._limits = np.array([min(joint.effort, UNLIMITED_FORCE) for joint, _ in joints.values()])
        self._servos = FirmServos([joint for joint, _ in joints.values()], step_s)
        self._on: list[int] = []  # numbers of the joints that are led
        self._step_s, self._learnt = step_s, np.zeros(len(joints))
        self._kept: FloatArray | None = None  # the efforts of the last step, if a state was restored

    @property
    def active(self) -> bool:
        """Whether a joint is led."""
        return bool(self._on)

    def aim(self, path: JointPath, aim: JointAim) -> None:
        """Set the target of a joint, or release it."""
        number = self.numbers[path]
        before = self._servos.kinds[number]
        self._servos.aim(number, aim)
        if before != self._servos.kinds[number]:
            self._select(number)

    def forget(self) -> None:
        """Let the paths begin anew where the joints are, because these were moved from outside."""
        self._servos.forget(range(len(self._links)))

    def push(self) -> None:
        """Set the motors for the next step."""
        servos, on = self._servos, self._on
        positions, velocities, _ = self._states()
        if servos.moving:
            servos.step(positions, velocities)
        more = self._learnt + (servos.positions - positions) * self._step_s / LEARNT_S
        self._learnt = np.where(servos.kinds == POSITION, more.clip(-LARGEST, LARGEST), 0.0)
        wanted = servos.velocities(positions - self._learnt)[on]
        self._set(on, targetVelocities=wanted.tolist(), forces=self._limits[on].tolist())
        self._kept = None

    def efforts(self) -> Iterator[tuple[JointPath, float]]:
        """Yield the efforts of the joints that are led in the last step."""
        if self._on:
            efforts, paths = self._total(self._states()[2]), list(self.numbers)
            yield from ((paths[number], float(efforts[number])) for number in self._on)

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self._servos.save(), self._learnt.copy(), self._total(self._states()[2])

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, learnt, self._kept = saved
        self._learnt = learnt.copy()
        self._servos.restore(servos)
        self._on = np.flatnonzero(self._servos.kinds != FREE).tolist()

    def _states(self) -> FloatArray:
        """Return positions, velocities and efforts of the motors, shape ``(3, n)``."""
        states = bullet.getJointStates(self._multibody, self._links, self._client)
        rows: FloatArray = np.array([(state[0], state[1], state[3]) for state in states]).T
        return rows

    def _total(self, motors: FloatArray) -> FloatArray:
        """Return the efforts in the last step; those of joints that are not led are 0."""
        if self._kept is not None:
            return self._kept
        led = np.isin(np.arange(len(motors)), self._on)
        return np.where(led, motors, 0.0)

    def _select(self, number: int) -> None:
        """Find the joints that are led; the motor of one that no longer is acts as friction again."""
        self._on = np.flatnonzero(self._servos.kinds != FREE).tolist()
        self._learnt[number] = 0.0
        if number not in self._on:
            self._set([number], targetVelocities=[0.0], forces=[self._frictions[number]])

    def _set(self, numbers: Sequence[int], **values: Sequence[float]) -> None:
        links, mode = [self._links[number] for number in numbers], bullet.VELOCITY_CONTROL
        bullet.setJointMotorControlArray(self._multibody, links, mode, **values, physicsClientId=self._client)
