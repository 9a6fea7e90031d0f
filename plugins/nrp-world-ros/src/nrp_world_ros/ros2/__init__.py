"""ROS 2, by way of DDS: no installation of ROS is needed."""

from nrp_world_ros.ros2.load import INSTALL, load_dds

__all__ = ["INSTALL", "load_dds"]
