"""Where the models are."""

from __future__ import annotations

from nrp_core.world.messages import geometry_msgs
from nrp_core.world.messages.gazebo_msgs import ModelStates
from nrp_core.world.parts.base import Engine, ModelMotion, Part
from nrp_core.world.scene.model import Scene
from nrp_core.world.topics import Direction, TopicInfo

MODEL_STATES = "/gazebo/model_states"


class ModelStatesPart(Part):
    """Serves the poses and velocities of all models under Gazebo's topic name."""

    topics = (
        TopicInfo(MODEL_STATES, ModelStates, Direction.OUT, None, "poses and velocities of all models"),
    )

    def __init__(self, scene: Scene, engine: Engine) -> None:
        self._engine = engine
        self._names = [model.name for model in scene.models]
        self._still = {m.name: state_messages(ModelMotion(m.pose)) for m in scene.models if m.static}

    def read(self, topic: str, now_ns: int) -> ModelStates:
        states = [self._still.get(n) or state_messages(self._engine.model_motion(n)) for n in self._names]
        return ModelStates(list(self._names), [pose for pose, _ in states], [twist for _, twist in states])


def pose_message(motion: ModelMotion) -> geometry_msgs.Pose:
    """Return the pose of a motion as a message."""
    position = geometry_msgs.Point(*motion.pose.position)
    return geometry_msgs.Pose(position, geometry_msgs.Quaternion(*motion.pose.orientation))


def state_messages(motion: ModelMotion) -> tuple[geometry_msgs.Pose, geometry_msgs.Twist]:
    """Return pose and velocity of a motion as messages."""
    linear = geometry_msgs.Vector3(*motion.linear)
    return pose_message(motion), geometry_msgs.Twist(linear, geometry_msgs.Vector3(*motion.angular))
