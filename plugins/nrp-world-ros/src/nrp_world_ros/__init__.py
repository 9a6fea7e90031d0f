"""ROS: robots and simulators behind its topics as worlds, and worlds of the platform as ROS simulators."""

from nrp_world_ros.backend import RosBackend
from nrp_world_ros.options import RosOptions

__all__ = ["RosBackend", "RosOptions"]
