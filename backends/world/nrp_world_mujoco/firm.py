"""Firm joints in MuJoCo: dry friction against a moving surface.

The solver computes the dry friction of a joint together with contacts, as a force of bounded size that takes
the velocity of the joint to 0. Here the bound is the limit of the servo, and between the two halves of a step
the velocity that is aimed at is written into the constraint. The joint's own friction and damper do not act
then: the solver of constraints does not see that dampers act at the end of a step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.world.engine_kit.firm_servo import FREE, FirmServos
from nrp_core.world.rigid.motion import JointAim, JointStates
from nrp_world_mujoco.build import FAR_AWAY, SMALLEST, Built
from nrp_world_mujoco.library import mujoco

_DAMPING = 1
"""The column of a constraint's parameters with the rate at which it takes its velocity to 0."""


class FirmJoints:
    """The firm joints of one scene.

    Args:
        built: the scene.
        data: MuJoCo's state.
        step_s: the physics step.

    Attributes:
        active: whether a joint is led.
    """

    def __init__(self, built: Built, data: Any, step_s: float) -> None:
        self._model, self._data = built.model, data
        self._paths = list(built.firm)
        self._numbers = {path: number for number, path in enumerate(self._paths)}
        self._dofs = np.array([built.joints[model][joint] for model, joint in self._paths], dtype=int)
        self._places = built.model.jnt_qposadr[built.model.dof_jntid[self._dofs]]
        self._frictions = np.array([joint.friction for joint in built.firm.values()])
        self._dampers = self._model.dof_damping[self._dofs].copy()
        efforts = [joint.effort for joint in built.firm.values()]
        self._limits = np.clip(efforts, SMALLEST, FAR_AWAY)  # without friction there is no constraint
        self._servos = FirmServos(list(built.firm.values()), step_s)
        self.active = False
        self._on: IntArray = np.zeros(0, dtype=int)  # numbers of the joints that are led
        self._rows: IntArray = self._on  # of their constraints, after those of couplings
        self._efforts: FloatArray | None = None  # of the last step, if a state was restored

    def aim(self, path: tuple[str, str], aim: JointAim) -> None:
        """Set the target of a joint, or release it."""
        number = self._numbers[path]
        before = self._servos.kinds[number]
        self._servos.aim(number, aim)
        if before != self._servos.kinds[number]:
            self._select()

    def forget(self, model: str) -> None:
        """Let the paths of a model's joints begin anew, because these were moved from outside."""
        self._servos.forget([number for (owner, _), number in self._numbers.items() if owner == model])

    def step(self) -> None:
        """Take one physics step."""
        model, data, servos, on = self._model, self._data, self._servos, self._on
        mujoco.mj_step1(model, data)
        positions = data.qpos[self._places]
        if servos.moving:
            servos.step(positions, data.qvel[self._dofs])
        rows = self._rows + data.ne
        data.efc_aref[rows] += data.efc_KBIP[rows, _DAMPING] * servos.velocities(positions)[on]
        mujoco.mj_step2(model, data)
        self._efforts = None

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the servos in the last step."""
        if self.active:
            efforts = self._applied()
            for number, effort in zip(self._on.tolist(), efforts.tolist(), strict=True):
                owner, joint = self._paths[number]
                if owner == model:
                    states.efforts[states.names.index(joint)] += effort

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self._servos.save(), self._applied().copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, self._efforts = saved
        self._servos.restore(servos)
        self._select()

    def _applied(self) -> FloatArray:
        """Return the efforts of the last step, of the joints that are led."""
        if self._efforts is not None and len(self._efforts) == len(self._on):
            return self._efforts
        rows = self._rows + self._data.ne
        if not self.active or rows.max() >= self._data.nefc:  # no step has been taken with all of them
            return np.zeros(len(self._on))
        efforts: FloatArray = self._data.efc_force[rows]
        return efforts

    def _select(self) -> None:
        """Give the joints that are led their constraints, and the others their dry friction and dampers."""
        self._on = np.flatnonzero(self._servos.kinds != FREE)
        self.active = bool(self._on.size)
        losses = self._model.dof_frictionloss
        self._model.dof_damping[self._dofs] = np.where(self._servos.kinds == FREE, self._dampers, 0.0)
        losses[self._dofs] = self._frictions
        losses[self._dofs[self._on]] = self._limits[self._on]
        self._rows = np.searchsorted(np.flatnonzero(losses > 0), self._dofs[self._on])
