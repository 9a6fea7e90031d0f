"""Surfaces of static meshes that are not convex, such as the walls of a house or a terrain.

Their triangles stay as they are. Engines that only have convex shapes need the thickness of the solid behind
them, so that they can fill it with cells (:mod:`nrp_core.world.scene.meshes.cells`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from nrp_core.world.scene.meshes.convex import MAX_PIECES
from nrp_core.world.scene.meshes.triangles import Points, Surface, Triangles, weld_vertices

MAX_DEPTH = 0.05
"""Maximum depth of a cell behind the surface, m; deeper cells only help against objects above 25 m/s."""
MIN_DEPTH = 1e-3
"""Minimum depth of a cell, m; behind thinner sheets it stands out by less than this."""
LARGE = 512
"""Minimum number of triangles of a piece that is a part of its own."""
TOLERANCE = 0.02
"""Maximum share of the volume of a convex hull that its mesh may lack to count as convex."""

_ON_HULL = 1e-3  # distance from the hull, as a share of the largest extent
_THIN_SHARE = 0.02  # of a surface, behind which the solid may be thinner than the cells
_TESTS = 5_000_000  # maximum number of crossings that are computed for the thickness of a solid


def concave_parts(triangles: Triangles) -> list[Surface] | None:
    """Return the surface of a mesh in parts: large pieces, and the others by the depth of their cells.

    Returns:
        None if the connected pieces of the mesh are convex and few, so that their hulls are as exact.
    """
    pieces = list(_connected(triangles))
    hulls = [_hull_volume(piece) for piece in pieces]
    if len(pieces) <= MAX_PIECES and not any(map(_is_concave, pieces, hulls)):
        return None
    outward = [_outward(piece, volume) for piece, volume in zip(pieces, hulls, strict=True)]
    depths = np.array([_depth(piece) for piece in outward])
    classes = np.floor(np.log2(depths)).astype(int)
    large = np.array([len(piece) >= LARGE for piece in outward])
    parts = [_part([outward[i]], depths[i]) for i in np.flatnonzero(large)]
    for number in np.unique(classes[~large])[::-1]:  # the thickest first
        alike = np.flatnonzero(~large & (classes == number))
        parts.append(_part([outward[i] for i in alike], depths[alike].min()))
    return parts


def _part(pieces: Sequence[Triangles], depth: float) -> Surface:
    return Surface(frozenset(), np.concatenate(pieces), depth=float(depth))


def _connected(triangles: Triangles) -> Iterator[Triangles]:
    """Yield the triangles that are connected by common corners."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    points, faces = weld_vertices(triangles)
    ends = np.concatenate([faces[:, :2], faces[:, 1:]]).T
    links = coo_array((np.ones(ends.shape[1], bool), tuple(ends)), shape=(len(points), len(points)))
    count, labels = connected_components(links, directed=False)
    owners = labels[faces[:, 0]]
    order = np.argsort(owners, kind="stable")
    yield from np.split(triangles[order], np.cumsum(np.bincount(owners, minlength=count))[:-1])


def _hull_volume(piece: Triangles) -> float:
    """Return the volume of the convex hull; 0 for a flat piece."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(piece.reshape(-1, 3)).volume)
    except QhullError:
        return 0.0


def _is_concave(piece: Triangles, hull_volume: float) -> bool:
    """Return whether a piece has triangles within its hull, and lacks some of its volume if it is closed."""
    from scipy.spatial import ConvexHull

    extent = float(np.ptp(piece.reshape(-1, 3), axis=0).max())
    if hull_volume <= (_ON_HULL * extent) ** 3 or np.ptp(piece.reshape(-1, 3), axis=0).min() < 1e-9:
        return False
    planes = np.unique(np.round(ConvexHull(piece.reshape(-1, 3)).equations, 9), axis=0)
    centres = piece.mean(axis=1)
    heights = np.full(len(piece), -np.inf)
    for normal_and_offset in planes:
        np.maximum(heights, centres @ normal_and_offset[:3] + normal_and_offset[3], out=heights)
    if (heights > -_ON_HULL * extent).all():
        return False
    return not _is_closed(piece) or hull_volume > (1 + TOLERANCE) * abs(_volume(piece))


def _is_closed(piece: Triangles) -> bool:
    """Return whether each edge of a triangle is the reverse of one of another."""
    _, faces = weld_vertices(piece)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    size = faces.max() + 1
    ahead, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    return np.array_equal(np.sort(ahead), np.sort(back))


def _volume(piece: Triangles) -> float:
    """Return the volume in a surface, negative if its triangles face inwards (divergence theorem)."""
    a, b, c = (piece - piece.reshape(-1, 3).mean(axis=0)).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def _outward(piece: Triangles, hull_volume: float) -> Triangles:
    """Return triangles that face outwards; an open surface without an inside stays as it is."""
    return piece[:, ::-1] if _volume(piece) < -0.01 * hull_volume else piece


def _depth(piece: Triangles) -> float:
    """Return the depth of cells that stay in the solid behind nearly all of its surface, m."""
    if not _is_closed(piece):
        return MAX_DEPTH
    count = int(np.clip(_TESTS // len(piece), 32, 256))
    a, b, c = piece.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    shares = np.cumsum(areas) / areas.sum()
    sample, places = np.unique(np.searchsorted(shares, (np.arange(count) + 0.5) / count), return_inverse=True)
    thickness = np.array([_thickness(piece, i, -normals[i] / areas[i]) for i in sample])
    thin = float(np.quantile(thickness[places], _THIN_SHARE, method="lower"))
    return float(np.clip(thin, MIN_DEPTH, MAX_DEPTH))


def _thickness(piece: Triangles, number: int, ray: Points) -> float:
    """Return the distance (m) along a ray from a triangle to the opposite surface (Moeller and Trumbore)."""
    a, b, c = piece.swapaxes(0, 1)
    u_edge, v_edge, start = b - a, c - a, piece[number].mean(axis=0) - a
    p, q = np.cross(ray, v_edge), np.cross(start, u_edge)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / np.einsum("ij,ij->i", u_edge, p)
        u, v = np.einsum("ij,ij->i", start, p) * scale, q @ ray * scale
        t = np.einsum("ij,ij->i", v_edge, q) * scale
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-6)
    return float(t[met].min()) if met.any() else MAX_DEPTH
