"""Shapes as cached meshes: solids that not all engines have, extruded polygons and terrain."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, pairwise
from math import pi
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nrp_core._support.cache import cached_folder
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.stl import read_stl, write_stl
from nrp_core.scene.meshes.triangles import Profile, Triangles, arc, revolve
from nrp_core.scene.model import Heightmap

Ring = npt.NDArray[np.float64]
"""The corners of a closed line in the plane, shape ``(n, 2)``, m."""

_CLOSE = 1e-4  # m; as Gazebo, corners nearer than this are one


def extrude(rings: Sequence[Ring], height: float, *, convex: bool) -> list[Triangles]:
    """Return the solid within closed lines, from z = 0 upwards; a line within another is a hole.

    Args:
        rings: lines that do not cross.
        height: height, m.
        convex: whether to return convex prisms instead of one piece.

    Raises:
        ValueError: they enclose no volume.
    """
    prisms: list[Triangles] = []
    for polygon in _polygons([_open(ring) for ring in rings]):
        corners, faces = np.concatenate(polygon), _triangulated(polygon)
        if convex:
            outlines = (corners[piece] for piece in merge_faces(corners, faces.tolist()))
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
    """Return triangles of an outline with holes, counter-clockwise.

    Raises:
        SceneError: the package that cuts outlines is not installed.
    """
    try:
        from mapbox_earcut import triangulate_float64
    except ModuleNotFoundError:
        raise SceneError(
            "an outline needs the package mapbox-earcut: pip install 'nrp-core[models]'"
        ) from None

    corners = np.concatenate(polygon)
    ends = np.cumsum([len(ring) for ring in polygon]).astype(np.uint32)
    faces: npt.NDArray[np.int64] = triangulate_float64(corners, ends).reshape(-1, 3).astype(np.int64)
    areas = np.array([_area(corners[face]) for face in faces])
    faces[areas < 0] = faces[areas < 0, ::-1]
    solid: npt.NDArray[np.int64] = faces[areas != 0]
    return solid


def merge_faces(corners: Ring, faces: list[list[int]]) -> list[list[int]]:
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


Heights = npt.NDArray[np.float64]
"""Heights, shape ``(rows, columns)``, by increasing y and x."""

MAX_SAMPLES = 129
"""Maximum number of heights of a side; finer images are averaged."""


def heights_in(image: bytes) -> Heights:
    """Return the heights in an image, 0 for black and 1 for its brightest pixel.

    As in Gazebo, the corners of the image are those of the ground, and its top row is at the highest y.

    Raises:
        ValueError: it is not an image of at least 2 by 2 pixels, or too large.
    """
    from nrp_core._support.opencv import MAX_PIXELS, cv2, decode

    pixels = decode(image, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_GRAYSCALE)
    if pixels is None or min(pixels.shape) < 2:
        raise ValueError(
            f"is not an image of at least 2 by 2 and at most {MAX_PIXELS / 1e6:.0f} million pixels"
        )
    rows, columns = (min(side, MAX_SAMPLES) for side in pixels.shape)
    heights = cv2.resize(pixels.astype(np.float64), (columns, rows), interpolation=cv2.INTER_AREA)[::-1]
    return np.asarray(heights / (heights.max() or 1.0))


def terrain(heights: Heights) -> Triangles:
    """Return the surface of heights on a square of edge 1 about the origin.

    As in MuJoCo, each cell of the grid is divided into two triangles, from the highest y to the highest x.
    """
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, columns), np.linspace(-0.5, 0.5, rows))
    corners = np.stack([x, y, heights], axis=2)
    a, b, c, d = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]
    cells = np.stack([np.stack([a, b, d], axis=2), np.stack([b, c, d], axis=2)], axis=2)
    return cells.reshape(-1, 3, 3)


def heights_of(ground: Heightmap) -> Heights:
    """Return the heights in the file of a height map, before they are scaled."""
    x, y, z = read_stl(ground.path).reshape(-1, 3).T
    heights = np.empty((ground.rows, ground.columns))
    heights[_numbers(y, ground.rows), _numbers(x, ground.columns)] = z
    return heights


def _numbers(places: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.int64]:
    return np.rint((places + 0.5) * (count - 1)).astype(np.int64)


_PROFILES: dict[str, Profile] = {
    "ellipsoid": arc(1.0, -pi / 2, 0.0) + arc(1.0, 0.0, pi / 2)[1:],
    "cone": [(0.0, -0.5), (1.0, -0.5), (0.0, 0.5)],
}
_VERSION = 1


def cached_meshes(key: str, make: Callable[[], Sequence[Triangles]]) -> list[Path]:
    """Return the files of meshes, which are created at the first request.

    Args:
        key: names them and everything that they depend on.
        make: creates them.
    """

    def fill(folder: Path) -> None:
        for number, triangles in enumerate(make()):
            write_stl(folder / f"{key}-{number:04}.stl", triangles)

    folder = cached_folder("meshes", key, fill, lambda folder: any(folder.glob("*.stl")))
    return sorted(folder.glob("*.stl"))


def unit_solid(kind: str) -> Path:
    """Return the file of an ``ellipsoid`` or a ``cone`` about its centre, of radius 1; a cone is 1 m high."""

    def make() -> list[Triangles]:
        vertices, faces = revolve(_PROFILES[kind])
        return [vertices[faces]]

    (path,) = cached_meshes(f"unit-{kind}-{_VERSION}", make)
    return path


def kind_of_solid(path: Path) -> str | None:
    """Return what the file of a mesh is, of the kinds that have a unit solid."""
    return next((kind for kind in _PROFILES if path.stem == f"unit-{kind}-{_VERSION}-0000"), None)
