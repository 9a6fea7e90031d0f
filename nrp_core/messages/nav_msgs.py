"""ROS package nav_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import message
from nrp_core.messages.geometry_msgs import PoseWithCovariance, TwistWithCovariance
from nrp_core.messages.std_msgs import Header


@message("nav_msgs/msg/Odometry")
class Odometry:
    """A robot's estimate of its pose (in ``header.frame_id``) and velocity (in its own frame)."""

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)
