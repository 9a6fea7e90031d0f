"""The rays of a scanner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.rigid import Pose

Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Beams:
    """Rays that spread evenly from one point, layer by layer.

    Args:
        pose: pose of the scanner in the frame of its link; angles are counter-clockwise from x, elevations
            towards z.
        samples: number of rays of a layer.
        angles: angles of the first and last ray of a layer, rad.
        layers: number of layers, from the lowest.
        elevations: elevations of the first and last layer, rad.
        reach: the minimum and maximum distance that is measured, m.
    """

    pose: Pose
    samples: int
    angles: Span
    layers: int
    elevations: Span
    reach: Span


@cache
def directions(beams: Beams) -> FloatArray:
    """Return unit vectors along the rays in the frame of the scanner, layer by layer, shape ``(rays, 3)``."""
    angles = _spread_angles(*beams.angles, beams.samples)
    elevations = _spread_angles(*beams.elevations, beams.layers)[:, None]
    level = np.cos(elevations)
    x, y = level * np.cos(angles), level * np.sin(angles)
    return np.stack([x, y, np.broadcast_to(np.sin(elevations), x.shape)], axis=2).reshape(-1, 3)


def _spread_angles(first: float, last: float, count: int) -> FloatArray:
    return np.linspace(first, last, count) if count > 1 else np.zeros(1)
