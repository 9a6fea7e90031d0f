"""The rays of a laser."""

from __future__ import annotations

from functools import cache

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.scene.sensing import Laser


@cache
def directions(laser: Laser) -> FloatArray:
    """Return unit vectors along the rays in the laser's frame, layer by layer, shape ``(rays, 3)``."""
    angles = _spread(laser.angle_min, laser.angle_max, laser.samples)
    elevations = _spread(laser.elevation_min, laser.elevation_max, laser.layers)[:, None]
    level = np.cos(elevations)
    x, y = level * np.cos(angles), level * np.sin(angles)
    return np.stack([x, y, np.broadcast_to(np.sin(elevations), x.shape)], axis=2).reshape(-1, 3)


def _spread(first: float, last: float, count: int) -> FloatArray:
    return np.linspace(first, last, count) if count > 1 else np.zeros(1)
