"""Where the models and their links are."""

from __future__ import annotations

from typing import Any

from nrp_core.world.messages import geometry_msgs
from nrp_core.world.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.world.parts.base import Engine, ModelMotion, Part
from nrp_core.world.parts.poses import state_messages
from nrp_core.world.scene.model import Scene
from nrp_core.world.topics import Direction, TopicInfo

MODEL_STATES = "/gazebo/model_states"
LINK_STATES = "/gazebo/link_states"

State = tuple[geometry_msgs.Pose, geometry_msgs.Twist]


class StatesPart(Part):
    """Serves the poses and velocities of all models and links under Gazebo's topic names."""

    topics = (
        TopicInfo(MODEL_STATES, ModelStates, Direction.OUT, None, "poses and velocities of all models"),
        TopicInfo(LINK_STATES, LinkStates, Direction.OUT, None, "poses and velocities of all links"),
    )

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._scene: Scene | None = None
        self._still: dict[str, State] = {}

    def read(self, topic: str, now_ns: int) -> Any:
        return self._models() if topic == MODEL_STATES else self._links()

    def _models(self) -> ModelStates:
        scene, engine = self._engine.scene, self._engine
        if scene is not self._scene:
            self._still = {m.name: state_messages(ModelMotion(m.pose)) for m in scene.models if m.static}
            self._scene = scene
        names = [model.name for model in scene.models]
        states = [self._still.get(name) or state_messages(engine.model_motion(name)) for name in names]
        return ModelStates(names, [pose for pose, _ in states], [twist for _, twist in states])

    def _links(self) -> LinkStates:
        engine = self._engine
        links = [(model, link) for model, link in engine.scene.links()]
        states = [
            state_messages(
                ModelMotion(model.pose @ link.pose)
                if model.static
                else engine.link_motion(model.name, link.name)
            )
            for model, link in links
        ]
        names = [f"{model.name}::{link.name}" for model, link in links]
        return LinkStates(names, [pose for pose, _ in states], [twist for _, twist in states])
