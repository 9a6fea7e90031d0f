"""Joints."""

from __future__ import annotations

from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.sensor_msgs import JointState
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo


class JointStatesPart(Part):
    """Serves the joint states of one model, in the order of its file."""

    def __init__(self, model: Model, engine: Engine) -> None:
        assert model.joint_states_topic is not None
        self._model, self._engine = model.name, engine
        what = f"joints of {model.name}"
        self.topics = (TopicInfo(model.joint_states_topic, JointState, Direction.OUT, None, what),)

    def read(self, topic: str, now_ns: int) -> JointState:
        joints = self._engine.joint_states(self._model)
        header = Header(Time.from_ns(now_ns), self._model)
        return JointState(header, list(joints.names), joints.positions, joints.velocities, joints.efforts)
