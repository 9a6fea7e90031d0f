"""The topics of a run for clients, in the encoding of ROS 2."""
