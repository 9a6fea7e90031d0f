"""Firm joints in MuJoCo: dry friction against a moving surface.

The solver computes the dry friction of a joint together with contacts, as a bounded force that takes the
velocity of the joint to 0. Here the bound is the limit of the servo, and the wanted velocity is written into
the constraint between the two halves of a step. The joint's own friction and damper do not act then, because
the solver of constraints does not see that dampers act at the end of a step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.world.engine_kit.firm_joints import FirmJoints
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_world_mujoco.build import FAR_AWAY, SMALLEST, Built
from nrp_world_mujoco.library import mujoco

_DAMPING = 1
"""The column of a constraint's parameters with the rate at which it takes its velocity to 0."""


class MujocoFirmJoints(FirmJoints):
    """The firm joints of one scene.

    Args:
        built: the scene.
        data: MuJoCo's state.
        step_s: the physics step.
    """

    def __init__(self, built: Built, data: Any, step_s: float) -> None:
        super().__init__(built.firm, step_s)
        self._model, self._data = built.model, data
        self._qpos, self._qvel = data.qpos, data.qvel
        self._dofs = np.array([built.joints[model][joint] for model, joint in self.paths], dtype=int)
        self._places = built.model.jnt_qposadr[built.model.dof_jntid[self._dofs]]
        self._frictions = np.array([firm.joint.friction for firm in built.firm.values()])
        self._dampers = self._model.dof_damping[self._dofs].copy()
        efforts = [firm.joint.effort for firm in built.firm.values()]
        self._limits = np.clip(efforts, SMALLEST, FAR_AWAY)  # without friction there is no constraint
        self._rows: IntArray = self.on  # of their constraints, after those of couplings

    def _do_step(self) -> None:
        model, data, servos = self._model, self._data, self.servos
        mujoco.mj_step1(model, data)
        positions = self._qpos.take(self._places)
        if servos.moving:
            servos.step(positions, self._qvel.take(self._dofs))
        rows = self._rows + data.ne
        damping = data.efc_KBIP[rows, _DAMPING]
        data.efc_aref[rows] += damping * servos.velocities(positions).take(self.on)
        mujoco.mj_step2(model, data)

    def restore(self, saved: Any) -> None:
        super().restore(saved)
        self._constrain()

    def _do_efforts(self) -> FloatArray:
        rows = self._rows + self._data.ne
        if rows.max() >= self._data.nefc:  # no step has been taken with all of them
            return np.zeros(len(self.on))
        efforts: FloatArray = self._data.efc_force[rows]
        return efforts

    def _do_select(self, number: int) -> None:
        self._constrain()

    def _constrain(self) -> None:
        """Constrain the joints that have a target, and give the others their dry friction and dampers."""
        losses = self._model.dof_frictionloss
        self._model.dof_damping[self._dofs] = np.where(self.servos.kinds == FREE, self._dampers, 0.0)
        losses[self._dofs] = self._frictions
        losses[self._dofs[self.on]] = self._limits[self.on]
        self._rows = np.searchsorted(np.flatnonzero(losses > 0), self._dofs[self.on])
