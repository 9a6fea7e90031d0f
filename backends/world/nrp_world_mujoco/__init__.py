"""MuJoCo as a world backend; importing this package does not import MuJoCo."""

from __future__ import annotations

from nrp_world_mujoco.backend import MujocoBackend
from nrp_world_mujoco.options import MujocoOptions

__all__ = ["MujocoBackend", "MujocoOptions"]
