"""Controllers of single joints."""

from __future__ import annotations

from typing import Any

from nrp_core.clock import seconds
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.parts.base import Engine, JointAim, Part
from nrp_core.world.physics.bodies import bodies_of
from nrp_core.world.physics.joint_servo import joint_inertias, stiff_gains
from nrp_core.world.scene.acting import JointController
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo

_UNITS = {"position": "rad or m", "velocity": "rad/s or m/s", "effort": "N m or N"}


class ControllerPart(Part):
    """Serves the command of one :class:`~nrp_core.world.scene.acting.JointController`.

    A command holds until the next one. The engine's servo does the proportional and the derivative part in
    each physics step; an integral part is added up here.
    """

    def __init__(self, controller: JointController, model: Model, engine: Engine) -> None:
        self._controller, self._model, self._engine = controller, model.name, engine
        joint = next(joint for joint in model.joints if joint.name == controller.joint)
        self._gains = controller.gains or stiff_gains(
            joint_inertias(bodies_of(model))[joint.name], velocity=controller.kind == "velocity"
        )
        # who gives no gains wants the velocity itself, whatever brakes the joint
        self._braking = joint.damping if controller.gains is None else 0.0
        self._lower, self._upper = joint.lower, joint.upper
        if controller.kind == "effort":
            self._lower, self._upper = -joint.effort, joint.effort
        elif controller.kind == "velocity":
            self._lower, self._upper = -joint.velocity, joint.velocity
        what = f"{controller.kind} of {model.name}/{controller.joint}, {_UNITS[controller.kind]}"
        self.topics = (TopicInfo(controller.topic, Float64, Direction.IN, what=what),)
        self._target = controller.initial
        self._integral = 0.0

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._target = min(max(float(message.data), self._lower), self._upper)
        self._aim(now_ns)

    def at_deadline(self, now_ns: int) -> None:
        gains, step_s = self._gains, seconds(self._engine.step_ns)
        limit = gains.i_limit
        self._integral = min(max(self._integral + gains.i * self._error() * step_s, -limit), limit)
        self._aim(now_ns)

    def begin(self) -> None:
        if self._controller.initial is not None:
            self._aim(0)

    def reset(self) -> None:
        self._target, self._integral = self._controller.initial, 0.0
        self.deadline_ns = None

    def save(self) -> object:
        return self._target, self._integral, self.deadline_ns

    def restore(self, saved: Any) -> None:
        before = self._target
        self._target, self._integral, deadline_ns = saved
        if before is not None or self._target is not None:
            self._aim(0)
        self.deadline_ns = deadline_ns

    def _aim(self, now_ns: int) -> None:
        integrates = self._target is not None and self._gains.i and self._controller.kind != "effort"
        self.deadline_ns = now_ns + self._engine.step_ns if integrates else None
        self._engine.set_joint_aim(self._model, self._controller.joint, self._aimed())

    def _aimed(self) -> JointAim:
        target, gains = self._target, self._gains
        if target is None:
            return JointAim()
        if self._controller.kind == "position":
            return JointAim(gains.p, gains.d, position=target, effort=self._integral)
        if self._controller.kind == "velocity":
            effort = self._integral + self._braking * target
            return JointAim(damping=gains.p, velocity=target, effort=effort)
        return JointAim(effort=target)

    def _error(self) -> float:
        joints = self._engine.joint_states(self._model)
        index = joints.names.index(self._controller.joint)
        now = joints.positions if self._controller.kind == "position" else joints.velocities
        return 0.0 if self._target is None else self._target - float(now[index])
