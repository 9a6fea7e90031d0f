"""Thin convex cells behind the surface of a mesh, for what has convex shapes only: MuJoCo, and moving bodies.

Triangles are first joined to nearly flat convex polygons, then polygons to cells where the surface is convex.
A cell is the hull of its polygons and of their copies moved into the solid.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from operator import mul
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.cache import cached_folder
from nrp_core._support.jit import jit
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.concave import concave_parts
from nrp_core.scene.meshes.convex import outward, simple_hull
from nrp_core.scene.meshes.stl import read_stl
from nrp_core.scene.meshes.triangles import Points, Triangles, weld_vertices
from nrp_core.scene.model import ConcaveMesh

MAX_ERROR = 2e-3
"""Maximum distance of a cell from the surface, m; less for thin solids and small meshes."""
MAX_SHARE = 5e-3
"""The same as a share of the largest extent."""
MAX_CORNERS = 32
"""Maximum number of corners of several polygons in one cell."""
MAX_HOLLOW = 64
"""Maximum number of hulls of a body that moves."""
MAX_SIDE = 0.4
"""Maximum side of the cubes in which its cells are merged, as a share of its largest extent."""

_FILE = "cells.npz"
_NONE = np.empty((0, 3))
_MIN_AREA = 1e-12  # m^2
_MIN_WIDTH = 1e-4  # m; nothing falls through narrower gaps
_ALIGNED = 0.8  # minimum cosine of the angle between polygons that are joined to one
_SMOOTH = 0.9  # the same across an edge where the surface continues
_PASSES = 4
_NARROWEST, _WIDER, _WIDEST = 1e-3, 2**0.25, 1e3  # m; sides of the cubes in which cells are merged


def cells(triangles: Triangles, depth: float) -> list[Points]:
    """Return the corners of each cell: those on the surface, then the same behind it.

    They are computed once for each version of this file and kept in the cache.

    Args:
        triangles: a surface whose triangles face outwards.
        depth: minimum thickness of the solid behind it, m.
    """
    sources = [triangles.tobytes(), repr((triangles.dtype.str, depth)).encode()]
    return _kept(sources, lambda: ([_computed(triangles, depth)], []))[0][0]


def cells_of_surfaces(uses: Mapping[ConcaveMesh, int], most: int) -> tuple[list[list[Points]], FloatArray]:
    """Return the cells of several surfaces, merged to hulls if too many, and cached as one entry.

    Args:
        uses: how often each surface is used.
        most: maximum number of cells, each counted as often as its surface is used.

    Returns:
        The cells of each surface, and for each with merged ones their greatest distance from it, m.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """

    def compute() -> tuple[list[list[Points]], list[float]]:
        found = [cells(_scaled(surface), surface.depth) for surface in uses]
        side = side_for([boxes_of(each) for each in found], list(uses.values()), most)
        if not side:
            return found, []
        merged = [merged_cells(each, side) for each in found]
        errors = [error for each, (made, error) in zip(found, merged, strict=True) if len(made) < len(each)]
        return [made for made, _ in merged], errors

    described = [(each.scale, each.depth, count) for each, count in uses.items()]
    try:
        files = [surface.path.read_bytes() for surface in uses]
    except OSError as error:
        raise SceneError(f"the mesh cannot be read: {error}", path=Path(str(error.filename))) from error
    return _kept([*files, repr((described, most)).encode()], compute)


def _scaled(surface: ConcaveMesh) -> Triangles:
    triangles = read_stl(surface.path) * surface.scale
    return triangles[:, ::-1] if np.prod(surface.scale) < 0 else triangles


def _kept(
    sources: Sequence[bytes], compute: Callable[[], tuple[list[list[Points]], Sequence[float]]]
) -> tuple[list[list[Points]], FloatArray]:
    """Return what ``compute`` returns, computed once for the same sources and version of this file."""
    digest = hashlib.blake2b(Path(__file__).read_bytes(), digest_size=16)
    for source in sources:
        digest.update(source)

    def fill(folder: Path) -> None:
        found, errors = compute()
        every = [corners for each in found for corners in each]
        counts, sizes = [len(each) for each in found], [len(each) for each in every]
        np.savez(folder / _FILE, counts, sizes, np.concatenate([_NONE, *every]), errors)

    folder = cached_folder("cells", digest.hexdigest(), fill, lambda folder: (folder / _FILE).is_file())
    with np.load(folder / _FILE) as kept:
        counts, sizes, corners, errors = (kept[f"arr_{number}"] for number in range(4))
    every = [corners[begin:end] for begin, end in _slices(sizes)]
    return [every[begin:end] for begin, end in _slices(counts)], errors


def _slices(sizes: FloatArray) -> Iterator[tuple[int, int]]:
    return pairwise([0, *np.cumsum(sizes, dtype=int).tolist()])


def boxes_of(found: Sequence[Points]) -> tuple[Points, Points]:
    """Return the lowest and highest coordinates of each cell, shape ``(n, 3)`` each."""
    if not found:
        return _NONE, _NONE
    starts = np.cumsum([0, *map(len, found[:-1])])
    corners = np.concatenate(found)
    return np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)


def cubes_of(low: Points, high: Points, side: float) -> IntArray:
    """Return a number for each box, the same for all whose centres are in one cube of the given side (m).

    A box with a larger extent has a number of its own.
    """
    places = np.floor((low + high - 2 * low.min(axis=0, initial=np.inf)) / (2 * side)).astype(np.int64)
    codes = places @ [1 << 42, 1 << 21, 1]
    large = (high - low).max(axis=1) > side
    codes[large] = -1 - np.flatnonzero(large)
    numbers: IntArray = np.unique(codes, return_inverse=True)[1]
    return numbers


def side_for(boxes: Sequence[tuple[Points, Points]], uses: Sequence[int], most: int) -> float:
    """Return the side (m) of the cubes in which cells must be merged to be at most ``most``; 0 if none.

    Args:
        boxes: :func:`boxes_of` the cells of each surface.
        uses: how often each surface is used.
        most: maximum number of cells; it is exceeded if each surface has one cell and that is too many.
    """
    counts, side = [len(low) for low, _ in boxes], 0.0
    while sum(map(mul, counts, uses)) > most and side < _WIDEST:
        side = side * _WIDER or _NARROWEST
        counts = [int(cubes_of(*each, side).max(initial=-1)) + 1 for each in boxes]
    return side


def hollow_pieces(triangles: Triangles) -> list[Triangles]:
    """Return a mesh that is not convex as few hulls that leave its inside free, such as that of a cup.

    Returns:
        Nothing if it is convex, or if it has so many cells that merging them would fill it.
    """
    found = [
        each for part in concave_parts(triangles) or () for each in cells(part.triangles, part.depth or 0.0)
    ]
    side = side_for([boxes_of(found)], [1], MAX_HOLLOW)
    if not found or side > MAX_SIDE * float(np.ptp(triangles.reshape(-1, 3), axis=0).max()):
        return []
    return [outward(simple_hull(corners)) for corners in (merged_cells(found, side)[0] if side else found)]


def merged_cells(found: Sequence[Points], side: float) -> tuple[list[Points], float]:
    """Return cells with one hull for all small ones in the same cube.

    Args:
        found: the cells of a surface.
        side: the side of the cubes, m; larger cells are not merged.

    Returns:
        The corners of each, and the greatest distance from the surface at the middles of their triangles, m.
    """
    if not found:
        return [], 0.0
    groups = cubes_of(*boxes_of(found), side)
    order = np.argsort(groups, kind="stable")
    members = np.split(order, np.cumsum(np.bincount(groups))[:-1])
    parts = [_hull([found[i] for i in each.tolist()]) for each in members]
    return [part for part, _ in parts], max(error for _, error in parts)


def _hull(members: Sequence[Points]) -> tuple[Points, float]:
    """Return the corners of the hull of cells, and the greatest distance of its sides from theirs, m."""
    if len(members) == 1:
        return members[0], 0.0
    points = np.concatenate(members)
    hull = simple_hull(points)
    middles = hull.points[hull.simplices].mean(axis=1)
    far = cdist(middles, points).min(axis=1).max()
    outside = (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max()
    return hull.points[hull.vertices], float(max(far, outside))


def _computed(triangles: Triangles, depth: float) -> list[Points]:
    corners, faces = weld_vertices(triangles)
    a, b, c = corners[faces].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    doubled = np.linalg.norm(normals, axis=1)
    solid = doubled > 2 * _MIN_AREA
    faces, normals, areas = faces[solid].astype(np.int64), normals[solid], doubled[solid] / 2
    normals = normals / doubled[solid, None]
    error = min(MAX_ERROR, depth / 4, MAX_SHARE * float(np.ptp(corners, axis=0).max(initial=0.0)))
    if not len(faces):
        return []
    twins = _twins(faces, len(corners))
    planes = np.column_stack([normals, np.einsum("ij,ij->i", normals, corners[faces[:, 0]])])
    owners, following = _polygons(corners, faces, planes, areas, twins, error)
    starts, ring, neighbours, kept = _rings(corners, faces, owners, following, twins)
    planes, areas = planes[starts[:-1, 1]], areas[starts[:-1, 1]]
    groups = _grown(corners, starts[:, 0].copy(), ring, neighbours, planes, error, depth / 2)
    return _thick(corners, starts[:, 0], ring, kept, planes[:, :3] * areas[:, None], groups, depth)


def _twins(faces: IntArray, count: int) -> IntArray:
    """Return the half-edge in the other direction of each half-edge, -1 for none or several.

    Half-edge ``3 i + j`` goes from corner ``j`` of triangle ``i`` to the next one.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    ahead, back = start * count + end, end * count + start
    order = np.argsort(ahead, kind="stable")
    ranked = ahead[order]
    first = np.searchsorted(ranked, back, side="left")
    alone = np.searchsorted(ranked, back, side="right") - first == 1
    twins = np.where(alone, order[np.minimum(first, len(order) - 1)], -1)
    mutual = twins[twins] == np.arange(len(twins))  # the twin of a doubled edge has no twin
    return np.where((twins >= 0) & mutual, twins, -1)


@jit
def _root(owners: IntArray, face: int) -> int:
    while owners[face] != face:
        owners[face] = owners[owners[face]]
        face = owners[face]
    return face


@jit
def _polygons(
    points: FloatArray,
    faces: IntArray,
    planes: FloatArray,
    areas: FloatArray,
    twins: IntArray,
    error: float,
) -> tuple[IntArray, IntArray]:
    """Join triangles as long as they make convex, nearly flat polygons (Hertel and Mehlhorn 1983).

    ``areas`` become those of the polygons.

    Returns:
        The triangle that represents the polygon of each triangle, and the half-edge after each one.
    """
    count = len(twins)
    owners = np.arange(len(faces))
    following, before = np.empty(count, np.int64), np.empty(count, np.int64)
    for edge in range(count):
        following[edge] = edge - 2 if edge % 3 == 2 else edge + 1
        before[edge] = edge + 2 if edge % 3 == 0 else edge - 1
    start = faces.ravel()
    for _ in range(_PASSES):
        joined = False
        for edge in range(count):
            if twins[edge] >= 0:
                joined |= _join(points, start, planes, areas, twins, owners, following, before, edge, error)
        if not joined:
            break
    for face in range(len(faces)):
        owners[face] = _root(owners, face)
    return owners, following


@jit
def _join(
    points: FloatArray,
    start: IntArray,
    planes: FloatArray,
    areas: FloatArray,
    twins: IntArray,
    owners: IntArray,
    following: IntArray,
    before: IntArray,
    edge: int,
    error: float,
) -> bool:
    """Join the polygons on both sides of an edge if that makes a nearly flat convex one."""
    one, other = _root(owners, edge // 3), _root(owners, twins[edge] // 3)
    if one == other or _cosine(planes[one], planes[other]) < _ALIGNED:
        return False
    first = last = edge  # all edges that the two share here
    while twins[following[last]] == before[twins[last]] and following[last] != first:
        last = following[last]
    while twins[before[first]] == following[twins[first]] and before[first] != last:
        first = before[first]
    ahead, after = before[first], following[last]
    beside, behind = before[twins[last]], following[twins[first]]
    if after == first or behind == twins[last]:
        return False
    large, small = (one, other) if areas[one] >= areas[other] else (other, one)
    convex = _turns_left(points, start, following, beside, after, planes[large])
    if not (convex and _turns_left(points, start, following, ahead, behind, planes[large])):
        return False
    if not _is_same(planes[one], planes[other]) and not (
        _is_near(points, start, following, behind, planes[one], error)
        and _is_near(points, start, following, after, planes[other], error)
    ):
        return False
    following[beside], before[after] = after, beside
    following[ahead], before[behind] = behind, ahead
    owners[small] = large
    areas[large] += areas[small]
    return True


@jit
def _cosine(plane: FloatArray, other: FloatArray) -> float:
    return float(plane[0] * other[0] + plane[1] * other[1] + plane[2] * other[2])


@jit
def _is_same(plane: FloatArray, other: FloatArray) -> bool:
    return _cosine(plane, other) > 1.0 - 1e-12 and abs(plane[3] - other[3]) < 1e-6


@jit
def _height(point: FloatArray, plane: FloatArray) -> float:
    return float(point[0] * plane[0] + point[1] * plane[1] + point[2] * plane[2] - plane[3])


@jit
def _is_near(
    points: FloatArray, start: IntArray, following: IntArray, edge: int, plane: FloatArray, error: float
) -> bool:
    """Return whether all corners of a polygon are close to a plane."""
    current = edge
    while True:
        if abs(_height(points[start[current]], plane)) > error:
            return False
        current = following[current]
        if current == edge:
            return True


@jit
def _turns_left(
    points: FloatArray, start: IntArray, following: IntArray, into: int, out: int, normal: FloatArray
) -> bool:
    """Return whether the corner between two edges is convex, as seen against a normal."""
    a, b = points[start[into]], points[start[out]]
    c = points[start[following[out]]]
    u, v, w = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x, y, z = c[0] - b[0], c[1] - b[1], c[2] - b[2]
    turn = normal[0] * (v * z - w * y) + normal[1] * (w * x - u * z) + normal[2] * (u * y - v * x)
    size = np.sqrt((u * u + v * v + w * w) * (x * x + y * y + z * z))
    return bool(turn > 1e-6 * size or (turn > -1e-6 * size and u * x + v * y + w * z > 0.0))


@jit
def _rings(
    points: FloatArray, faces: IntArray, owners: IntArray, following: IntArray, twins: IntArray
) -> tuple[IntArray, IntArray, IntArray, npt.NDArray[np.bool_]]:
    """Return the outlines of polygons.

    Returns:
        For each polygon the index of its first corner in the following arrays, and the triangle that
        represents it, with one more row for the end; for each corner its point, the polygon across the edge
        that begins there, -1 for none, and whether the outline turns there.
    """
    start, count = faces.ravel(), len(twins)
    numbers = np.full(len(faces), -1)
    first = np.full(len(faces), -1)
    polygons = 0
    inside = np.zeros(count, np.bool_)
    for edge in range(count):  # edges that were joined are not on an outline
        inside[edge] = twins[edge] >= 0 and owners[edge // 3] == owners[twins[edge] // 3]
    for edge in range(count):
        owner = owners[edge // 3]
        if not inside[edge] and numbers[owner] < 0:
            numbers[owner], first[polygons] = polygons, edge
            polygons += 1
    starts = np.empty((polygons + 1, 2), np.int64)
    ring, across, turns = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count, np.bool_)
    filled = 0
    for polygon in range(polygons):
        owner = owners[first[polygon] // 3]
        starts[polygon, 0], starts[polygon, 1] = filled, owner
        edge = first[polygon]
        while True:
            after = following[edge]
            ring[filled] = start[edge]
            across[filled] = numbers[owners[twins[edge] // 3]] if twins[edge] >= 0 else -1
            turns[filled + 1 if after != first[polygon] else starts[polygon, 0]] = _is_corner(
                points[start[edge]], points[start[after]], points[start[following[after]]]
            )
            filled += 1
            edge = after
            if edge == first[polygon]:
                break
    starts[polygons, 0], starts[polygons, 1] = filled, 0
    return starts, ring[:filled], across[:filled], turns[:filled]


@jit
def _is_corner(a: FloatArray, b: FloatArray, c: FloatArray) -> bool:
    """Return whether a line through three points turns at the second."""
    u, v, w = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x, y, z = c[0] - b[0], c[1] - b[1], c[2] - b[2]
    p, q, r = v * z - w * y, w * x - u * z, u * y - v * x
    return bool(p * p + q * q + r * r > 1e-10 * (u * u + v * v + w * w) * (x * x + y * y + z * z))


@jit
def _grown(
    points: FloatArray,
    starts: IntArray,
    ring: IntArray,
    neighbours: IntArray,
    planes: FloatArray,
    error: float,
    sag: float,
) -> IntArray:
    """Return the number of the cell of each polygon.

    Polygons are in one cell if none has a corner of another in front of it by more than ``error``, or
    far enough behind it to make the hull deeper than ``sag``.
    """
    count = len(planes)
    groups = np.full(count, -1)
    tested = np.full(count, -1)
    members = np.empty(MAX_CORNERS, np.int64)
    cell = 0
    for seed in range(count):
        if groups[seed] >= 0:
            continue
        groups[seed], members[0], size = cell, seed, 1
        corners, number = starts[seed + 1] - starts[seed], 0
        while number < size:
            member = members[number]
            number += 1
            for k in range(starts[member], starts[member + 1]):
                other = neighbours[k]
                if other < 0 or groups[other] >= 0 or tested[other] == cell:
                    continue
                tested[other] = cell
                more = starts[other + 1] - starts[other]
                if size == MAX_CORNERS or corners + more > MAX_CORNERS:
                    continue
                fits = True
                for i in range(size):
                    fits = fits and _cosine(planes[members[i]], planes[other]) > 0.0
                    fits = fits and _are_behind(
                        points, starts, ring, neighbours, planes, groups, cell, members[i], other, error, sag
                    )
                    fits = fits and _are_behind(
                        points, starts, ring, neighbours, planes, groups, cell, other, members[i], error, sag
                    )
                    if not fits:
                        break
                if fits:
                    groups[other], members[size] = cell, other
                    size, corners = size + 1, corners + more
        cell += 1
    return groups


@jit
def _are_behind(
    points: FloatArray,
    starts: IntArray,
    ring: IntArray,
    neighbours: IntArray,
    planes: FloatArray,
    groups: IntArray,
    cell: int,
    one: int,
    other: int,
    error: float,
    sag: float,
) -> bool:
    """Return whether the corners of another polygon are behind one, and within its outer edges."""
    plane, first, end = planes[one], starts[one], starts[one + 1]
    for k in range(starts[other], starts[other + 1]):
        height = _height(points[ring[k]], plane)
        # a chord is a fourth as far from an arc as its ends from a tangent, and half as far from an edge
        if height > 2.0 * error or height < -4.0 * sag:
            return False
    for k in range(first, end):
        beyond = neighbours[k]
        if beyond == other or (beyond >= 0 and groups[beyond] == cell):
            continue
        a, b = points[ring[k]], points[ring[k + 1 if k + 1 < end else first]]
        u, v, w = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        size = np.sqrt(u * u + v * v + w * w)
        outer = np.array(  # the plane through the edge and across the polygon
            [(v * plane[2] - w * plane[1]), (w * plane[0] - u * plane[2]), (u * plane[1] - v * plane[0]), 0.0]
        )
        outer /= size
        outer[3] = _height(a, outer)
        furthest = _highest(points, starts, ring, other, outer)
        if furthest <= error:
            continue
        if beyond < 0 or _cosine(plane, planes[beyond]) < _SMOOTH:
            return False
        # the hull covers the polygon beyond: it must reach as far, and must not be lower
        if _highest(points, starts, ring, beyond, outer) < furthest - error:
            return False
        if _highest(points, starts, ring, one, planes[beyond]) > 2.0 * error:
            return False
        if _highest(points, starts, ring, other, planes[beyond]) > 2.0 * error:
            return False
    return True


@jit
def _highest(points: FloatArray, starts: IntArray, ring: IntArray, polygon: int, plane: FloatArray) -> float:
    """Return the greatest height of a corner of a polygon above a plane."""
    height = -np.inf
    for k in range(starts[polygon], starts[polygon + 1]):
        height = max(height, _height(points[ring[k]], plane))
    return height


def _thick(
    points: Points,
    starts: IntArray,
    ring: IntArray,
    kept: npt.NDArray[np.bool_],
    vectors: Points,
    groups: IntArray,
    depth: float,
) -> list[Points]:
    """Return the corners of cells; one of several polygons has half the depth behind its hull."""
    count = int(groups.max(initial=-1)) + 1
    sums = np.stack([np.bincount(groups, vectors[:, axis], count) for axis in range(3)], axis=1)
    normals = sums / np.linalg.norm(sums, axis=1)[:, None]
    sizes = np.bincount(groups, minlength=count)
    depths = np.where(sizes > 1, depth / 2, depth)
    owners = np.repeat(groups, np.diff(starts))[kept]
    codes = owners * len(points) + ring[kept]
    _, firsts = np.unique(codes, return_index=True)
    firsts = np.sort(firsts)
    firsts = firsts[np.argsort(owners[firsts], kind="stable")]
    ends = np.cumsum(np.bincount(owners[firsts], minlength=count))[:-1]
    fronts = [points[front] for front in np.split(ring[kept][firsts], ends)]
    backs = normals * depths[:, None]
    return [
        np.concatenate([front, front - back])
        for front, back, width in zip(fronts, backs, _widths(fronts), strict=True)
        if width > _MIN_WIDTH
    ]


def _widths(fronts: Sequence[Points]) -> FloatArray:
    """Return the second extent of each set of points along its principal axes; 0 for fewer than three."""
    counts = np.array([len(front) for front in fronts])
    widths = np.zeros(len(fronts))
    for count in set(counts[counts > 2].tolist()):  # those of one size at once
        alike = np.flatnonzero(counts == count)
        corners = np.stack([fronts[each] for each in alike.tolist()])
        centred = corners - corners.mean(axis=1, keepdims=True)
        widths[alike] = np.linalg.svd(centred, compute_uv=False)[:, 1]
    return widths
