"""Forces on bodies and joints besides drives, and measurements: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nrp_core.world.rigid.motion import BodyPath, JointAim, Touch, Wrench
from nrp_core.world.rigid.pose import Quaternion
from nrp_core.world.scene.merged_bodies import Body
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.firm import MujocoFirmJoints
from nrp_world_mujoco.library import mujoco


class Control:
    """Forces in one scene.

    Args:
        built: the scene.
        data: MuJoCo's state.
        step_s: the physics step.

    Attributes:
        firm: the joints that follow with any load.
    """

    def __init__(self, built: Built, data: Any, step_s: float) -> None:
        self._built, self._model, self._data, self._step_s = built, built.model, data, step_s
        self._force = np.empty(6)
        self.firm = MujocoFirmJoints(built, data, step_s)
        self.release()

    def aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Set the target of a joint's servo."""
        actuator = self._built.servos[model, joint]
        if (model, joint) in self._built.firm:
            if self.firm.aim((model, joint), aim):
                return
            if aim.firm is not None:
                aim = JointAim()
        damping = aim.damping
        if self._built.declared.get((model, joint)) != (aim.stiffness, aim.damping):
            # MuJoCo integrates velocities implicitly: with it the stiffness also acts at the step's end
            damping += aim.stiffness * self._step_s
        self._model.actuator_biasprm[actuator, :3] = 0.0, -aim.stiffness, -damping
        self._data.ctrl[actuator] = aim.stiffness * aim.position + aim.damping * aim.velocity + aim.effort

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation, or release it."""
        self.firm.orient(model, joint, orientation)

    def release(self) -> None:
        """Remove the targets of all servos."""
        for model, firm in ((model, firm) for (model, _), firm in self._built.firm.items() if firm.axis == 0):
            self.orient(model, firm.joint.name, None)
        for model, joint in self._built.servos:
            self.aim(model, joint, JointAim())

    def restore(self, firm: object) -> None:
        """Restore the firm joints from a state of theirs.

        Then a command to one that is led changes no gains, and these are not in MuJoCo's state.
        """
        self.firm.restore(firm)
        led = [self._built.servos[path] for path in self.firm.paths if path in self._built.servos]
        self._model.actuator_biasprm[led, :3] = 0.0

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""
        self._data.qfrc_applied[self._built.joints[model][joint]] = effort

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""
        model, index = body
        self._data.xfrc_applied[self._built.bodies[model][index][1]] = (*wrench.force, *wrench.torque)

    def touches(self) -> Iterator[Touch]:
        """Return the contacts of the last step."""
        owners = self._built.owners
        for number in range(self._data.ncon):
            contact = self._data.contact[number]
            one, other = owners[contact.geom[0]], owners[contact.geom[1]]
            if one[0] == other[0] or contact.efc_address < 0:
                continue
            mujoco.mj_contactForce(self._model, self._data, number, self._force)
            axes = contact.frame.reshape(3, 3)  # first the normal, from the first geom to the second
            fx, fy, fz = (-self._force[:3] @ axes).tolist()
            nx, ny, nz = (-axes[0]).tolist()
            x, y, z = contact.pos.tolist()
            yield Touch((one, other), (x, y, z), (nx, ny, nz), -float(contact.dist), (fx, fy, fz))

    def joint_wrench(self, _body: Body, place: int) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin."""
        mujoco.mj_rnePostConstraint(self._model, self._data)
        torque, force = self._data.cfrc_int[place, :3].copy(), self._data.cfrc_int[place, 3:].copy()
        # MuJoCo reports it at the centre of mass of the tree
        lever = self._data.subtree_com[self._model.body_rootid[place]] - self._data.xpos[place]
        torque += np.cross(lever, force)
        fx, fy, fz = (-force).tolist()
        tx, ty, tz = (-torque).tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz))
