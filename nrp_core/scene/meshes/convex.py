"""Meshes as convex pieces, which all engines collide quickly and in the same way.

Each connected piece of a mesh becomes its convex hull, so that the walls of a house leave its rooms free.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nrp_core._support.small_matrices import principal_axes, product
from nrp_core.scene.meshes.triangles import Points, Triangles, connected_pieces, weld_vertices

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

MAX_PIECES = 32
"""Maximum number of pieces; the largest are kept, the others are details such as screws and letters."""
MAX_CORNERS = 128
"""Maximum number of corners; a larger hull is replaced by its outermost corners in this many directions."""

_FLAT = 1e-3  # minimum thickness, as a share of the largest extent
_INSIDE = 1e-6


def convex_pieces(triangles: Triangles) -> list[Triangles]:
    """Return the hulls of the connected pieces, largest first, without those that lie inside another."""
    clouds = sorted(_connected(triangles), key=lambda cloud: -float(np.ptp(cloud, axis=0).max()))
    kept: list[npt.NDArray[np.float64]] = []
    pieces: list[Triangles] = []
    for cloud in clouds:
        if any((along(planes[:, :3], cloud) <= _INSIDE - planes[:, 3:]).all() for planes in kept):
            continue
        hull = simple_hull(_thick(cloud))
        kept.append(hull.equations)
        pieces.append(outward(hull))
        if len(pieces) == MAX_PIECES:
            break
    return pieces


def whole_hull(triangles: Triangles) -> Triangles:
    """Return the convex hull of a mesh with all its corners."""
    from scipy.spatial import ConvexHull

    points, _ = weld_vertices(triangles)
    return outward(ConvexHull(_thick(points)))


def _connected(triangles: Triangles) -> Iterator[Points]:
    """Yield the corners of each set of triangles that are connected by common corners."""
    points, faces = weld_vertices(triangles)
    count, labels = connected_pieces(points, faces)
    order = np.argsort(labels, kind="stable")
    yield from np.split(points[order], np.cumsum(np.bincount(labels, minlength=count))[:-1])


def simple_hull(points: Points) -> ConvexHull:
    """Return the hull of points, or if it has too many corners, of the outermost ones."""
    from scipy.spatial import ConvexHull

    if len(points) > 2 * MAX_CORNERS:
        rough = ConvexHull(_outermost(points))
        furthest = along(rough.equations[:, :3], points).argmax(axis=1)
        if len(np.unique(furthest)) > MAX_CORNERS:  # and each of them is a corner of the hull of all
            return rough
    hull = ConvexHull(points)
    if len(hull.vertices) > MAX_CORNERS:
        hull = ConvexHull(_outermost(points[hull.vertices]))
    return hull


def _thick(points: Points) -> Points:
    """Return points that span a volume: sheets and lines are given a thickness."""
    centre = points.mean(axis=0)
    axes = principal_axes(product((points - centre).T, points - centre))[1].T
    extents = np.ptp(product(points, axes.T), axis=0)
    least = _FLAT * max(float(extents.max()), 1e-6)
    for axis, extent in zip(axes, extents, strict=True):
        if extent < least:
            points = np.concatenate([points - least / 2 * axis, points + least / 2 * axis])
    return points


def _outermost(corners: Points) -> Points:
    """Return the corners that are furthest in each of many directions, spread evenly (Fibonacci's sphere)."""
    count = MAX_CORNERS - 6
    heights = 1 - (2 * np.arange(count) + 1) / count
    angles = np.arange(count) * pi * (3 - sqrt(5))
    level = np.sqrt(1 - heights**2)
    directions = np.stack([level * np.cos(angles), level * np.sin(angles), heights], axis=1)
    directions = np.concatenate([directions, np.eye(3), -np.eye(3)])
    extents = np.maximum(np.ptp(corners, axis=0), 1e-12)
    furthest: Points = corners[np.unique(along(directions, corners / extents).argmax(axis=1))]
    return furthest


def along(directions: Points, points: Points) -> npt.NDArray[np.float64]:
    """Return the position of each point along each direction, shape ``(directions, points)``."""
    # without BLAS, whose threads cost more than they gain for three columns
    far: npt.NDArray[np.float64] = np.einsum("ij,jk->ik", directions, np.ascontiguousarray(points.T))
    return far


def outward(hull: ConvexHull) -> Triangles:
    """Return the triangles of a hull, counter-clockwise as seen from outside."""
    triangles: Triangles = hull.points[hull.simplices]
    a, b, c = triangles.swapaxes(0, 1)
    normals = hull.equations[:, :3]
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), normals) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles
