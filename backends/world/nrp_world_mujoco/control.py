"""Forces that drives do not exert, and measurements: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED
from nrp_core._support.small_matrices import product
from nrp_core.scene.merged_bodies import STIFF_TIME_CONSTANT_S, Body
from nrp_core.scene.rigid import BodyPath, Quaternion, ServoTarget, Touch, Wrench
from nrp_core.world.engine_kit.firm_joints import RETURN_S, FirmJoints
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.library import halves_of_step, mujoco
from nrp_world_mujoco.shapes import FAR_AWAY, SMALLEST


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
        self._limits = np.clip(efforts, SMALLEST, FAR_AWAY)  # without friction the constraint does not exist
        self._last = np.zeros(0)
        self._tried = False  # whether Python took a step from the present state with these constraints
        if self.paths:
            self._prepare(step_s, [firm.axis for firm in built.firm.values()])

    def _prepare(self, step_s: float, axes: Sequence[int]) -> None:
        from nrp_world_mujoco import firm_steps  # compiled code takes time to load
        from nrp_world_mujoco.firm_steps import Constraints

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


class Control:
    """Forces in one scene.

    Args:
        built: the scene.
        state: the state; MuJoCo's data if there are firm joints.
        step_s: the physics step.
        last_step: returns MuJoCo's data of the last step.

    Attributes:
        firm: the joints that follow with any load.
    """

    def __init__(self, built: Built, state: Any, step_s: float, last_step: Callable[[], Any]) -> None:
        self._built, self._model, self._state, self._step_s = built, built.model, state, step_s
        self._last_step = last_step
        self._servos: dict[tuple[str, tuple[str, ...]], tuple[IntArray, bool]] = {}
        self._gains, self._ctrl = self._model.actuator_biasprm[:, :3], state.ctrl
        self.firm = MujocoFirmJoints(built, state, step_s)
        self.release()

    def set_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo."""
        actuator = self._built.servos[model, joint]
        if (model, joint) in self._built.firm:
            if self.firm.set_target((model, joint), aim):
                return
            if aim.firm is not None:
                aim = ServoTarget()
        damping = aim.damping
        if (aim.stiffness, aim.damping) not in self._built.declared.get((model, joint), ()):
            # MuJoCo integrates velocities implicitly: with it the stiffness also acts at the step's end
            damping += aim.stiffness * self._step_s
        self._model.actuator_biasprm[actuator, :3] = 0.0, -aim.stiffness, -damping
        self._state.ctrl[actuator] = aim.stiffness * aim.position + aim.damping * aim.velocity + aim.effort

    def set_efforts(self, model: str, joints: tuple[str, ...], efforts: Any) -> bool:
        """Set the efforts of servos, unless one follows with any load; return whether they were set."""
        path = model, joints
        if path not in self._servos:
            paths = [(model, joint) for joint in joints]
            are_firm = any(each in self._built.firm for each in paths)
            found = [] if are_firm else [self._built.servos[each] for each in paths]
            self._servos[path] = np.array(found, int), bool(found)
        places, are_set = self._servos[path]
        if are_set:
            self._gains[places] = 0.0
            self._ctrl[places] = efforts
        return are_set

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation, or release it."""
        self.firm.orient(model, joint, orientation)

    def release(self) -> None:
        """Remove the targets of all servos."""
        for model, firm in ((model, firm) for (model, _), firm in self._built.firm.items() if firm.axis == 0):
            self.orient(model, firm.joint.name, None)
        for model, joint in self._built.servos:
            self.set_target(model, joint, ServoTarget())

    def restore(self, firm: object) -> None:
        """Restore the firm joints from a state of theirs.

        Then a command to one that is led changes no gains, and these are not in MuJoCo's state.
        """
        self.firm.restore(firm)
        led = [self._built.servos[path] for path in self.firm.paths if path in self._built.servos]
        self._model.actuator_biasprm[led, :3] = 0.0

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""
        self._state.qfrc_applied[self._built.joints[model][joint]] = effort

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""
        model, index = body
        self._state.xfrc_applied[self._built.bodies[model][index][1]] = (*wrench.force, *wrench.torque)

    def touches(self) -> Iterator[Touch]:
        """Return the contacts of the last step."""
        owners, data, found = self._built.owners, self._last_step(), np.empty(6)
        for number in range(data.ncon):
            contact = data.contact[number]
            one, other = owners[contact.geom[0]], owners[contact.geom[1]]
            if one[0] == other[0] or contact.efc_address < 0:
                continue
            mujoco.mj_contactForce(self._model, data, number, found)
            axes = contact.frame.reshape(3, 3)  # first the normal, from the first geom to the second
            fx, fy, fz = product(-found[:3], axes).tolist()
            nx, ny, nz = (-axes[0]).tolist()
            x, y, z = contact.pos.tolist()
            yield Touch((one, other), (x, y, z), (nx, ny, nz), -float(contact.dist), (fx, fy, fz))

    def joint_wrench(self, _body: Body, place: int) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin."""
        data = self._last_step()
        mujoco.mj_rnePostConstraint(self._model, data)
        torque, force = data.cfrc_int[place, :3].copy(), data.cfrc_int[place, 3:].copy()
        # MuJoCo reports it at the centre of mass of the tree
        lever = data.subtree_com[self._model.body_rootid[place]] - data.xpos[place]
        torque += np.cross(lever, force)
        fx, fy, fz = (-force).tolist()
        tx, ty, tz = (-torque).tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz))
