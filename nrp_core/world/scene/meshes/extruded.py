"""Polygons with holes, extruded upwards: SDF's ``<polyline>``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.meshes.triangles import Triangles

Ring = npt.NDArray[np.float64]
"""The corners of a closed line in the plane, shape ``(n, 2)``, m."""

_CLOSE = 1e-4  # m; as Gazebo, corners nearer than this are one


def extruded(rings: Sequence[Ring], height: float, *, convex: bool) -> list[Triangles]:
    """Return the solid within closed lines, from z = 0 upwards; a line within another is a hole.

    Args:
        rings: lines that do not cross.
        height: height, m.
        convex: whether to return convex prisms instead of one piece.

    Raises:
        ValueError: they enclose nothing.
    """
    prisms: list[Triangles] = []
    for polygon in _polygons([_open(ring) for ring in rings]):
        corners, faces = np.concatenate(polygon), _triangulated(polygon)
        if convex:
            outlines = (corners[piece] for piece in _merged(corners, faces.tolist()))
            prisms += [_prism([outline], _fan(len(outline)), height) for outline in outlines]
        else:
            prisms.append(_prism(polygon, faces, height))
    if not prisms:
        raise ValueError("its points enclose no area")
    return prisms if convex else [np.concatenate(prisms)]


def _open(ring: Ring) -> Ring:
    """Return a line without consecutive equal corners."""
    apart = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1) > _CLOSE
    opened: Ring = ring[apart]
    return opened


def _polygons(rings: Sequence[Ring]) -> Iterator[list[Ring]]:
    """Yield outlines, counter-clockwise, each with its holes, clockwise."""
    rings = [ring for ring in rings if len(ring) > 2 and _area(ring)]
    around = [
        {i for i, other in enumerate(rings) if other is not ring and _holds(other, ring[0])} for ring in rings
    ]
    for number, ring in enumerate(rings):
        if len(around[number]) % 2 == 0:
            inner = around[number] | {number}
            holes = [_turning(hole, -1) for hole, outer in zip(rings, around, strict=True) if outer == inner]
            yield [_turning(ring, 1), *holes]


def _area(ring: Ring) -> float:
    """Return the area within a line, negative if it turns clockwise."""
    x, y = ring.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _turning(ring: Ring, sense: int) -> Ring:
    return ring if _area(ring) * sense > 0 else ring[::-1]


def _holds(ring: Ring, point: Ring) -> bool:
    """Return whether a point lies within a line: a ray from it crosses the line an odd number of times."""
    (x, y), (next_x, next_y) = (ring - point).T, (np.roll(ring, -1, axis=0) - point).T
    passes = (y > 0) != (next_y > 0)
    crossing = x[passes] - y[passes] * (next_x - x)[passes] / (next_y - y)[passes]
    return bool((crossing > 0).sum() % 2)


def _triangulated(polygon: Sequence[Ring]) -> npt.NDArray[np.int64]:
    """Return triangles of an outline with holes, counter-clockwise."""
    from mapbox_earcut import triangulate_float64

    corners = np.concatenate(polygon)
    ends = np.cumsum([len(ring) for ring in polygon]).astype(np.uint32)
    faces: npt.NDArray[np.int64] = triangulate_float64(corners, ends).reshape(-1, 3).astype(np.int64)
    areas = np.array([_area(corners[face]) for face in faces])
    faces[areas < 0] = faces[areas < 0, ::-1]
    solid: npt.NDArray[np.int64] = faces[areas != 0]
    return solid


def _merged(corners: Ring, faces: list[list[int]]) -> list[list[int]]:
    """Join triangles as long as they make convex polygons (Hertel and Mehlhorn 1983)."""
    pieces = {(a, b): face for face in faces for a, b in _edges(face)}
    for a, b in list(pieces):
        left, right = pieces.get((a, b)), pieces.get((b, a))
        if left is None or right is None or left is right:
            continue
        joined = _from(left, b) + _from(right, a)[1:-1]
        if _is_convex(corners[joined]):
            del pieces[a, b], pieces[b, a]
            pieces.update(dict.fromkeys(_edges(joined), joined))
    return list({id(piece): piece for piece in pieces.values()}.values())


def _edges(piece: list[int]) -> list[tuple[int, int]]:
    return list(zip(piece, piece[1:] + piece[:1], strict=True))


def _from(piece: list[int], corner: int) -> list[int]:
    start = piece.index(corner)
    return piece[start:] + piece[:start]


def _is_convex(ring: Ring) -> bool:
    along = np.roll(ring, -1, axis=0) - ring
    following = np.roll(along, -1, axis=0)
    turns = along[:, 0] * following[:, 1] - along[:, 1] * following[:, 0]
    return bool((turns >= -1e-12).all())


def _fan(count: int) -> npt.NDArray[np.int64]:
    return np.array([(0, i, i + 1) for i in range(1, count - 1)])


def _prism(rings: Sequence[Ring], faces: npt.NDArray[np.int64], height: float) -> Triangles:
    """Return the surface between two copies of a polygon, its inside on the left of its rings."""
    corners = np.concatenate(rings)
    low = np.column_stack([corners, np.zeros(len(corners))])
    high = low + np.array([0.0, 0.0, height])
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    sides = chain.from_iterable(_edges(list(range(*ends))) for ends in pairwise(starts))
    walls = [((low[a], low[b], high[b]), (low[a], high[b], high[a])) for a, b in sides]
    return np.concatenate([high[faces], low[faces[:, ::-1]], np.array(walls).reshape(-1, 3, 3)])
