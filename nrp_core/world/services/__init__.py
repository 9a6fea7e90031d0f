"""The services of Gazebo, in any world."""
