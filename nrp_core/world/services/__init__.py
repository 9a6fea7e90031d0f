"""The services of Gazebo, for any world."""
