"""PyBullet as a world backend; importing this package does not import PyBullet."""

from __future__ import annotations

from nrp_world_pybullet.backend import PybulletBackend

__all__ = ["PybulletBackend"]
