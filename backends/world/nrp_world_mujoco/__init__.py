"""MuJoCo as a world backend; importing this package does not import MuJoCo."""

from __future__ import annotations

from nrp_world_mujoco.backend import MujocoBackend

__all__ = ["MujocoBackend"]
