"""Bodies that another process simulates for one loop, behind ROS 2."""
