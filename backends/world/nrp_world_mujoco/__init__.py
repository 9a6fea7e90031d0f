"""MuJoCo as a world backend; importing this package does not import MuJoCo."""

from __future__ import annotations

from nrp_world_mujoco.backend import MujocoBackend, MujocoOptions

__all__ = ["MujocoBackend", "MujocoOptions"]
