"""What can be heard of a run, in the encoding of ROS 2."""
