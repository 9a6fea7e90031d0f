"""ROS 2, by its own client library."""
