"""Joint states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.sensor_msgs import JointState
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo


class JointStatesPart(Part):
    """Serves the joint states of one model, in the order of its file, then those of joints led in pairs."""

    def __init__(self, model: Model, engine: Engine) -> None:
        assert model.joint_states_topic is not None
        self._model, self._engine = model.name, engine
        self._pairs = list({pair.name: pair for pair in model.pair_controllers}.values())
        what = f"joints of {model.name}"
        self.topics = (TopicInfo(model.joint_states_topic, JointState, Direction.OUT, None, what),)

    def read(self, topic: str, now_ns: int) -> JointState:
        joints = self._engine.joint_states(self._model)
        header = Header(Time.from_ns(now_ns), self._model)
        names = [*joints.names, *(pair.name for pair in self._pairs)]
        efforts = np.append(joints.efforts, np.zeros(len(self._pairs)))
        positions, velocities = (
            self._with_pairs(row, joints.names) for row in (joints.positions, joints.velocities)
        )
        return JointState(header, names, positions, velocities, efforts)

    def _with_pairs(self, row: FloatArray, names: Sequence[str]) -> FloatArray:
        """Return values of joints, and the means and differences of those that are led in pairs."""
        values = dict(zip(names, row.tolist(), strict=True))
        return np.append(row, [pair.value(*(values[joint] for joint in pair.joints)) for pair in self._pairs])
