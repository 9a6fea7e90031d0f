"""The visuals of a scene as one set of triangles that move with numbered frames, and the images on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from functools import lru_cache
from math import floor, sqrt
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit
from nrp_core.scene.merged_bodies import WORLD_FRAME, Body, place_in_frame
from nrp_core.scene.meshes.triangles import Coordinates
from nrp_core.scene.model import Rgba, Texture, Visual
from nrp_core.scene.rigid import BodyPath as BodyPath
from nrp_core.scene.rigid import Pose, matrix_of, transform
from nrp_core.scene.tessellation import mapped_shape, triangles_of
from nrp_core.world.render.cameras import SKY, bytes_of, drawn, flat
from nrp_core.world.render.pixels import NOTHING, NearnessArray

A = TypeVar("A", bound="npt.NDArray[Any]")

_Shape: TypeAlias = tuple[FloatArray, npt.NDArray[np.int32], Coordinates | None]
"""Vertices, faces, and the places of their corners in an image, None for a shape without any."""

MAX_EXTENT_M = 60.0
"""A larger visual (m) is scenery, which need not fit into an image or a light's beam."""


class SceneMesh:
    """Vertices, triangles and colours of all visuals.

    Attributes:
        vertices: vertices in their frames, shape ``(n, 3)``.
        vertex_frames: the frame of each vertex, shape ``(n,)``.
        faces: indices of vertices, shape ``(m, 3)``.
        surfaces: the number of the visual of each face, shape ``(m,)``.
        shown: which visuals are visible.
        flags: the bits of the visuals for the masks of cameras.
        glowing: which visuals have their colour in any light.
        finishes: the finish of each visual, None for a matt one.
        palette: the colours of the visuals, and at index -1 of the sky; shape ``(visuals + 1, 3)``.
        textures: the images on visuals, None if no visual has one.
    """

    def __init__(self, bodies: Mapping[str, Sequence[Body]], frames: Mapping[BodyPath, int]) -> None:
        placed = list(_placed_visuals(bodies, frames))
        meshes = [_in_frame(visual, pose) for _, visual, pose, _ in placed]
        counts = [len(vertices) for vertices, *_ in meshes]
        starts = np.cumsum([0, *counts])
        self._numbers = {path: number for number, (path, *_) in enumerate(placed)}
        self.vertices = np.concatenate([np.empty((0, 3)), *(vertices for vertices, *_ in meshes)])
        self.vertex_frames = np.repeat(np.array([frame for *_, frame in placed], np.int32), counts)
        faces = [faces + start for (_, faces, _), start in zip(meshes, starts, strict=False)]
        self.faces = np.concatenate([np.empty((0, 3)), *faces]).astype(np.int32)
        self.surfaces = np.repeat(np.arange(len(placed), dtype=np.int32), [len(each) for each in faces])
        self.shown = np.array([visual.rgba[3] > 0 for _, visual, *_ in placed], bool)
        self.flags = np.array([visual.flags for _, visual, *_ in placed], np.uint32)
        self.glowing = np.array([visual.glows for _, visual, *_ in placed], bool)
        self.finishes = [visual.finish for _, visual, *_ in placed]
        colors = [bytes_of(flat(visual.rgba)) for _, visual, *_ in placed]
        self.palette = np.array([*colors, bytes_of(SKY)], np.uint8)
        self.textures = self._textures([visual for _, visual, *_ in placed], meshes)
        self._own = [visual.rgba for _, visual, *_ in placed]
        self._imaged = self.textures.shown.copy() if self.textures else np.zeros(len(placed), bool)
        self._first = {name: getattr(self, name) for name in _CHANGING}

    def copy(self) -> SceneMesh:
        """Return a mesh with the initial colours that shares all constant parts with this one."""
        other = copy(self)
        other.__dict__.update(self._first)
        return other

    def _textures(self, visuals: Sequence[Visual], meshes: Sequence[_Shape]) -> Textures | None:
        images = [
            visual.texture if places is not None else None
            for visual, (*_, places) in zip(visuals, meshes, strict=True)
        ]
        if not any(images):
            return None
        places = [
            np.zeros((len(faces), 3, 2), np.float32) if known is None else known for _, faces, known in meshes
        ]
        return Textures(images, np.concatenate(places), self.surfaces, self.vertices[self.faces])

    def shown_to(self, mask: int) -> npt.NDArray[np.bool_]:
        """Return which visuals are visible to a camera with a mask."""
        seen: npt.NDArray[np.bool_] = self.flags & np.uint32(mask) != 0
        return self.shown & seen

    def in_world(self, frames: FloatArray) -> FloatArray:
        """Return all vertices in the world, shape ``(n, 3)``.

        Args:
            frames: rotation and translation to the world of each frame, shape ``(m, 3, 4)``.
        """
        held = frames[self.vertex_frames]
        placed: FloatArray = np.einsum("nij,nj->ni", held[:, :, :3], self.vertices) + held[:, :, 3]
        return placed

    def framed(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which vertices, given in the world, do not belong to scenery; all if every vertex does."""
        framed = np.zeros(len(points), bool)
        for surface in np.unique(self.surfaces):
            mine = np.unique(self.faces[self.surfaces == surface])
            framed[mine] = self.shown[surface] and np.ptp(points[mine], axis=0).max() < MAX_EXTENT_M
        return framed if framed.any() else ~framed

    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Set the colour of a visual, named by its path; its image is shown only in its original colour.

        The arrays of colours are replaced and not changed, because images that are drawn later use them.
        """
        number, color = self._numbers[visual], flat(rgba)
        self.palette = _with(self.palette, number, bytes_of(color))
        self.shown = _with(self.shown, number, color[3] > 0)
        if self.textures is not None:
            self.textures = copy(self.textures)
            imaged = self._imaged[number] and rgba == self._own[number]
            self.textures.shown = _with(self.textures.shown, number, imaged)

    def set_glow(self, visual: str, glows: bool) -> None:
        """Set whether a visual has its colour in any light."""
        self.glowing = _with(self.glowing, self._numbers[visual], glows)


_CHANGING = ("palette", "shown", "glowing", "textures")


def _with(array: A, number: int, value: Any) -> A:
    """Return a copy of an array with another value of one item."""
    changed = array.copy()
    changed[number] = value
    return changed


def frames_of(bodies: Mapping[str, Sequence[Body]]) -> dict[BodyPath, int]:
    """Number the frames of bodies that move and carry a visual or a camera, from 1; 0 is the world's."""
    paths = [
        (model, index)
        for model, parts in bodies.items()
        for index, body in enumerate(parts)
        if not body.fixed and any(link.visuals or link.sensors for link in body.links)
    ]
    return {path: number for number, path in enumerate(paths, start=WORLD_FRAME + 1)}


def _placed_visuals(
    bodies: Mapping[str, Sequence[Body]], frames: Mapping[BodyPath, int]
) -> Iterable[tuple[str, Visual, Pose, int]]:
    """Return each visual with its path, its pose in a frame, and that frame."""
    for model, parts in bodies.items():
        for index, body in enumerate(parts):
            for link in body.links:
                place = place_in_frame(body) @ link.pose
                frame = frames.get((model, index), WORLD_FRAME)
                for visual in link.visuals:
                    yield f"{model}/{link.name}/{visual.name}", visual, place @ visual.pose, frame


def _in_frame(visual: Visual, pose: Pose) -> _Shape:
    geometry, place = drawn(visual.geometry, pose)
    shape = mapped_shape(geometry) if visual.texture else None
    vertices, faces, places = shape or (*triangles_of(geometry), None)
    return transform(vertices, matrix_of(place)), faces, places


MAX_SIDE_PX = 1024
"""A larger image is reduced to this, which is more than cameras of robots resolve."""
_LEVELS = MAX_SIDE_PX.bit_length()
_PLAIN = -1
_SLACK = 1e-4

Levels = Sequence[npt.NDArray[np.uint8]]
"""An image, RGB, and itself in half the size, down to a pixel."""


class Textures:
    """The images on the visuals of a scene: the colour of each pixel whose face has a place in an image.

    An image is kept in levels of half the size each (Williams, Pyramidal parametrics, SIGGRAPH 1983). A pixel
    takes its colour from the level whose texels are about as large as it is, between the four nearest ones,
    so that distant images do not flicker.

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
        """Draw the visible parts of the images.

        Args:
            seen: the face at each pixel, shape ``(height, width)``.
            nearness: reciprocals of their depths, of the same shape.
            focal: focal length, pixels.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            points: vertices in the world, shape ``(n, 3)``.
            faces: indices of vertices, shape ``(m, 3)``.
            image: RGB; pixels without an image do not change.
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
    from nrp_core._support.opencv import cv2, decode

    pixels = decode(path.read_bytes(), cv2.IMREAD_COLOR)
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
