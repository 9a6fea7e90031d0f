"""Surfaces of revolution: a profile rotated about z."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from nrp_core.world.scene.meshes.triangles import Faces, Points

SLICES = 32
"""Number of corners around the axis; the polygon deviates from its circle by up to 0.5 % of the radius."""
STACKS = 8
"""Number of steps from the equator of a sphere to a pole."""

Profile = Sequence[tuple[float, float]]
"""A profile: distances from the axis and heights, from below."""


def arc(radius: float, start: float, end: float) -> list[tuple[float, float]]:
    """Return the profile of a sphere between two angles above the equator."""
    angles = [start + (end - start) * i / STACKS for i in range(STACKS + 1)]
    return [(radius * cos(angle), radius * sin(angle)) for angle in angles]


def turned(profile: Profile) -> tuple[Points, Faces]:
    """Return the surface of a profile rotated about z, counter-clockwise as seen from outside."""
    around = np.arange(SLICES) * 2 * pi / SLICES
    rings = [
        np.stack([r * np.cos(around), r * np.sin(around), np.full(SLICES, z)], axis=1) for r, z in profile
    ]
    here = np.arange(SLICES)
    there = (here + 1) % SLICES
    faces = []
    for number, ((r, _), (next_r, _)) in enumerate(pairwise(profile)):
        low, high = number * SLICES, (number + 1) * SLICES
        if r > 0:
            faces.append(np.stack([low + here, low + there, high + there], axis=1))
        if next_r > 0:
            faces.append(np.stack([low + here, high + there, high + here], axis=1))
    return np.concatenate(rings), np.concatenate(faces).astype(np.int32)
