"""Triangles of mesh files, before they are placed in a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.model import Rgba

Triangles = npt.NDArray[np.float64]
"""Corners of triangles, counter-clockwise as seen from outside; shape ``(m, 3, 3)``, in m."""
Points = npt.NDArray[np.float64]
"""Shape ``(n, 3)``, in m."""
Coordinates = npt.NDArray[np.float32]
"""Places in an image of the corners of triangles, from its lower left corner at 0, 0; shape ``(m, 3, 2)``."""
Faces = npt.NDArray[np.int32]
"""Indices of the corners of triangles, shape ``(m, 3)``."""

_MIXERS = np.array(
    [0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64
)  # large odd numbers


@dataclass(frozen=True)
class Surface:
    """Triangles of a file with the same look.

    Args:
        names: names in the file of the objects that contain them; a ``<submesh>`` names one of these.
        triangles: at least one.
        rgba: their colour, None if the file has none; with an image its mean.
        coordinates: texture coordinates, None if the file has none.
        image: the name in the file of the image on them, None for none.
        held: the contents of an image that is inside of the file.
    """

    names: frozenset[str]
    triangles: Triangles
    rgba: Rgba | None = None
    coordinates: Coordinates | None = None
    image: str | None = None
    held: bytes | None = None


def joined(surfaces: Sequence[Surface]) -> Triangles:
    """Return the triangles of several surfaces."""
    return np.concatenate([surface.triangles for surface in surfaces])


def merged(surfaces: Sequence[Surface]) -> Surface:
    """Return several surfaces as one with the look of the first."""
    coordinates = None
    if any(surface.coordinates is not None for surface in surfaces):
        coordinates = np.concatenate([_coordinates(surface) for surface in surfaces])
    return replace(surfaces[0], triangles=joined(surfaces), coordinates=coordinates)


def _coordinates(surface: Surface) -> Coordinates:
    if surface.coordinates is None:
        return np.zeros((len(surface.triangles), 3, 2), np.float32)
    return surface.coordinates


def welded(triangles: Triangles) -> tuple[Points, Faces]:
    """Return the distinct corners of triangles, and the indices of the triangles' corners."""
    points = triangles.reshape(-1, 3) + 0.0  # turns -0 into 0
    # numbers sort many times faster than rows; in the rare case that two rows are one number, rows are sorted
    bits = points.astype(np.float32).view(np.uint32).astype(np.uint64)
    numbers = (bits * _MIXERS).sum(axis=1, dtype=np.uint64)
    distinct, inverse = np.unique(numbers, return_inverse=True)
    corners = np.empty((len(distinct), 3))
    corners[inverse] = points
    if not np.array_equal(corners[inverse], points):
        corners, inverse = np.unique(points, axis=0, return_inverse=True)
    return corners, inverse.reshape(-1, 3).astype(np.int32)
