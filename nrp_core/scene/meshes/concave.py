"""Surfaces of static meshes that are not convex, such as the walls of a house or a terrain.

Their triangles do not change. Engines that only have convex shapes need the thickness of the solid behind
them, so that they can fill it with convex cells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.small_matrices import length, principal_axes, product
from nrp_core.scene.meshes.convex import MAX_CORNERS, MAX_PIECES, along, simple_hull
from nrp_core.scene.meshes.triangles import (
    Points,
    Surface,
    Triangles,
    area_of,
    connected_pieces,
    weld_vertices,
)

MAX_DEPTH = 0.05
"""Maximum depth of a cell behind the surface, m; deeper cells only help against objects above 25 m/s."""
SHEET = 0.01
"""Depth of the cells of an open surface that does not face upwards, m."""
MIN_DEPTH = 1e-3
"""Minimum depth of a cell, m; behind thinner sheets it stands out by less than this."""
LARGE = 512
"""Minimum number of triangles of a piece that is a part of its own."""
TOLERANCE = 0.02
"""Maximum difference between a convex mesh and its hull, as a share of its volume or area."""

_ON_HULL = 1e-3  # distance from the hull, as a share of the largest extent
_BALANCED = 1e-3  # maximum length of the sum of area vectors of a closed surface, as a share of its area
_OPEN_SHARE = 0.05  # maximum share of its edges that are edges of one triangle
_UPWARD = 0.5  # minimum mean of the vertical components of a ground's normals
_DOUBLED = 0.5  # minimum share of the faces of a sheet that are given from both sides
_THIN_SHARE = 0.02  # of a surface, behind which the solid may be thinner than the cells
_AT_ONCE = 500_000  # of these at once
_TESTS = 5_000_000  # maximum number of crossings that are computed for the thickness of a solid


def concave_parts(triangles: Triangles) -> list[Surface] | None:
    """Return the surface of a mesh in parts: large pieces, and the others by the depth of their cells.

    Returns:
        None if the connected pieces of the mesh are convex and few, so that their hulls are as exact.
    """
    pieces = list(_connected(triangles))
    if len(pieces) <= MAX_PIECES and not any(map(_is_concave, pieces)):
        return None
    outward = [_outward(_one_sided(piece)) for piece in pieces]
    depths = np.array([_depth(each, piece) for each, piece in zip(outward, pieces, strict=True)])
    classes = np.floor(np.log2(depths)).astype(int)
    large = np.array([len(piece) >= LARGE for piece in outward])
    parts = [_part([outward[i]], depths[i]) for i in np.flatnonzero(large)]
    for number in np.unique(classes[~large])[::-1]:  # the thickest first
        alike = np.flatnonzero(~large & (classes == number))
        parts.append(_part([outward[i] for i in alike], depths[alike].min()))
    return parts


def _one_sided(piece: Triangles) -> Triangles:
    """Return the first of all triangles with the same corners: many files have each face from both sides."""
    _, faces = weld_vertices(piece)
    _, firsts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return piece[np.sort(firsts)]


def _part(pieces: Sequence[Triangles], depth: float) -> Surface:
    return Surface(frozenset(), np.concatenate(pieces), depth=float(depth))


def _connected(triangles: Triangles) -> Iterator[Triangles]:
    """Yield the triangles that are connected by common corners."""
    points, faces = weld_vertices(triangles)
    count, labels = connected_pieces(points, faces)
    owners = labels[faces[:, 0]]
    order = np.argsort(owners, kind="stable")
    yield from np.split(triangles[order], np.cumsum(np.bincount(owners, minlength=count))[:-1])


def hull_excess(triangles: Triangles, hulls: Sequence[Triangles]) -> float:
    """Return the volume that hulls have in addition to their mesh, as a share of its volume.

    It is 0 for a mesh with open pieces, and for one with each face from both sides: these have no volume.
    """
    pieces = list(_connected(triangles))
    volume, filled = sum(abs(_volume(piece)) for piece in pieces), sum(map(_volume, hulls))
    if volume <= 1e-9 * filled or not all(map(_is_closed, pieces)):
        return 0.0
    return max(0.0, filled / volume - 1)


def _is_concave(piece: Triangles) -> bool:
    """Return whether a hull differs from a piece: in volume, or in area if the piece is open or flat."""
    from scipy.spatial import ConvexHull, QhullError

    points = piece.reshape(-1, 3)
    middle = points.mean(axis=0)
    axes = principal_axes(product((points - middle).T, points - middle))[1][:, ::-1]  # the longest first
    flattened = product(points - middle, axes)
    extents = np.ptp(flattened, axis=0)
    if extents[2] <= _ON_HULL * extents[0]:
        flat = flattened[:, :2] if extents[1] > _ON_HULL * extents[0] else None
        sides = 2 if _is_closed(piece) else 1
        return flat is not None and ConvexHull(flat).volume > (1 + TOLERANCE) * area_of(piece) / sides
    try:
        hull = ConvexHull(points)
    except QhullError:
        return False
    if not _is_closed(piece):
        inside = _heights(hull.equations, piece.mean(axis=1)) < -_ON_HULL * extents[0]
        return bool(inside.any()) or hull.area > (1 + TOLERANCE) * area_of(piece)
    volume = abs(_volume(piece))
    kept = simple_hull(np.unique(points, axis=0)).volume if len(hull.vertices) > MAX_CORNERS else hull.volume
    return bool(hull.volume > (1 + TOLERANCE) * volume or kept < (1 - TOLERANCE) * volume)


def _heights(equations: Points, points: Points) -> npt.NDArray[np.float64]:
    """Return the greatest height of each point above the planes of a hull, shape ``(n,)``."""
    heights = np.full(len(points), -np.inf)
    for plane in np.unique(np.round(equations, 9), axis=0):
        np.maximum(heights, product(points, plane[:3]) + plane[3], out=heights)
    return heights


def _is_closed(piece: Triangles) -> bool:
    """Return whether nearly each edge is the reverse of another, and area vectors cancel as around a solid.

    Many files of solids have a seam whose corners differ by rounding.
    """
    a, b, c = piece.swapaxes(0, 1)
    vectors = np.cross(b - a, c - a)
    if length(vectors.sum(axis=0)) > _BALANCED * np.linalg.norm(vectors, axis=1).sum():
        return False
    _, faces = weld_vertices(piece)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    size = faces.max() + 1
    ahead, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    return bool(np.isin(ahead, back, invert=True).mean() <= _OPEN_SHARE)


def _volume(piece: Triangles) -> float:
    """Return the volume in a surface, negative if its triangles face inwards (divergence theorem)."""
    a, b, c = (piece - piece.reshape(-1, 3).mean(axis=0)).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def _outward(piece: Triangles) -> Triangles:
    """Return triangles that face outwards; those of an open surface face whoever sees it."""
    return piece[:, ::-1] if _is_closed(piece) and _volume(piece) < 0 else piece


def _depth(piece: Triangles, given: Triangles) -> float:
    """Return the depth of cells that stay in the solid behind nearly all of its surface, m.

    An open surface has no inside: a ground is met from above, others from either side. So does a surface
    whose faces were given from both sides, closed or not.
    """
    a, b, c = piece.swapaxes(0, 1)
    is_sheet = not _is_closed(piece) and np.cross(b - a, c - a)[:, 2].sum() / 2 < _UPWARD * area_of(piece)
    most = SHEET if is_sheet or len(given) > (1 + _DOUBLED) * len(piece) else MAX_DEPTH
    count = int(np.clip(_TESTS // len(piece), 32, 256))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    shares = np.cumsum(areas) / areas.sum()
    sample, places = np.unique(np.searchsorted(shares, (np.arange(count) + 0.5) / count), return_inverse=True)
    thickness = _thickness(piece, sample, -normals[sample] / areas[sample, None])
    thin = float(np.quantile(thickness[places], _THIN_SHARE, method="lower"))
    return float(np.clip(thin, MIN_DEPTH, most))


def _thickness(piece: Triangles, sample: IntArray, rays: Points) -> FloatArray:
    """Return the distances along rays from the middles of triangles to the opposite surface, shape ``(k,)``.

    The formulas are those of Moeller and Trumbore, as products of matrices: a ray ``d`` from ``o`` meets the
    plane of a triangle at ``t = -(o - a) n / d n``.

    Args:
        piece: the triangles.
        sample: the triangles from which rays begin, shape ``(k,)``.
        rays: their directions, shape ``(k, 3)``.
    """
    a, b, c = (piece - piece.reshape(-1, 3).mean(axis=0)).swapaxes(0, 1)
    starts = (a + b + c)[sample] / 3
    first, second = b - a, c - a
    normals, heights = np.cross(first, second), np.einsum("nj,nj->n", a, np.cross(first, second))
    of_first, of_second = np.cross(a, first), np.cross(a, second)
    distances = np.full(len(sample), MAX_DEPTH)
    chunk = max(1, _AT_ONCE // len(piece))
    for begin in range(0, len(sample), chunk):
        part = slice(begin, begin + chunk)
        ray, start, own = rays[part], starts[part], sample[part]
        moment = np.cross(start, ray)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = -1 / along(ray, normals)
            u = (along(moment, second) + along(ray, of_second)) * scale
            v = -(along(moment, first) + along(ray, of_first)) * scale
            t = (along(start, normals) - heights) * scale
            met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > -1e-9)
        met[np.arange(len(own)), own] = False
        nearest = np.where(met, t, np.inf).min(axis=1)
        distances[part] = np.where(met.any(axis=1), nearest, MAX_DEPTH)
    return distances
