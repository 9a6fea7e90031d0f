"""Terrain: SDF's ``<heightmap>``, an image whose brightness is the height."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.meshes.stl import read_stl
from nrp_core.world.scene.meshes.triangles import Triangles
from nrp_core.world.scene.model import Heightmap

Heights = npt.NDArray[np.float64]
"""Heights, shape ``(rows, columns)``, by increasing y and x."""

MAX_SAMPLES = 129
"""Maximum number of heights of a side; finer images are averaged."""


def heights_in(image: bytes) -> Heights:
    """Return the heights in an image, 0 for black and 1 for its brightest pixel.

    As in Gazebo, the corners of the image are those of the ground, and its top row is at the highest y.

    Raises:
        ValueError: it is not an image of at least 2 by 2 pixels.
    """
    import cv2

    pixels = cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_GRAYSCALE)
    if pixels is None or min(pixels.shape) < 2:
        raise ValueError("is not an image of at least 2 by 2 pixels")
    rows, columns = (min(side, MAX_SAMPLES) for side in pixels.shape)
    heights = cv2.resize(pixels.astype(np.float64), (columns, rows), interpolation=cv2.INTER_AREA)[::-1]
    return np.asarray(heights / (heights.max() or 1.0))


def terrain(heights: Heights) -> Triangles:
    """Return the surface of heights on a square of edge 1 about the origin."""
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, columns), np.linspace(-0.5, 0.5, rows))
    corners = np.stack([x, y, heights], axis=2)
    a, b, c, d = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]
    cells = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return cells.reshape(-1, 3, 3)


def heights_of(ground: Heightmap) -> Heights:
    """Return the heights in the file of a height map, before they are scaled."""
    x, y, z = read_stl(ground.path).reshape(-1, 3).T
    heights = np.empty((ground.rows, ground.columns))
    heights[_numbers(y, ground.rows), _numbers(x, ground.columns)] = z
    return heights


def _numbers(places: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.int64]:
    return np.rint((places + 0.5) * (count - 1)).astype(np.int64)
