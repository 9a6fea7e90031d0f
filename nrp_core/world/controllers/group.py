"""Controllers of several joints by one topic: groups, and pairs by their mean and difference."""

from __future__ import annotations

from collections.abc import Mapping
from operator import le
from typing import Any, Generic, TypeVar

import numpy as np

from nrp_core.errors import TopicError
from nrp_core.world.controllers.joint import ControllerPart, Target, unit_of
from nrp_core.world.engine import Engine
from nrp_core.world.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.world.part import Part
from nrp_core.world.rigid import JointTargets
from nrp_core.world.scene.devices import GroupController, PairController, TrajectoryController
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo, require_finite

C = TypeVar("C", GroupController, PairController, TrajectoryController)


class JointGroup:
    """Leads joints of a model, firm ones with one call of the engine.

    Args:
        topic: the topic that leads them.
        parts: the controller part of each joint.
        model: their model.
        engine: the engine that moves it.
    """

    def __init__(self, topic: str, parts: Mapping[str, ControllerPart], model: str, engine: Engine) -> None:
        self._topic, self._model, self._engine = topic, model, engine
        self._joints, self._parts = tuple(parts), list(parts.values())
        self._firm = all(part.is_firm(topic) for part in self._parts)
        self._lowest, self._highest = zip(*(part.limits(topic) for part in self._parts), strict=True)
        self._targets = JointTargets(self._joints, (), (), smooth=True)
        self._holds = False

    def command(self, number: int) -> tuple[str, Target]:
        """Return the topic and the target of a joint that follows."""
        targets = self._targets
        rate = targets.rates[number] if targets.rates else 0.0
        return self._topic, Target(targets.values[number], rate, targets.smooth)

    def release(self) -> None:
        """One of the joints got another command."""
        self._holds = False

    def lead(self, targets: JointTargets, now_ns: int) -> None:
        """Make targets the commands of joints.

        Args:
            targets: the targets; faster if they are of all joints, in their order.
            now_ns: the time.
        """
        if self._holds and self._joints == targets.joints and self._retarget(targets):
            return
        rates = targets.rates or [0.0] * len(targets.joints)
        for joint, value, rate in zip(targets.joints, targets.values, rates, strict=True):
            part = self._parts[self._joints.index(joint)]
            part.lead(self._topic, Target(value, rate, targets.smooth), now_ns)
        if self._firm and len(targets.joints) == len(self._parts):
            kept = [part.target for part in self._parts]
            self._targets = JointTargets(
                self._joints, [each.value for each in kept], [each.rate for each in kept], targets.smooth
            )
            for number, part in enumerate(self._parts):
                part.follow(self, number)
            self._holds = True

    def _retarget(self, targets: JointTargets) -> bool:
        """Change the targets at once if the engine can, and if none is the first one beyond its limits."""
        values, lowest, highest = targets.values, self._lowest, self._highest
        if not (all(map(le, lowest, values)) and all(map(le, values, highest))):
            kept = [min(max(each), high) for *each, high in zip(values, lowest, highest, strict=True)]
            beyond = [number for number, value in enumerate(values) if kept[number] != value]
            if targets.rates or not all(self._parts[number].has_reported(self._topic) for number in beyond):
                return False
            targets = targets._replace(values=kept)
        if not self._engine.retarget(self._model, targets):
            return False
        self._targets = targets
        return True


class JointsPart(Part, Generic[C]):
    """Leads the joints of one controller of several joints.

    Args:
        controller: the data of the controller.
        parts: the controller part of each joint.
        model: the model of the joints.
        engine: the engine that moves it.
    """

    def __init__(
        self, controller: C, parts: Mapping[str, ControllerPart], model: Model, engine: Engine
    ) -> None:
        self._controller: C = controller
        self._model, self._engine = model, engine
        self._parts = {joint: parts[joint] for joint in controller.joints}
        self._open()

    def _open(self) -> None:
        """Set the topics, and what else the part needs."""
        raise NotImplementedError


class GroupPart(JointsPart[GroupController]):
    """Leads the joints of one :class:`~nrp_core.world.scene.devices.GroupController`."""

    def _open(self) -> None:
        controller, model = self._controller, self._model.name
        self._led = JointGroup(controller.topic, self._parts, model, self._engine)
        what = f"{controller.kind} of {', '.join(controller.joints)} of {model}"
        joints = tuple(controller.joints)
        topic = TopicInfo(controller.topic, Float64MultiArray, Direction.IN, what=what, elements=joints)
        self.topics = (topic,)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        joints = self._controller.joints
        if (count := len(message.data)) != len(joints):
            name = self._controller.name
            raise TopicError(f"{topic}: '{name}' has {len(joints)} joints; {count} numbers came")
        values = np.asarray(message.data, dtype=float).tolist()
        require_finite(topic, values)
        self._led.lead(JointTargets(joints, values, (), smooth=True), now_ns)


class PairPart(JointsPart[PairController]):
    """Leads the joints of one :class:`~nrp_core.world.scene.devices.PairController`."""

    def _open(self) -> None:
        controller, model = self._controller, self._model
        first, second = controller.joints
        unit = unit_of(model, first, controller.kind)
        what = f"{controller.kind} of {model.name}/{controller.name}, {unit}: "
        what += f"the {controller.of} of {first} and {second}"
        self.topics = (TopicInfo(controller.topic, Float64, Direction.IN, what=what, unit=unit),)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        controller = self._controller
        first, second = (part.target_now(controller.kind) for part in self._parts.values())
        values = controller.split(float(message.data), first, second)
        for part, value in zip(self._parts.values(), values, strict=True):
            part.lead(topic, Target(value), now_ns)
