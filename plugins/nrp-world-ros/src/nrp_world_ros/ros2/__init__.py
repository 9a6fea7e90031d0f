"""ROS 2 through DDS, without an installation of ROS."""

from nrp_world_ros.ros2.load import INSTALL, load_dds

__all__ = ["INSTALL", "load_dds"]
