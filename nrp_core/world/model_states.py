"""Poses and velocities of models and links."""

from __future__ import annotations

from typing import Any

from nrp_core.world.engine import Engine
from nrp_core.world.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.world.part import Part
from nrp_core.world.pose_messages import state_messages
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.scene.model import Scene
from nrp_core.world.topics import Direction, TopicInfo

MODEL_STATES = "/gazebo/model_states"
LINK_STATES = "/gazebo/link_states"


class StatesPart(Part):
    """Publishes poses and velocities of all models and links on Gazebo's topics."""

    topics = (
        TopicInfo(MODEL_STATES, ModelStates, Direction.OUT, None, "poses and velocities of all models"),
        TopicInfo(LINK_STATES, LinkStates, Direction.OUT, None, "poses and velocities of all links"),
    )

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._scene: Scene | None = None

    def read(self, topic: str, now_ns: int) -> Any:
        return self._models() if topic == MODEL_STATES else self._links()

    def _models(self) -> ModelStates:
        if self._engine.scene is not self._scene:
            self._rebuild_parts()
        poses, twists = self._poses.copy(), self._twists.copy()
        for number, name in self._moving:
            poses[number], twists[number] = state_messages(self._engine.model_motion(name))
        return ModelStates(self._names.copy(), poses, twists)

    def _rebuild_parts(self) -> None:
        """Prepare the data that change only with the scene: names, and the poses of static models."""
        self._scene = scene = self._engine.scene
        self._names = [model.name for model in scene.models]
        self._moving = [(i, model.name) for i, model in enumerate(scene.models) if not model.static]
        states = [state_messages(ModelMotion(model.pose)) for model in scene.models]
        self._poses, self._twists = [pose for pose, _ in states], [twist for _, twist in states]

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
