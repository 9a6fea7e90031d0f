"""What an engine is told about joints and actuators; a backend implements what its engine can."""

from __future__ import annotations

from abc import ABC
from typing import final

from nrp_core.errors import CapabilityError
from nrp_core.findings.refusals import JOINT_CONTROL, refusal
from nrp_core.world.rigid.motion import JointAim, JointTargets
from nrp_core.world.rigid.pose import Quaternion


class JointCommands(ABC):
    """The operations of an :class:`~nrp_core.world.engine.Engine` on joints and actuators."""

    @final
    def lacks(self, what: str) -> CapabilityError:
        """Return the error for an operation that the engine does not have."""
        return refusal(self, what)

    @final
    def set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Set the target of a joint's servo; only joints with a controller have one."""
        self._do_set_joint_aim(model, joint, aim)

    @final
    def set_ball_aim(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint with a controller to an orientation of its child, or release it."""
        self._do_set_ball_aim(model, joint, orientation)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        """Change the targets of firm joints at once, if the engine can, and return whether it did.

        It is faster than as many calls of :meth:`set_joint_aim`, which gave the joints their present targets.

        Args:
            model: the model.
            targets: its joints, and their targets.
        """
        return False

    @final
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort (N m, N) to a joint from now on, in addition to its servo."""
        self._do_set_joint_effort(model, joint, effort)

    def set_control(self, model: str, actuator: str, value: float) -> None:
        """Set the control of an actuator; implemented where ``own_actuators`` is declared."""
        raise self.lacks("has no actuators of its own")

    # -- for backends

    def _do_set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Set the target of the servo of a joint with a controller."""
        raise self.lacks(JOINT_CONTROL)

    def _do_set_ball_aim(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint with a controller to an orientation, or release it."""
        raise self.lacks("cannot lead ball joints to orientations")

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint from now on, in addition to its servo."""
        raise self.lacks(JOINT_CONTROL)
