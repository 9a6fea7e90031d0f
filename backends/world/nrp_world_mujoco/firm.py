"""Firm joints in MuJoCo: dry friction against a moving surface.

The solver computes the dry friction of a joint together with contacts, as a bounded force that takes the
velocity of the joint to 0. Here the bound is the limit of the servo, and the wanted velocity is written into
the constraint between the two halves of a step. The joint's own friction and damper do not act then, because
the solver of constraints does not see that dampers act at the end of a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import COMPILED
from nrp_core.world.engine_kit.firm_joints import FirmJoints
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_servo import RETURN_S
from nrp_core.world.scene.joint_inertia import STIFF_TIME_CONSTANT_S
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.joints import FAR_AWAY, SMALLEST
from nrp_world_mujoco.library import halves_of_step, mujoco


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
        self._dofs = np.array([built.joints[model][joint] for model, joint in self.paths], dtype=int)
        self._frictions = np.array([firm.joint.friction for firm in built.firm.values()])
        self._dampers = self._model.dof_damping[self._dofs].copy()
        efforts = [firm.joint.effort for firm in built.firm.values()]
        self._limits = np.clip(efforts, SMALLEST, FAR_AWAY)  # without friction there is no constraint
        self._last = np.zeros(0)
        self._tried = False  # whether Python took a step from the present state with these constraints
        if self.paths:
            self._prepare(step_s, [firm.axis for firm in built.firm.values()])

    def _prepare(self, step_s: float, axes: Sequence[int]) -> None:
        from nrp_world_mujoco import firm_steps  # compiled code takes time to load
        from nrp_world_mujoco.state_layout import Constraints

        model, data = self._model, self._data
        self._steps = firm_steps
        self._joints = np.zeros(len(self.paths), firm_steps.LED)
        self._joints["axis"] = axes
        self._joints["dof"], self._last = self._dofs, self._joints["effort"]
        places = model.jnt_qposadr[model.dof_jntid[self._dofs]].astype(int)
        self._joints["position"] = data.qpos.ctypes.data + data.qpos.itemsize * places
        self._joints["velocity"] = data.qvel.ctypes.data + data.qvel.itemsize * self._dofs
        self._joints["guess"] = data.qacc_warmstart.ctypes.data + data.qvel.itemsize * self._dofs
        self._constraints = Constraints(data)
        halves = halves_of_step() if COMPILED else None
        self._calls = None if halves is None else np.array([*halves, model._address, data._address])
        times_s = np.array([step_s, STIFF_TIME_CONSTANT_S, RETURN_S])
        self._led = times_s, self._constraints.addresses, self._joints, self.orientations, self.servos.paths

    def _do_step(self, steps: int) -> None:
        servos = self.servos
        if self._tried and self._calls is not None and self._constraints.direct:
            steps, servos.moving = self._steps.take_steps(steps, self._calls, servos.moving, *self._led)
        for _ in range(steps):
            mujoco.mj_step1(self._model, self._data)
            self._constraints.find()
            servos.moving = self._steps.lead(servos.moving, *self._led)
            mujoco.mj_step2(self._model, self._data)
            self._tried = True
        if steps:
            self._steps.read_efforts(self._constraints.addresses, self._joints, self.servos.paths)

    def forget(self, model: str) -> None:
        super().forget(model)
        self._tried = False

    def restore(self, saved: Any) -> None:
        super().restore(saved)
        self._constrain()

    def _do_efforts(self) -> FloatArray:
        return self._last

    def _do_select(self, number: int) -> None:
        self._last[number] = 0.0
        self._constrain()

    def _constrain(self) -> None:
        """Constrain the joints that have a target, and give the others their dry friction and dampers."""
        losses = self._model.dof_frictionloss
        self._model.dof_damping[self._dofs] = np.where(self.servos.kinds == FREE, self._dampers, 0.0)
        losses[self._dofs] = self._frictions
        losses[self._dofs[self.on]] = self._limits[self.on]
        self._tried = False
