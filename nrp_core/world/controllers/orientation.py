"""Ball joints that follow orientations."""

from __future__ import annotations

from math import isfinite, sqrt
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import Quaternion
from nrp_core.world.part import Part
from nrp_core.world.rigid.pose import Quaternion as Orientation
from nrp_core.world.scene.acting import JointController
from nrp_core.world.topics import Direction, TopicInfo

_TOLERANCE = 0.01
"""How far a quaternion may be from a unit quaternion; it is normalised."""


class OrientationPart(Part):
    """Leads a ball joint to the orientations of its controller.

    Args:
        controller: the data of the controller.
        model: the name of the model of the joint.
        engine: the engine that moves it.
    """

    def __init__(self, controller: JointController, model: str, engine: Engine) -> None:
        self._joint, self._model, self._engine = controller.joint, model, engine
        what = f"orientation of the child of {model}/{controller.joint} in the joint's frame"
        self.topics = (TopicInfo(controller.topic, Quaternion, Direction.IN, what=what),)
        self._wanted: Orientation | None = None

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        x, y, z, w = (float(each) for each in (message.x, message.y, message.z, message.w))
        norm = sqrt(x * x + y * y + z * z + w * w)
        if not (isfinite(norm) and abs(norm - 1.0) <= _TOLERANCE):
            raise TopicError(f"{topic}: ({x:g}, {y:g}, {z:g}, {w:g}) is not a unit quaternion")
        self._aim((x / norm, y / norm, z / norm, w / norm))

    def reset(self) -> None:
        self._wanted = None

    def save(self) -> object:
        return self._wanted

    def restore(self, saved: Any) -> None:
        if saved is not None or self._wanted is not None:
            self._aim(saved)

    def _aim(self, orientation: Orientation | None) -> None:
        self._wanted = orientation
        self._engine.set_ball_aim(self._model, self._joint, orientation)
