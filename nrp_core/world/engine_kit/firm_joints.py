"""The firm joints of an engine: their targets, efforts and state; the engine adds the constraints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_servo import FirmJoint, FirmServos
from nrp_core.world.rigid.motion import JointAim, JointStates, JointTargets
from nrp_core.world.rigid.pose import Quaternion

JointPath = tuple[str, str]
"""A model and its joint."""
Span = slice | IntArray
"""Places in an array."""


class FirmJoints(ABC):
    """Firm joints that an engine moves together.

    Args:
        joints: the joints, by path.
        step_s: the physics step.

    Attributes:
        paths: the joints, which are numbered in this order.
        servos: computes their velocities.
        orientations: the orientation (x, y, z, w) to which each coordinate of a ball joint is led, shape
            ``(n, 4)``; its position is that of the rotation vector from there, along the child's axes.
        on: numbers of the joints that have a target, ascending.
        active: whether there are any.
    """

    def __init__(self, joints: Mapping[JointPath, FirmJoint], step_s: float) -> None:
        self.paths = list(joints)
        self.servos = FirmServos(list(joints.values()), step_s)
        self.on: IntArray = np.zeros(0, dtype=int)
        self.active = False
        self.orientations: FloatArray = np.tile([0.0, 0.0, 0.0, 1.0], (len(joints), 1))
        self._numbers = {path: number for number, path in enumerate(self.paths)}
        self._groups: dict[tuple[str, tuple[str, ...]], Span] = {}
        self._columns: dict[str, tuple[Span, Span]] = {}
        self._restored: FloatArray | None = None

    def aim(self, path: JointPath, aim: JointAim) -> bool:
        """Set the target of a joint, or release it; return whether it was led before and after."""
        number = self._numbers[path]
        before = self.servos.kinds[number]
        self.servos.aim(number, aim)
        after = self.servos.kinds[number]
        if before != after:
            if self._restored is not None:
                self._restored[number] = 0.0
            self._select()
            self._do_select(number)
        return bool(before != FREE != after)

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation of its child, or release it."""
        numbers = [self._numbers[model, f"{joint}_{axis}"] for axis in "xyz"]
        aim = JointAim() if orientation is None else JointAim(stiffness=1.0, firm=True)
        for number in numbers:
            self.aim(self.paths[number], aim)
        if orientation is not None and (self.orientations[numbers] != orientation).any():
            self.orientations[numbers] = orientation
            self.servos.forget(numbers)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        """Change the targets of joints of a model, if all have one; return whether they have."""
        places = model, targets.joints
        if places not in self._groups:
            numbers = [self._numbers.get((model, joint), -1) for joint in targets.joints]
            if -1 in numbers or not self.servos.kinds[numbers].all():
                return False
            self._groups[places] = span(numbers)
        self.servos.retarget(self._groups[places], targets)
        return True

    def forget(self, model: str) -> None:
        """Restart the paths of a model's joints at their positions, because these were set from outside."""
        self.servos.forget([number for (owner, _), number in self._numbers.items() if owner == model])

    def step(self, steps: int = 1) -> None:
        """Prepare or take the next physics steps, as the engine requires."""
        self._do_step(steps)
        self._restored = None

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the last step to the states of a model's joints."""
        if self.active:
            if model not in self._columns:
                own = [number for number in self.on.tolist() if self.paths[number][0] == model]
                places = [states.names.index(self.paths[number][1]) for number in own]
                self._columns[model] = span(own), span(places)
            numbers, columns = self._columns[model]
            states.efforts[columns] += self._efforts()[numbers]

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self.servos.save(), self.orientations.copy(), self._efforts().copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, self.orientations[:], efforts = saved
        self._restored = efforts.copy()
        self.servos.restore(servos)
        self._select()

    def _efforts(self) -> FloatArray:
        return self._do_efforts() if self._restored is None else self._restored

    def _select(self) -> None:
        self.on = np.flatnonzero(self.servos.kinds != FREE)
        self.active = bool(self.on.size)
        self._columns.clear()
        self._groups.clear()

    @abstractmethod
    def _do_step(self, steps: int) -> None: ...

    @abstractmethod
    def _do_efforts(self) -> FloatArray:
        """Return the efforts of all joints in the last step, shape ``(n,)``; 0 without a target."""

    @abstractmethod
    def _do_select(self, number: int) -> None:
        """Constrain or release a joint, after it got its first target or lost its last one."""


def span(places: Sequence[int]) -> Span:
    """Return places, as a slice if they are neighbours, which is faster."""
    first = min(places, default=0)
    neighbours = slice(first, first + len(places))
    return neighbours if list(places) == list(range(neighbours.start, neighbours.stop)) else np.array(places)
