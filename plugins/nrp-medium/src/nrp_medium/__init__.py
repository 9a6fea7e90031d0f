"""Bodies in air and water: one force element, and the plugins of Gazebo's files that are read as one."""
