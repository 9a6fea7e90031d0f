"""Light on what is seen: how bright each pixel's surface is, and what lies in whose shadow."""

from __future__ import annotations

from math import sqrt

import numpy as np
import numpy.typing as npt

from nrp_core.jit import inlined, jit
from nrp_core.world.render.pixels import NOTHING, NearnessArray

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

BIAS = 1.5
"""How far a point is lifted off its surface before it is looked up in a shadow map, in texels."""
_CREASE = 0.77  # cosine of the angle (40 degrees) up to which two triangles are one smooth surface


@jit
def corner_normals(vertices: FloatArray, faces: IntArray, corners: IntArray, starts: IntArray) -> FloatArray:
    """Return a unit normal for each corner of each face: smooth over curved surfaces, sharp at edges.

    Args:
        vertices: shape ``(n, 3)``.
        faces: indices of vertices, counter-clockwise from outside, shape ``(m, 3)``.
        corners: numbers of corners (``3 * face + corner``), those of one vertex beside each other.
        starts: where those of each vertex start, shape ``(n + 1,)``.

    Returns:
        Normals, shape ``(m, 3, 3)``: face, corner, axis.
    """
    flat = np.empty((len(faces), 3))  # normals by twice the area
    for face in range(len(faces)):
        a, b, c = vertices[faces[face, 0]], vertices[faces[face, 1]], vertices[faces[face, 2]]
        ux, uy, uz, vx, vy, vz = b[0] - a[0], b[1] - a[1], b[2] - a[2], c[0] - a[0], c[1] - a[1], c[2] - a[2]
        flat[face, 0], flat[face, 1], flat[face, 2] = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    normals = np.zeros((len(faces), 3, 3))
    for face in range(len(faces)):
        for corner in range(3):
            vertex, normal = faces[face, corner], normals[face, corner]
            for near in corners[starts[vertex] : starts[vertex + 1]] // 3:
                if _cosine(flat[face], flat[near]) > _CREASE:
                    for axis in range(3):
                        normal[axis] += flat[near, axis]
            length = sqrt(_dot(normal, normal))
            for axis in range(3):
                normal[axis] /= max(length, 1e-300)
    return normals


@inlined
def _dot(a: FloatArray, b: FloatArray) -> float:
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@inlined
def _cosine(a: FloatArray, b: FloatArray) -> float:
    return _dot(a, b) / max(sqrt(_dot(a, a) * _dot(b, b)), 1e-300)


@jit
def shade(
    seen: IntArray,
    nearness: NearnessArray,
    focal: float,
    eye: FloatArray,
    points: FloatArray,
    faces: IntArray,
    normals: FloatArray,
    turns: FloatArray,
    face_frames: IntArray,
    albedo: FloatArray,
    glowing: npt.NDArray[np.bool_],
    sky: FloatArray,
    ambient: float,
    lights: FloatArray,
    maps: NearnessArray,
    map_eyes: FloatArray,
    map_focals: FloatArray,
    picture: npt.NDArray[np.uint8],
) -> None:
    """Fill a picture with the light that the surfaces send to the eye.

    Args:
        seen: the face that each pixel shows, shape ``(height, width)``.
        nearness: reciprocals of their depths, of the same shape.
        focal: distance of the picture's plane, in pixels.
        eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        points: vertices in the world.
        faces: indices of vertices, shape ``(m, 3)``.
        normals: of their corners, in their frames, shape ``(m, 3, 3)``.
        turns: rotation and translation of each frame to the world, shape ``(f, 3, 4)``.
        face_frames: the frame of each face, shape ``(m,)``.
        albedo: colour of each face, 0..1, shape ``(m, 3)``.
        glowing: which faces have their colour in any light, shape ``(m,)``.
        sky: colour where nothing is seen, 0..1.
        ambient: light from everywhere.
        lights: one a row, as :class:`~nrp_core.world.render.lamps.Lamps` lays them out.
        maps: nearness seen from the lights, shape ``(k, size, size)``.
        map_eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        map_focals: theirs.
        picture: the result, RGB.
    """
    height, width = seen.shape
    place, normal, light = np.empty(3), np.empty(3), np.empty(3)
    for row in range(height):
        for column in range(width):
            face = seen[row, column]
            if face == NOTHING:
                for channel in range(3):
                    picture[row, column, channel] = int(255 * sky[channel] + 0.5)
                continue
            if glowing[face]:
                for channel in range(3):
                    picture[row, column, channel] = int(255 * albedo[face, channel] + 0.5)
                continue
            depth = 1.0 / nearness[row, column]
            x, y = (column + 0.5 - width / 2) * depth / focal, (height / 2 - row - 0.5) * depth / focal
            for axis in range(3):
                place[axis] = eye[axis, 0] * x + eye[axis, 1] * y - eye[axis, 2] * depth + eye[axis, 3]
            _find_normal(place, points, faces, face, normals, turns, face_frames[face], normal)
            light.fill(ambient)
            for number in range(len(lights)):
                _add_light(place, normal, lights, number, maps, map_eyes, map_focals, light)
            for channel in range(3):
                shown = min(1.0, albedo[face, channel] * light[channel])
                picture[row, column, channel] = int(255 * shown + 0.5)


@inlined
def _find_normal(
    place: FloatArray,
    points: FloatArray,
    faces: IntArray,
    face: int,
    normals: FloatArray,
    turns: FloatArray,
    frame: int,
    normal: FloatArray,
) -> None:
    """Write the unit normal at a point of a triangle, in the world, between those of the corners."""
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    uu = uv = vv = wu = wv = 0.0
    for axis in range(3):
        corner = points[a, axis]
        u, v, w = points[b, axis] - corner, points[c, axis] - corner, place[axis] - corner
        uu, uv, vv, wu, wv = uu + u * u, uv + u * v, vv + v * v, wu + w * u, wv + w * v
    area = max(uu * vv - uv * uv, 1e-300)
    second, third = (wu * vv - wv * uv) / area, (wv * uu - wu * uv) / area
    first = 1 - second - third
    x = normals[face, 0, 0] * first + normals[face, 1, 0] * second + normals[face, 2, 0] * third
    y = normals[face, 0, 1] * first + normals[face, 1, 1] * second + normals[face, 2, 1] * third
    z = normals[face, 0, 2] * first + normals[face, 1, 2] * second + normals[face, 2, 2] * third
    length = max(sqrt(x * x + y * y + z * z), 1e-300)
    for axis in range(3):
        turned = turns[frame, axis, 0] * x + turns[frame, axis, 1] * y + turns[frame, axis, 2] * z
        normal[axis] = turned / length


@inlined
def _add_light(
    place: FloatArray,
    normal: FloatArray,
    lamps: FloatArray,
    lamp: int,
    maps: NearnessArray,
    map_eyes: FloatArray,
    map_focals: FloatArray,
    light: FloatArray,
) -> None:
    """Add what comes from one lamp to a point, by Lambert's law."""
    fx, fy, fz, strength = -lamps[lamp, 3], -lamps[lamp, 4], -lamps[lamp, 5], 1.0  # towards the lamp
    if lamps[lamp, 9] > 0:  # it has a place
        fx, fy, fz = lamps[lamp, 0] - place[0], lamps[lamp, 1] - place[1], lamps[lamp, 2] - place[2]
        distance = max(sqrt(fx * fx + fy * fy + fz * fz), 1e-9)
        fx, fy, fz = fx / distance, fy / distance, fz / distance
        if distance > lamps[lamp, 10]:
            return
        strength = 1.0 / max(
            lamps[lamp, 11] + distance * (lamps[lamp, 12] + distance * lamps[lamp, 13]), 1e-9
        )
        cosine = -(fx * lamps[lamp, 3] + fy * lamps[lamp, 4] + fz * lamps[lamp, 5])
        strength *= min(
            1.0, max(0.0, (cosine - lamps[lamp, 15]) / max(lamps[lamp, 14] - lamps[lamp, 15], 1e-9))
        )
    slope = fx * normal[0] + fy * normal[1] + fz * normal[2]
    if slope <= 0 or strength <= 0:
        return
    for number in range(int(lamps[lamp, 16]), int(lamps[lamp, 17])):
        strength *= _lit(place, normal, maps, map_eyes, map_focals[number], number)
    for channel in range(3):
        light[channel] += lamps[lamp, 6 + channel] * slope * strength


@inlined
def _lit(
    place: FloatArray, normal: FloatArray, maps: NearnessArray, eyes: FloatArray, focal: float, number: int
) -> float:
    """Return which share of a point's surroundings a lamp's eye sees; 1 for what is outside its map."""
    size = maps.shape[1]
    depth = 0.0
    for axis in range(3):
        depth -= eyes[number, axis, 2] * (place[axis] - eyes[number, axis, 3])
    if depth <= 0:
        return 1.0
    lift = BIAS * depth / focal
    x = y = 0.0
    for axis in range(3):
        offset = place[axis] + lift * normal[axis] - eyes[number, axis, 3]
        x, y = x + eyes[number, axis, 0] * offset, y + eyes[number, axis, 1] * offset
        depth -= eyes[number, axis, 2] * lift * normal[axis]
    column, row = size / 2 + focal * x / depth - 0.5, size / 2 - focal * y / depth - 0.5
    if not (0 <= column < size - 1 and 0 <= row < size - 1):
        return 1.0
    left, top = int(column), int(row)
    across, down = column - left, row - top
    share = 0.0
    for i in range(2):
        for j in range(2):
            weight = (down if i else 1 - down) * (across if j else 1 - across)
            if maps[number, top + i, left + j] * depth <= 1.0:
                share += weight
    return share
