"""The poses of the models of a scene, from ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nrp_core.world import ModelMotion, Pose, Scene
from nrp_core.world.messages.gazebo_msgs import ModelStates
from nrp_core.world.messages.nav_msgs import Odometry

MODEL_STATES = "/gazebo/model_states"
"""The topic with the poses and velocities of all models, in Gazebo and in every world of the platform."""


class ModelPoses:
    """The last known states: from a simulator's topic, else from a drive's odometry, else from the files.

    Args:
        scene: the models, at the poses of their files.
        by_odometry: whether to use odometry.

    Attributes:
        topics: the topics of poses, with the types of their messages.
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
        """Return pose and velocity of a model's frame, in the frame of the world."""
        return self._motions[model]

    def note(self, motions: Mapping[str, ModelMotion]) -> None:
        """Set states of models that are known from elsewhere."""
        self._motions.update(motions)

    def take(self, topic: str, message: Any) -> None:
        """Update the states from a message."""
        if topic == MODEL_STATES:
            for name, pose, twist in zip(message.name, message.pose, message.twist, strict=True):
                if name in self._motions:
                    self._motions[name] = _motion(pose, twist)
                    self._seen.add(name)
        elif (name := self._odometers[topic]) not in self._seen:
            motion = _motion(message.pose.pose, message.twist.twist)
            pose = self._homes[name].pose @ motion.pose  # odometry begins where the model did,
            linear, angular = (
                pose.rotate(motion.linear),
                pose.rotate(motion.angular),
            )  # its twist is the body's
            self._motions[name] = ModelMotion(pose, linear, angular)


def _motion(pose: Any, twist: Any) -> ModelMotion:
    p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
    return ModelMotion(Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)), (v.x, v.y, v.z), (w.x, w.y, w.z))
