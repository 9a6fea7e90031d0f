"""Formats of the cache: STL for meshes, and the mean colours of images."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np

from nrp_core._support.cache import cached_folder
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.triangles import Coordinates, Triangles


def mean_color(image: bytes | None) -> tuple[float, float, float] | None:
    """Return the mean red, green and blue of an image file, 0..1; None if it is missing or unreadable.

    It is computed once and cached.
    """
    if not image:
        return None

    def fill(folder: Path) -> None:
        from nrp_core._support.opencv import cv2, decode

        pixels = decode(image, cv2.IMREAD_COLOR)
        mean = () if pixels is None else cv2.sumElems(pixels)[2::-1]  # exact, as numpy's mean
        count = 1 if pixels is None else pixels.shape[0] * pixels.shape[1] * 255
        (folder / _MEAN).write_text(json.dumps([total / count for total in mean]))

    digest = hashlib.blake2b(image, digest_size=16).hexdigest()
    folder = cached_folder("colors", digest, fill, lambda folder: (folder / _MEAN).is_file())
    return tuple(json.loads((folder / _MEAN).read_text())) or None


_MEAN = "mean.json"
_HEADER, _COUNT = 80, 4
_COORDINATES = ".uv"
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def parse_stl(data: bytes) -> Triangles:
    """Return the triangles of an STL file.

    Raises:
        ValueError: it is neither text nor binary, or too short.
    """
    start = _HEADER + _COUNT
    count = int.from_bytes(data[_HEADER:start], "little")
    if len(data) == start + count * _TRIANGLE.itemsize:  # the size distinguishes binary files from text
        corners = np.frombuffer(data, _TRIANGLE, count, start)["corners"]
        return corners.astype(np.float64)
    try:
        rows = [line.split() for line in data.decode().splitlines()]
    except UnicodeDecodeError:
        raise ValueError(f"its {len(data)} bytes do not match its {count} triangles") from None
    return np.array([row[1:4] for row in rows if row and row[0] == "vertex"], float).reshape(-1, 3, 3)


def read_stl(path: Path) -> Triangles:
    """Return the triangles of a file.

    Raises:
        SceneError: it cannot be read, or has none.
    """
    try:
        triangles = parse_stl(path.read_bytes())
    except (OSError, ValueError) as error:
        raise SceneError(f"the mesh cannot be read: {error}", path=path) from error
    if not len(triangles):
        raise SceneError("the mesh has no triangles", path=path)
    return triangles


def write_stl(path: Path, triangles: Triangles) -> None:
    """Write a binary file, with normals for programs that use them."""
    path.write_bytes(stl_bytes(triangles))


def stl_bytes(triangles: Triangles) -> bytes:
    """Return the contents of a binary file."""
    records = np.zeros(len(triangles), _TRIANGLE)
    a, b, c = triangles.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    records["normal"] = normals / np.where(lengths, lengths, 1.0)
    records["corners"] = triangles
    count = len(triangles).to_bytes(_COUNT, "little")
    return bytes(_HEADER) + count + records.tobytes()


def write_coordinates(path: Path, coordinates: Coordinates) -> None:
    """Write the texture coordinates of the triangles of a file beside it."""
    path.with_suffix(_COORDINATES).write_bytes(coordinates.astype("<f4").tobytes())


def read_coordinates(path: Path) -> Coordinates | None:
    """Return the texture coordinates of the triangles of a file; None if it has none."""
    try:
        return np.fromfile(path.with_suffix(_COORDINATES), "<f4").reshape(-1, 3, 2)
    except (OSError, ValueError):
        return None
