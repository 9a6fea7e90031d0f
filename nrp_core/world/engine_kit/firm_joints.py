"""The firm joints of an engine: their targets, efforts and state; the engine adds the constraints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_servo import FirmJoint, FirmServos
from nrp_core.world.rigid.motion import JointAim, JointStates

JointPath = tuple[str, str]
"""A model and its joint."""


class FirmJoints(ABC):
    """Firm joints that an engine moves together.

    Args:
        joints: the joints, by path.
        step_s: the physics step.

    Attributes:
        paths: the joints, which are numbered in this order.
        servos: computes their velocities.
        on: numbers of the joints that have a target, ascending.
        active: whether there are any.
    """

    def __init__(self, joints: Mapping[JointPath, FirmJoint], step_s: float) -> None:
        self.paths = list(joints)
        self.servos = FirmServos(list(joints.values()), step_s)
        self.on: IntArray = np.zeros(0, dtype=int)
        self.active = False
        self._numbers = {path: number for number, path in enumerate(self.paths)}
        self._restored: FloatArray | None = None

    def aim(self, path: JointPath, aim: JointAim) -> None:
        """Set the target of a joint, or release it."""
        number = self._numbers[path]
        before = self.servos.kinds[number]
        self.servos.aim(number, aim)
        if before != self.servos.kinds[number]:
            self._select()
            self._do_select(number)

    def forget(self, model: str) -> None:
        """Restart the paths of a model's joints at their positions, because these were set from outside."""
        self.servos.forget([number for (owner, _), number in self._numbers.items() if owner == model])

    def step(self) -> None:
        """Prepare or take the next physics step, as the engine requires."""
        self._do_step()
        self._restored = None

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the last step to the states of a model's joints."""
        if self.active:
            efforts = self._efforts()
            for number in self.on.tolist():
                owner, joint = self.paths[number]
                if owner == model:
                    states.efforts[states.names.index(joint)] += efforts[number]

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self.servos.save(), self._efforts()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, self._restored = saved
        self.servos.restore(servos)
        self._select()

    def _efforts(self) -> FloatArray:
        """Return the efforts of all joints in the last step, shape ``(n,)``; 0 without a target."""
        if self._restored is not None:
            return self._restored
        efforts = np.zeros(len(self.paths))
        if self.active:
            efforts[self.on] = self._do_efforts()
        return efforts

    def _select(self) -> None:
        self.on = np.flatnonzero(self.servos.kinds != FREE)
        self.active = bool(self.on.size)

    @abstractmethod
    def _do_step(self) -> None: ...

    @abstractmethod
    def _do_efforts(self) -> FloatArray:
        """Return the efforts in the last step of the joints that have a target, in their order."""

    @abstractmethod
    def _do_select(self, number: int) -> None:
        """Constrain or release a joint, after it got its first target or lost its last one."""
