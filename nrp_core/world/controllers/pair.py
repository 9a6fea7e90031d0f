"""Controllers of two joints together: their mean and their difference."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nrp_core.world.controllers.joint import ControllerPart, Target, unit_of
from nrp_core.world.engine import Engine
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.part import Part
from nrp_core.world.scene.acting import PairController
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo


class PairPart(Part):
    """Leads the joints of one :class:`~nrp_core.world.scene.acting.PairController`.

    Args:
        controller: the data of the controller.
        parts: the controller part of each joint.
        model: the model of the joints.
        engine: the engine that moves it.
    """

    def __init__(
        self,
        controller: PairController,
        parts: Mapping[str, ControllerPart],
        model: Model,
        engine: Engine,
    ) -> None:
        self._controller = controller
        self._parts = [parts[joint] for joint in controller.joints]
        first, second = controller.joints
        unit = unit_of(model, first, controller.kind)
        what = f"{controller.kind} of {model.name}/{controller.name}, {unit}: "
        what += f"the {controller.of} of {first} and {second}"
        self.topics = (TopicInfo(controller.topic, Float64, Direction.IN, what=what, unit=unit),)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        controller = self._controller
        first, second = (part.aimed(controller.kind) for part in self._parts)
        values = controller.apart(float(message.data), first, second)
        for part, value in zip(self._parts, values, strict=True):
            part.lead(topic, Target(value), now_ns)
