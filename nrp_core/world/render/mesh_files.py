"""Triangle meshes in files: STL, binary or text, and the geometry of OBJ."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nrp_core.errors import SceneError

Vertices = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int32]

_STL_HEADER, _STL_COUNT = 80, 4
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_mesh(path: Path) -> tuple[Vertices, Faces]:
    """Return vertices, shape ``(n, 3)``, and triangles of their indices, shape ``(m, 3)``.

    Raises:
        SceneError: the file cannot be read as STL or OBJ, or holds no triangle.
    """
    try:
        data = path.read_bytes()
        vertices, faces = _obj(data) if path.suffix.lower() == ".obj" else _stl(data)
    except (OSError, ValueError, IndexError) as error:
        raise SceneError(f"the mesh cannot be read: {error}", path=path) from error
    if not len(faces):
        raise SceneError("the mesh has no triangles", path=path)
    return vertices, faces


def _stl(data: bytes) -> tuple[Vertices, Faces]:
    start = _STL_HEADER + _STL_COUNT
    count = int.from_bytes(data[_STL_HEADER:start], "little")
    if len(data) == start + count * _STL_TRIANGLE.itemsize:  # text may begin like binary, but not end like it
        corners = np.frombuffer(data, _STL_TRIANGLE, count, start)["corners"].reshape(-1, 3)
    else:
        rows = (line.split() for line in data.decode().splitlines())
        corners = np.array([row[1:4] for row in rows if row and row[0] == "vertex"], float).reshape(-1, 3)
    vertices = corners.astype(np.float64)
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


def _obj(data: bytes) -> tuple[Vertices, Faces]:
    rows = [line.split() for line in data.decode().splitlines()]
    vertices = np.array([row[1:4] for row in rows if row and row[0] == "v"], float).reshape(-1, 3)
    faces = [triangle for row in rows if row and row[0] == "f" for triangle in _fan(row[1:], len(vertices))]
    indices = np.array(faces, np.int32).reshape(-1, 3)
    if len(indices) and not (indices.min() >= 0 and indices.max() < len(vertices)):
        raise ValueError("a face names a vertex that is not there")
    return vertices, indices


def _fan(corners: list[str], count: int) -> Iterator[tuple[int, int, int]]:
    """Split a polygon, given as ``vertex/texture/normal`` counted from 1 or, negative, from the end."""
    numbers = [int(corner.split("/")[0]) for corner in corners]
    first, *others = (number - 1 if number > 0 else count + number for number in numbers)
    return ((first, a, b) for a, b in pairwise(others))
