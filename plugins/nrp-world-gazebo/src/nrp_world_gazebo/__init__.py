"""Worlds in Gazebo 11, which runs in its own process and is stepped over a Unix socket."""

from nrp_world_gazebo.backend import GazeboBackend

__all__ = ["GazeboBackend"]
