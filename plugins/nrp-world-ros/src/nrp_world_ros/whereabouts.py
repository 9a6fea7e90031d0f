"""Where the models of a scene are, as ROS tells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nrp_core.world import ModelMotion, Pose, Scene
from nrp_core.world.messages.gazebo_msgs import ModelStates
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.model_states import MODEL_STATES


class Whereabouts:
    """What was told last: by the topic that a simulator has, else by a drive's odometry, else by the files.

    Args:
        scene: the models, at the poses of their files.
        by_odometry: whether odometry is listened to.

    Attributes:
        topics: where it is told, with the types of messages.
    """

    def __init__(self, scene: Scene, *, by_odometry: bool = True) -> None:
        self._motions = {model.name: ModelMotion(model.pose) for model in scene.models}
        self._homes = dict(self._motions)
        self._odometers = {
            drive.odometry_topic: model.name
            for model in scene.models
            for drive in model.drives
            if by_odometry and drive.odometry_topic is not None
        }
        self._seen: set[str] = set()
        self.topics: dict[str, type] = {MODEL_STATES: ModelStates, **dict.fromkeys(self._odometers, Odometry)}

    def motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves, in the frame of the world."""
        return self._motions[model]

    def note(self, motions: Mapping[str, ModelMotion]) -> None:
        """Take over what is known of models otherwise."""
        self._motions.update(motions)

    def take(self, topic: str, message: Any) -> None:
        """Take in what was told."""
        if topic == MODEL_STATES:
            for name, pose, twist in zip(message.name, message.pose, message.twist, strict=True):
                if name in self._motions:
                    self._motions[name] = _motion(pose, twist)
                    self._seen.add(name)
        elif (name := self._odometers[topic]) not in self._seen:
            told = _motion(message.pose.pose, message.twist.twist)
            pose = self._homes[name].pose @ told.pose  # odometry begins where the model did,
            linear, angular = pose.rotate(told.linear), pose.rotate(told.angular)  # its twist is the body's
            self._motions[name] = ModelMotion(pose, linear, angular)


def _motion(pose: Any, twist: Any) -> ModelMotion:
    p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
    return ModelMotion(Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)), (v.x, v.y, v.z), (w.x, w.y, w.z))
