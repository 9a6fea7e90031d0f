"""ROS package trajectory_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import Duration, array_field, message
from nrp_core.messages.std_msgs import Header


@message("trajectory_msgs/msg/JointTrajectoryPoint")
class JointTrajectoryPoint:
    """States of joints at a time; each array holds one number for each joint, or is empty."""

    positions: npt.NDArray[np.float64] = array_field()
    velocities: npt.NDArray[np.float64] = array_field()
    accelerations: npt.NDArray[np.float64] = array_field()
    effort: npt.NDArray[np.float64] = array_field()
    time_from_start: Duration = field(default_factory=Duration)


@message("trajectory_msgs/msg/JointTrajectory")
class JointTrajectory:
    """Points of a trajectory; their times count from the stamp of the header, or from now if that is 0."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list)
    points: list[JointTrajectoryPoint] = field(default_factory=list)
