"""ROS package gazebo_msgs; SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

from nrp_core.world.messages.base import message
from nrp_core.world.messages.geometry_msgs import Pose, Twist


@message("gazebo_msgs/msg/ModelStates")
@dataclass(slots=True)
class ModelStates:
    """Poses and velocities of all models in the frame of the world."""

    name: list[str] = field(default_factory=list)
    pose: list[Pose] = field(default_factory=list)
    twist: list[Twist] = field(default_factory=list)


@message("gazebo_msgs/msg/ModelState")
@dataclass(slots=True)
class ModelState:
    """Pose and velocity of one model, in the frame ``reference_frame`` (the world by default)."""

    model_name: str = ""
    pose: Pose = field(default_factory=Pose)
    twist: Twist = field(default_factory=Twist)
    reference_frame: str = "world"


@message("gazebo_msgs/msg/WheelSpeeds")
@dataclass(slots=True)
class WheelSpeeds:
    """Ground speed of each wheel in m/s: back left, back right, front left, front right."""

    back_left: float = 0.0
    back_right: float = 0.0
    front_left: float = 0.0
    front_right: float = 0.0
