"""ROS 1 through rospy."""

from nrp_world_ros.ros1.load import INSTALL, load_rospy

__all__ = ["INSTALL", "load_rospy"]
