"""Controllers of several joints at once, with a number for each."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from nrp_core.errors import TopicError
from nrp_core.world.controllers.joint import ControllerPart
from nrp_core.world.controllers.together import LedTogether
from nrp_core.world.engine import Engine
from nrp_core.world.messages.std_msgs import Float64MultiArray
from nrp_core.world.part import Part
from nrp_core.world.rigid.motion import JointTargets
from nrp_core.world.scene.acting import GroupController
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo


class GroupPart(Part):
    """Leads the joints of one :class:`~nrp_core.world.scene.acting.GroupController`.

    Args:
        controller: the data of the controller.
        parts: the controller part of each joint.
        model: the model of the joints.
        engine: the engine that moves it.
    """

    def __init__(
        self,
        controller: GroupController,
        parts: Mapping[str, ControllerPart],
        model: Model,
        engine: Engine,
    ) -> None:
        self._name, self._joints = controller.name, controller.joints
        own = {joint: parts[joint] for joint in controller.joints}
        self._led = LedTogether(controller.topic, own, model.name, engine)
        what = f"{controller.kind} of {', '.join(controller.joints)} of {model.name}"
        self.topics = (TopicInfo(controller.topic, Float64MultiArray, Direction.IN, what=what),)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        if len(message.data) != len(self._joints):
            count = len(self._joints)
            raise TopicError(f"{topic}: '{self._name}' has {count} joints; {len(message.data)} numbers came")
        values = np.asarray(message.data, dtype=float).tolist()
        if not isfinite(sum(values)) and not all(map(isfinite, values)):  # of a sum first: it is faster
            raise TopicError(f"{topic}: every number must be finite, not {values}")
        self._led.lead(JointTargets(self._joints, values, (), smooth=True), now_ns)
