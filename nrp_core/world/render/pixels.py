"""Rasterise triangles: find the surface visible at the centre of each pixel.

Cameras look along -z of their frame, x to the right, y up. Depths are kept as reciprocals, which are linear
in the image; 0 is infinitely far.
"""

from __future__ import annotations

from math import ceil

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit

NearnessArray = npt.NDArray[np.float32]
"""Type of reciprocal depths: seven digits distinguish surfaces, in half the memory."""

NOTHING = -1
"""The surface of a pixel of the background."""


@jit
def draw(
    vertices: FloatArray,
    vertex_frames: IndexArray,
    faces: IndexArray,
    surfaces: IndexArray,
    shown: npt.NDArray[np.bool_],
    frames: FloatArray,
    eye_frame: int,
    eye: FloatArray,
    focal: float,
    near: float,
    far: float,
    points: FloatArray,
    nearness: NearnessArray,
    seen: IndexArray,
) -> None:
    """Fill ``seen`` with the surface at each pixel.

    No memory is allocated here: Numba takes 15 ms to load compiled code that does, once in each process.

    Args:
        vertices: vertices in their frames, shape ``(n, 3)``.
        vertex_frames: the frame of each vertex, shape ``(n,)``.
        faces: indices of vertices, counter-clockwise from outside, shape ``(m, 3)``.
        surfaces: the surface of each face, shape ``(m,)``.
        shown: which surfaces are visible.
        frames: rotation and translation of each frame to the world, shape ``(f, 3, 4)``.
        eye_frame: the frame that holds the camera.
        eye: rotation and translation of the camera to that frame, shape ``(3, 4)``.
        focal: focal length, in pixels.
        near: distance in front of which nothing is seen.
        far: distance beyond which nothing is seen.
        points: work array, see :func:`point_array`.
        nearness: work array of the image's shape ``(height, width)``.
        seen: the result, of the same shape; :data:`NOTHING` for the background.
    """
    to_camera(vertices, vertex_frames, frames, eye_frame, eye, points)
    window = 0, seen.shape[0], 0, seen.shape[1]
    _draw_within(window, faces, surfaces, shown, focal, near, far, points, nearness, seen)


@jit
def count_within(
    chosen: npt.NDArray[np.bool_],
    vertices: FloatArray,
    vertex_frames: IndexArray,
    faces: IndexArray,
    surfaces: IndexArray,
    shown: npt.NDArray[np.bool_],
    frames: FloatArray,
    eye_frame: int,
    eye: FloatArray,
    focal: float,
    near: float,
    far: float,
    points: FloatArray,
    nearness: NearnessArray,
    seen: IndexArray,
) -> tuple[int, int]:
    """Return the number of pixels in the left and in the right half that show a chosen surface.

    Only the part of the image that they can cover is drawn. ``chosen`` is true for them and false for the
    background; the other arguments are those of :func:`draw`.
    """
    axes = _axes(frames, eye_frame, eye)
    lens = focal, near, seen.shape[1] / 2, seen.shape[0] / 2
    low = np.inf, np.inf
    high = -np.inf, -np.inf
    for face in range(len(faces)):
        if chosen[surfaces[face]] and shown[surfaces[face]]:
            for corner in range(3):
                i = faces[face, corner]
                _turn(vertices[i], frames[vertex_frames[i]], axes, points, i)
            low, high = _cover(points, faces, face, lens, low, high)
    # one more on each side: row ends are interpolated
    upper, lower = max(0.0, low[1] - 1.0), min(float(seen.shape[0]), high[1] + 1.0)
    first, end = max(0.0, low[0] - 1.0), min(float(seen.shape[1]), high[0] + 1.0)
    if not (upper < lower and first < end):
        return 0, 0
    window = int(upper), ceil(lower), int(first), ceil(end)
    to_camera(vertices, vertex_frames, frames, eye_frame, eye, points)
    _draw_within(window, faces, surfaces, shown, focal, near, far, points, nearness, seen)
    middle = seen.shape[1] // 2
    right_part = window[0], window[1], max(window[2], middle), window[3]
    both = _tally(window, seen, chosen)
    on_right = _tally(right_part, seen, chosen)
    return both - on_right, on_right


@inlined
def _cover(
    points: FloatArray,
    faces: IndexArray,
    face: int,
    lens: tuple[float, float, float, float],
    low: tuple[float, float],
    high: tuple[float, float],
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the lowest and highest column and row of a face and the area covered before."""
    focal, near, middle, centre = lens
    if not _faces_eye(points, faces, face):
        return low, high
    polygon = points[len(points) - 4 :]
    corners = _clip(points, faces, face, near, polygon)
    _project(polygon, corners, focal, middle, centre)
    for i in range(corners):
        low = min(low[0], polygon[i, 0]), min(low[1], polygon[i, 1])
        high = max(high[0], polygon[i, 0]), max(high[1], polygon[i, 1])
    return low, high


@inlined
def _tally(window: tuple[int, int, int, int], seen: IndexArray, chosen: npt.NDArray[np.bool_]) -> int:
    """Return the number of pixels of a window with chosen surfaces."""
    upper, lower, first, end = window
    found = 0
    for row in range(upper, lower):
        for column in range(first, end):
            surface = seen[row, column]
            found += surface != NOTHING and chosen[surface]
    return found


@inlined
def _draw_within(
    window: tuple[int, int, int, int],
    faces: IndexArray,
    surfaces: IndexArray,
    shown: npt.NDArray[np.bool_],
    focal: float,
    near: float,
    far: float,
    points: FloatArray,
    nearness: NearnessArray,
    seen: IndexArray,
) -> None:
    """Draw the part of an image in a window: first row, row after the last, and the same for columns."""
    height, width = seen.shape
    nearness[window[0] : window[1], window[2] : window[3]] = 1.0 / far
    seen[window[0] : window[1], window[2] : window[3]] = NOTHING
    polygon = points[len(points) - 4 :]
    for face in range(len(faces)):
        if shown[surfaces[face]] and _faces_eye(points, faces, face):
            corners = _clip(points, faces, face, near, polygon)
            if corners:
                _project(polygon, corners, focal, width / 2, height / 2)
                _fill(polygon, corners, surfaces[face], window, nearness, seen)


@jit
def paint(seen: IndexArray, palette: npt.NDArray[np.uint8], image: npt.NDArray[np.uint8]) -> None:
    """Fill an image, shape ``(height, width, 3)``, with the colours of the visible surfaces.

    Args:
        seen: the surface at each pixel, shape ``(height, width)``.
        palette: the colours of all surfaces, and last of :data:`NOTHING`, shape ``(n + 1, 3)``.
        image: the result.
    """
    for row in range(seen.shape[0]):
        surface = NOTHING  # index -1 is the last one
        red, green, blue = palette[surface]
        for column in range(seen.shape[1]):
            if seen[row, column] != surface:  # usually the same as at the previous pixel
                surface = seen[row, column]
                red, green, blue = palette[surface]
            image[row, column, 0] = red
            image[row, column, 1] = green
            image[row, column, 2] = blue


def point_array(n: int) -> FloatArray:
    """Return an array for the points of ``n`` vertices, and for the corners of a clipped triangle."""
    return np.empty((n + 4, 3))


@jit
def to_camera(
    vertices: FloatArray,
    vertex_frames: IndexArray,
    frames: FloatArray,
    eye_frame: int,
    eye: FloatArray,
    points: FloatArray,
) -> None:
    """Fill the first ``points`` with the vertices in the camera's frame."""
    axes = _axes(frames, eye_frame, eye)
    for i in range(len(vertices)):
        _turn(vertices[i], frames[vertex_frames[i]], axes, points, i)


_Triple = tuple[float, float, float]
_Axes = tuple[_Triple, _Triple, _Triple, _Triple]


@inlined
def _axes(frames: FloatArray, eye_frame: int, eye: FloatArray) -> _Axes:
    """Return a camera's axes, to the right, up and back, and its place."""
    held = frames[eye_frame]
    turned = _axis(held, eye, 3)
    place = held[0, 3] + turned[0], held[1, 3] + turned[1], held[2, 3] + turned[2]
    return _axis(held, eye, 0), _axis(held, eye, 1), _axis(held, eye, 2), place


@inlined
def _turn(vertex: FloatArray, frame: FloatArray, axes: _Axes, points: FloatArray, i: int) -> None:
    """Fill a row of ``points`` with a vertex in the camera's frame."""
    right, up, back, place = axes
    x = _row_times(frame, 0, vertex) + frame[0, 3] - place[0]  # from the camera, along the world's axes
    y = _row_times(frame, 1, vertex) + frame[1, 3] - place[1]
    z = _row_times(frame, 2, vertex) + frame[2, 3] - place[2]
    points[i, 0] = right[0] * x + right[1] * y + right[2] * z
    points[i, 1] = up[0] * x + up[1] * y + up[2] * z
    points[i, 2] = back[0] * x + back[1] * y + back[2] * z


@inlined
def _axis(a: FloatArray, b: FloatArray, column: int) -> tuple[float, float, float]:
    """Return a column of ``a[:, :3] @ b``."""
    return (
        _row_times_column(a, 0, b, column),
        _row_times_column(a, 1, b, column),
        _row_times_column(a, 2, b, column),
    )


@inlined
def _row_times(a: FloatArray, row: int, vector: FloatArray) -> float:
    product: float = a[row, 0] * vector[0] + a[row, 1] * vector[1] + a[row, 2] * vector[2]
    return product


@inlined
def _row_times_column(a: FloatArray, row: int, b: FloatArray, column: int) -> float:
    product: float = a[row, 0] * b[0, column] + a[row, 1] * b[1, column] + a[row, 2] * b[2, column]
    return product


@inlined
def _faces_eye(points: FloatArray, faces: IndexArray, face: int) -> bool:
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    x, y, z = points[a, 0], points[a, 1], points[a, 2]
    ux, uy, uz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
    vx, vy, vz = points[c, 0] - x, points[c, 1] - y, points[c, 2] - z
    away: float = (uy * vz - uz * vy) * x + (uz * vx - ux * vz) * y + (ux * vy - uy * vx) * z
    return away < 0


@inlined
def _clip(points: FloatArray, faces: IndexArray, face: int, near: float, polygon: FloatArray) -> int:
    """Clip a triangle at the near plane; return the number of corners, 0, 3 or 4."""
    corners = 0
    for i in range(3):
        a, b = faces[face, i], faces[face, (i + 1) % 3]
        if -points[a, 2] >= near:
            for axis in range(3):
                polygon[corners, axis] = points[a, axis]
            corners += 1
        if (-points[a, 2] >= near) != (-points[b, 2] >= near):
            share = (near + points[a, 2]) / (points[a, 2] - points[b, 2])
            for axis in range(3):
                polygon[corners, axis] = points[a, axis] + share * (points[b, axis] - points[a, axis])
            corners += 1
    return corners


@inlined
def _project(polygon: FloatArray, corners: int, focal: float, middle: float, centre: float) -> None:
    """Project points to columns, rows and reciprocal depths, in place."""
    for i in range(corners):
        near = -1.0 / polygon[i, 2]
        polygon[i, 0] = middle + focal * polygon[i, 0] * near
        polygon[i, 1] = centre - focal * polygon[i, 1] * near
        polygon[i, 2] = near


@inlined
def _fill(
    polygon: FloatArray,
    corners: int,
    surface: int,
    window: tuple[int, int, int, int],
    nearness: NearnessArray,
    seen: IndexArray,
) -> None:
    """Draw the part of a convex polygon in a window with a depth test."""
    upper, lower, leftmost, end = window
    x, y, w = polygon[0, 0], polygon[0, 1], polygon[0, 2]
    ax, ay, aw = polygon[1, 0] - x, polygon[1, 1] - y, polygon[1, 2] - w
    bx, by, bw = polygon[2, 0] - x, polygon[2, 1] - y, polygon[2, 2] - w
    area = ax * by - ay * bx
    if area == 0.0:
        return
    across, down = (aw * by - bw * ay) / area, (bw * ax - aw * bx) / area
    top = bottom = y
    for i in range(1, corners):
        top, bottom = min(top, polygon[i, 1]), max(bottom, polygon[i, 1])
    for row in range(max(upper, ceil(top - 0.5)), min(lower, ceil(bottom - 0.5))):
        left, right = _span(polygon, corners, row + 0.5)
        first, last = max(leftmost, ceil(left - 0.5)), min(end, ceil(right - 0.5))
        if first >= last:
            continue
        start = w + across * (0.5 - x) + down * (row + 0.5 - y)
        nearest, shown = nearness[row, first:last], seen[row, first:last]  # vectorised
        for i in range(last - first):
            near = np.float32(start + across * (first + i))
            if near > nearest[i]:
                nearest[i] = near
                shown[i] = surface


@inlined
def _span(polygon: FloatArray, corners: int, y: float) -> tuple[float, float]:
    """Return the first and last column of a polygon in a row."""
    left, right = np.inf, -np.inf
    for i in range(corners):
        j = (i + 1) % corners
        if (polygon[i, 1] <= y) != (polygon[j, 1] <= y):
            # from the upper end, so that neighbours with a common edge get the same column
            low, high = (i, j) if polygon[i, 1] < polygon[j, 1] else (j, i)
            slope = (polygon[high, 0] - polygon[low, 0]) / (polygon[high, 1] - polygon[low, 1])
            at = polygon[low, 0] + (y - polygon[low, 1]) * slope
            left, right = min(left, at), max(right, at)
    return left, right
