"""Surfaces with one height at each place as grids of heights, which MuJoCo collides faster than cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit
from nrp_core.scene.meshes.triangles import Faces, Points

MIN_TRIANGLES = 512
"""Smaller surfaces stay triangles."""
MAX_SAMPLES = 1025
"""Maximum number of heights of a side."""
MAX_SHARE = 3e-4
"""Maximum error of the heights of 99 % of the corners and middles of triangles, as a share of the extent."""
ERRORS = 2e-3, 0.05
"""Least and greatest value of the maximum error, m."""
MAX_BELOW = 0.3
"""Depth (m) under the surface at which an object is beneath it, so that the solid must not be filled."""

_UPRIGHT = 1e-3  # minimum cosine of the slope of a triangle that counts
_UNCOVERED = 0.02  # maximum share of the rectangle without surface, all of it at the rim
_NEARLY_ALL = 0.99
_FINER = (1, 2, 4)  # samples for each corner of a side that are tried


@dataclass(frozen=True)
class Ground:
    """Heights on a rectangle.

    Args:
        low, high: corners of the rectangle, x and y in m.
        heights: m, by increasing y and x, shape ``(rows, columns)``.
    """

    low: FloatArray
    high: FloatArray
    heights: FloatArray

    def at(self, places: FloatArray) -> FloatArray:
        """Return the heights at places within the rectangle, shape ``(n, 2)``.

        As in MuJoCo each cell of the grid is two triangles, divided from the highest y to the highest x.
        """
        rows, columns = self.heights.shape
        x, y = ((places - self.low) / (self.high - self.low) * (columns - 1, rows - 1)).T
        i, j = (np.clip(np.floor(each), 0, end - 2).astype(int) for each, end in ((y, rows), (x, columns)))
        u, v, z = x - j, y - i, self.heights
        near = z[i, j] + u * (z[i, j + 1] - z[i, j]) + v * (z[i + 1, j] - z[i, j])
        far_corner = z[i + 1, j + 1]
        far = far_corner + (1 - u) * (z[i + 1, j] - far_corner) + (1 - v) * (z[i, j + 1] - far_corner)
        heights: FloatArray = np.where(u + v <= 1, near, far)
        return heights

    def is_above(self, points: Points) -> bool:
        """Return whether a point lies under the ground by more than :data:`MAX_BELOW`."""
        over = points[((points[:, :2] > self.low) & (points[:, :2] < self.high)).all(axis=1)]
        return bool((self.at(over[:, :2]) - over[:, 2] > MAX_BELOW).any())


def ground_of(vertices: Points, faces: Faces) -> Ground | None:
    """Return the ground with the surface of a mesh.

    Returns:
        None if the mesh is small, has no or several heights at some place in the rectangle around it except
        at its rim, or heights that a grid does not have well enough.
    """
    if len(faces) < MIN_TRIANGLES:
        return None
    a, b, c = vertices[faces].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    if normals[:, 2].sum() < -_UPRIGHT * np.abs(normals[:, 2]).sum():  # a closed surface has a sum of 0
        faces, normals = faces[:, ::-1], -normals
    up = normals[:, 2] > _UPRIGHT * np.linalg.norm(normals, axis=1)
    low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    covered = float(normals[up, 2].sum()) / 2
    if abs(covered - np.prod(high - low)) > _UNCOVERED * covered:
        return None
    surface = np.ascontiguousarray(vertices[faces[up]])
    around = vertices[np.unique(faces)]
    allowed = float(np.clip(MAX_SHARE * (high - low).max(), *ERRORS))
    tested = np.concatenate([surface.reshape(-1, 3), surface.mean(axis=1)])
    for columns, rows in _sizes(vertices[np.unique(faces[up])], high - low):
        heights = np.full((rows, columns), np.nan)
        _sample(surface, low, (high - low) / (columns - 1, rows - 1), heights)
        if not _fill_rim(heights):
            return None
        ground = Ground(low, high, heights)
        if (around[:, 2] - ground.at(around[:, :2]) > 10 * allowed).any():
            return None
        if np.quantile(np.abs(tested[:, 2] - ground.at(tested[:, :2])), _NEARLY_ALL) <= allowed:
            return ground
    return None


def _sizes(points: Points, extent: FloatArray) -> list[tuple[int, int]]:
    """Return numbers of columns and rows that may suffice: those of the corners, or finer ones."""
    columns, rows = (len(np.unique(np.round(points[:, axis] / extent[axis], 6))) for axis in (0, 1))
    if columns * rows != len(points):
        share = np.sqrt(len(points) / np.prod(extent))
        columns, rows = (max(2, round(side * share)) for side in extent.tolist())
    sizes = [(times * (columns - 1) + 1, times * (rows - 1) + 1) for times in _FINER]
    return [size for size in sizes if max(size) <= MAX_SAMPLES and min(size) > 1]


def _fill_rim(heights: FloatArray) -> bool:
    """Set missing heights at the rim to those next to them; return whether none is missing elsewhere."""
    for lines in (heights, heights.T):
        rim = max(1, round(_UNCOVERED * len(lines)))
        for ahead in (lines, lines[::-1]):
            for i in range(rim)[::-1]:
                ahead[i] = np.where(np.isnan(ahead[i]), ahead[i + 1], ahead[i])
    return not np.isnan(heights).any()


@jit
def _sample(surface: FloatArray, low: FloatArray, step: FloatArray, heights: FloatArray) -> None:
    """Set the heights at which the vertical lines of a grid cross triangles."""
    rows, columns = heights.shape
    for triangle in surface:
        first = np.empty(2, np.int64)
        last = np.empty(2, np.int64)
        for axis in range(2):
            each = (triangle[:, axis] - low[axis]) / step[axis]
            first[axis] = max(0, int(np.ceil(each.min() - 1e-6)))
            last[axis] = min((columns, rows)[axis] - 1, int(np.floor(each.max() + 1e-6)))
        a, b, c = triangle[0], triangle[1], triangle[2]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        for row in range(first[1], last[1] + 1):
            y = low[1] + row * step[1]
            for column in range(first[0], last[0] + 1):
                x = low[0] + column * step[0]
                u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
                v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
                if u >= -1e-6 and v >= -1e-6 and u + v <= 1.0 + 1e-6:
                    heights[row, column] = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
