"""ROS package control_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import message
from nrp_core.messages.std_msgs import Header
from nrp_core.messages.trajectory_msgs import JointTrajectoryPoint


@message("control_msgs/msg/JointTrajectoryControllerState")
class JointTrajectoryControllerState:
    """Desired and actual states of the joints of a controller, and the errors."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list)
    desired: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    actual: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    error: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
