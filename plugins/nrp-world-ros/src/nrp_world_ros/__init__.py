"""ROS: bodies behind its topics as worlds of the platform, and worlds of the platform as such bodies."""

from nrp_world_ros.backend import RosBackend, RosOptions

__all__ = ["RosBackend", "RosOptions"]
