"""Images on surfaces: the colour of each pixel whose face has a place in an image.

An image is kept in levels of half the size each (Williams, Pyramidal parametrics, SIGGRAPH 1983). A pixel
takes its colour from the level whose texels are about as large as it is, between the four nearest ones, so
that distant images do not flicker.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import floor, sqrt
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.render.pixels import NOTHING, NearnessArray
from nrp_core.world.scene.meshes.triangles import Coordinates
from nrp_core.world.scene.model import Texture

MAX_SIDE_PX = 1024
"""A larger image is reduced to this, which is more than cameras of robots resolve."""
_LEVELS = MAX_SIDE_PX.bit_length()
_PLAIN = -1
_SLACK = 1e-4

Levels = Sequence[npt.NDArray[np.uint8]]
"""An image, RGB, and itself in half the size, down to a pixel."""


class Textures:
    """The images on the visuals of a scene.

    Attributes:
        shown: which visuals show their image; one that gets another colour does not.

    Args:
        textures: the image on each visual, None for none.
        coordinates: texture coordinates of the corners of all faces, shape ``(m, 3, 2)``.
        surfaces: the visual of each face, shape ``(m,)``.
        triangles: the corners of the faces, shape ``(m, 3, 3)``, m.
    """

    def __init__(
        self,
        textures: Sequence[Texture | None],
        coordinates: Coordinates,
        surfaces: IndexArray,
        triangles: FloatArray,
    ) -> None:
        loaded = [levels_of(texture) if texture else None for texture in textures]
        images = [levels for levels in loaded if levels]
        self.shown = np.array([bool(levels) for levels in loaded], bool)
        numbers = np.cumsum(self.shown) - 1
        self._numbers = np.where(self.shown, numbers, _PLAIN).astype(np.int32)
        self._levels = np.zeros((max(1, len(images)), _LEVELS, 3), np.int32)
        texels, start = [np.zeros((1, 3), np.uint8)], 1
        for number, levels in enumerate(images):
            for level in range(_LEVELS):
                if level < len(levels):
                    height, width = levels[level].shape[:2]
                    row = start, height, width
                    texels.append(levels[level].reshape(-1, 3))
                    start += height * width
                self._levels[number, level] = row  # the smallest one stands for those below it
        self._texels = np.concatenate(texels)
        self._coordinates, self._surfaces = coordinates, surfaces
        sizes = self._levels[self._numbers[surfaces], 0, 1:].astype(float)[:, ::-1]
        self._density = _doubled_areas(coordinates * sizes[:, None]) / np.maximum(
            _doubled_areas(triangles), 1e-12
        )
        self._repeats = np.zeros(len(textures), bool)
        beyond = ((coordinates < -_SLACK) | (coordinates > 1 + _SLACK)).any(axis=(1, 2))
        self._repeats[surfaces[beyond]] = True

    def lay(
        self,
        seen: IndexArray,
        nearness: NearnessArray,
        focal: float,
        eye: FloatArray,
        points: FloatArray,
        faces: IndexArray,
        image: npt.NDArray[np.uint8],
    ) -> None:
        """Draw the images where they are seen.

        Args:
            seen: the face at each pixel, shape ``(height, width)``.
            nearness: reciprocals of their depths, of the same shape.
            focal: focal length, pixels.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            points: vertices in the world, shape ``(n, 3)``.
            faces: indices of vertices, shape ``(m, 3)``.
            image: RGB; pixels without an image stay as they are.
        """
        numbers = np.where(self.shown, self._numbers, _PLAIN).astype(np.int32)
        of_faces = (self._surfaces, numbers, self._repeats, self._coordinates, self._density)
        _lay(seen, nearness, focal, eye, points, faces, *of_faces, self._levels, self._texels, image)

    def covered(self, seen: IndexArray) -> npt.NDArray[np.bool_]:
        """Return at which pixels an image is seen."""
        faces = np.append(self.shown[self._surfaces], False)
        covered: npt.NDArray[np.bool_] = faces[seen]
        return covered


def levels_of(texture: Texture) -> Levels | None:
    """Return an image in its tint, in all levels; None if it cannot be read."""
    try:
        return _levels(texture.image, texture.tint, texture.image.stat().st_mtime_ns)
    except OSError:
        return None


@lru_cache(maxsize=64)
def _levels(path: Path, tint: tuple[float, ...], _changed_ns: int) -> Levels | None:
    import cv2

    try:
        pixels = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if pixels is None:
        return None
    size = np.array(pixels.shape[1::-1])
    if size.max() > MAX_SIDE_PX:
        size = np.maximum(1, np.rint(size * (MAX_SIDE_PX / size.max())).astype(int))
        pixels = cv2.resize(pixels, size.tolist(), interpolation=cv2.INTER_AREA)
    levels = [np.rint(pixels[..., ::-1] * np.clip(tint, 0, 1)).astype(np.uint8)]
    while size.max() > 1:
        size = np.maximum(1, size // 2)
        smaller = cv2.resize(levels[-1], size.tolist(), interpolation=cv2.INTER_AREA)
        levels.append(smaller.astype(np.uint8))
    return levels


def _doubled_areas(triangles: FloatArray | Coordinates) -> FloatArray:
    """Return twice the areas of triangles in a plane or in space, shape ``(m, 3, 2)`` or ``(m, 3, 3)``."""
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    if triangles.shape[2] == 2:
        return np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).astype(float)
    areas: FloatArray = np.linalg.norm(np.cross(u, v), axis=1)
    return areas


@jit
def _lay(
    seen: IndexArray,
    nearness: NearnessArray,
    focal: float,
    eye: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    surfaces: IndexArray,
    numbers: IndexArray,
    repeats: npt.NDArray[np.bool_],
    coordinates: Coordinates,
    density: FloatArray,
    levels: IndexArray,
    texels: npt.NDArray[np.uint8],
    image: npt.NDArray[np.uint8],
) -> None:
    height, width = seen.shape
    plane, inner = np.empty((4, 3)), np.empty(5)
    for row in range(height):
        face, number = NOTHING, _PLAIN
        for column in range(width):
            if seen[row, column] != face:  # usually the same as at the previous pixel
                face = seen[row, column]
                number = numbers[surfaces[face]] if face != NOTHING else _PLAIN
                if number != _PLAIN:
                    _measure(points, faces, face, plane, inner)
                    corners, repeating = coordinates[face], repeats[surfaces[face]]
            if number == _PLAIN:
                continue
            depth = 1.0 / nearness[row, column]
            pixel = depth / focal
            x, y = (column + 0.5 - width / 2) * pixel, (height / 2 - row - 0.5) * pixel
            second, third, slant = _weights(eye, x, y, depth, plane, inner)
            first = 1.0 - second - third
            u = first * corners[0, 0] + second * corners[1, 0] + third * corners[2, 0]
            v = first * corners[0, 1] + second * corners[1, 1] + third * corners[2, 1]
            texels_per_pixel = density[face] * pixel**2 / max(slant, 0.05)
            level, upper = 0, 2.0  # half of the logarithm, rounded
            while texels_per_pixel >= upper and level < levels.shape[1] - 1:
                level, upper = level + 1, 4.0 * upper
            start, high, wide = levels[number, level, 0], levels[number, level, 1], levels[number, level, 2]
            _mix(start, high, wide, texels, u, v, repeating, image, row, column)


@inlined
def _measure(points: FloatArray, faces: IndexArray, face: int, plane: FloatArray, inner: FloatArray) -> None:
    """Fill ``plane`` with the first corner of a face, two edges from it, and its normal.

    ``inner`` gets the inner products of the edges, and the reciprocals of the normal's square and length.
    """
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    uu = uv = vv = 0.0
    for axis in range(3):
        u, v = points[b, axis] - points[a, axis], points[c, axis] - points[a, axis]
        plane[0, axis], plane[1, axis], plane[2, axis] = points[a, axis], u, v
        uu, uv, vv = uu + u * u, uv + u * v, vv + v * v
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        plane[3, axis] = plane[1, i] * plane[2, j] - plane[1, j] * plane[2, i]
    inner[0], inner[1], inner[2] = uu, uv, vv
    area = max(uu * vv - uv * uv, 1e-300)
    inner[3], inner[4] = 1.0 / area, 1.0 / sqrt(area)


@inlined
def _weights(
    eye: FloatArray, x: float, y: float, depth: float, plane: FloatArray, inner: FloatArray
) -> tuple[float, float, float]:
    """Return the shares of the second and third corner of a face at a point, and the cosine of its slant."""
    wu = wv = wn = 0.0
    ahead = sqrt(x * x + y * y + depth * depth)
    for axis in range(3):
        ray = eye[axis, 0] * x + eye[axis, 1] * y - eye[axis, 2] * depth
        w = ray + eye[axis, 3] - plane[0, axis]
        wu, wv = wu + w * plane[1, axis], wv + w * plane[2, axis]
        wn += ray * plane[3, axis]
    uu, uv, vv = inner[0], inner[1], inner[2]
    second, third = (wu * vv - wv * uv) * inner[3], (wv * uu - wu * uv) * inner[3]
    return second, third, abs(wn) * inner[4] / ahead


@inlined
def _mix(
    start: int,
    high: int,
    wide: int,
    texels: npt.NDArray[np.uint8],
    u: float,
    v: float,
    repeats: bool,
    image: npt.NDArray[np.uint8],
    row: int,
    column: int,
) -> None:
    """Set a pixel to the colour at a place of a level, between the four nearest texels."""
    x, y = u * wide - 0.5, (1.0 - v) * high - 0.5
    left, top = floor(x), floor(y)
    across, down = x - left, y - top
    above, below = _wrap(int(top), high, repeats), _wrap(int(top) + 1, high, repeats)
    before, after = _wrap(int(left), wide, repeats), _wrap(int(left) + 1, wide, repeats)
    upper, lower = start + above * wide, start + below * wide
    for channel in range(3):
        total = 0.5 + (1.0 - down) * (1.0 - across) * texels[upper + before, channel]
        total += (1.0 - down) * across * texels[upper + after, channel]
        total += down * (1.0 - across) * texels[lower + before, channel]
        total += down * across * texels[lower + after, channel]
        image[row, column, channel] = int(total)


@inlined
def _wrap(place: int, size: int, repeats: bool) -> int:
    """Return a place within an image, which repeats or ends with its rim."""
    return place % size if repeats else min(max(place, 0), size - 1)
