"""The light from the surface at each pixel to the eye."""

from __future__ import annotations

from math import sqrt

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.render.gloss import MATT, add_gloss, begin_gloss, tint_gloss
from nrp_core.world.render.lighting import add_light, way_to
from nrp_core.world.render.normals import find_normal
from nrp_core.world.render.pixels import NOTHING, NearnessArray


@jit
def shade(
    seen: IndexArray,
    nearness: NearnessArray,
    focal: float,
    eye: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    normals: FloatArray,
    turns: FloatArray,
    face_frames: IndexArray,
    surfaces: IndexArray,
    colors: FloatArray,
    glowing: npt.NDArray[np.bool_],
    gloss: FloatArray,
    tables: FloatArray,
    ambient: float,
    lamps: FloatArray,
    maps: NearnessArray,
    map_eyes: FloatArray,
    map_focals: FloatArray,
    image: npt.NDArray[np.uint8],
) -> None:
    """Turn an image of the colours of surfaces into one of the light from them to the eye.

    Args:
        seen: the face at each pixel, shape ``(height, width)``.
        nearness: reciprocals of their depths, of the same shape.
        focal: focal length, in pixels.
        eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        points: vertices in the world, shape ``(n, 3)``.
        faces: indices of vertices, shape ``(m, 3)``.
        normals: normals of their corners, in their frames, shape ``(m, 3, 3)``.
        turns: rotation and translation of each frame to the world, shape ``(f, 3, 4)``.
        face_frames: the frame of each face, shape ``(m,)``.
        surfaces: the surface of each face, shape ``(m,)``.
        colors: colour of each surface, 0..1, shape ``(n, 3)``; with an image on it, the mean.
        glowing: which surfaces have their colour in any light, shape ``(n,)``.
        gloss: rows of finishes, see :class:`~nrp_core.world.render.gloss.Gloss`.
        tables: tables of the finishes.
        ambient: ambient light.
        lamps: one in each row, in the layout of :class:`~nrp_core.world.render.lamps.Lamps`.
        maps: reciprocal depths seen from the lamps, shape ``(k, size, size)``.
        map_eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        map_focals: focal lengths of the maps.
        image: the colours, RGB, replaced by the result; the background stays as it is.
    """
    height, width = seen.shape
    place, normal, light = np.empty(3), np.empty(3), np.empty(3)
    view, leaving, arriving = np.empty(3), np.empty(4), np.empty(3)
    finish = np.empty(gloss.shape[1])
    for row in range(height):
        for column in range(width):
            face = seen[row, column]
            if face == NOTHING or glowing[surfaces[face]]:
                continue
            surface = surfaces[face]
            depth = 1.0 / nearness[row, column]
            x, y = (column + 0.5 - width / 2) * depth / focal, (height / 2 - row - 0.5) * depth / focal
            _find_place(eye, x, y, depth, place)
            find_normal(place, points, faces, face, normals, turns, face_frames[face], normal)
            if gloss[surface, 0] == MATT:
                light.fill(ambient)
                for lamp in range(len(lamps)):
                    add_light(place, normal, lamps, lamp, maps, map_eyes, map_focals, light)
                for channel in range(3):
                    light[channel] *= image[row, column, channel] / 255.0
            else:
                table = tables[int(gloss[surface, 0])]
                tint_gloss(gloss[surface], colors[surface], image[row, column], finish)
                to_eye = _look(eye, place, normal, view)
                begin_gloss(finish, table, to_eye, ambient, leaving, light)
                for lamp in range(len(lamps)):
                    arriving.fill(0.0)
                    add_light(place, normal, lamps, lamp, maps, map_eyes, map_focals, arriving)
                    towards = way_to(lamps, lamp, place)[:3]
                    add_gloss(finish, table, normal, to_eye, view, towards, leaving, arriving, light)
            for channel in range(3):
                image[row, column, channel] = int(255 * min(1.0, light[channel]) + 0.5)


@inlined
def _find_place(eye: FloatArray, x: float, y: float, depth: float, place: FloatArray) -> None:
    """Write the position in the world of a point given in the camera's frame."""
    for axis in range(3):
        place[axis] = eye[axis, 0] * x + eye[axis, 1] * y - eye[axis, 2] * depth + eye[axis, 3]


@inlined
def _look(eye: FloatArray, place: FloatArray, normal: FloatArray, view: FloatArray) -> float:
    """Write the direction from a point to the eye; return its cosine with the normal, more than 0."""
    length = cosine = 0.0
    for axis in range(3):
        view[axis] = eye[axis, 3] - place[axis]
        length += view[axis] * view[axis]
    length = max(sqrt(length), 1e-300)
    for axis in range(3):
        view[axis] /= length
        cosine += view[axis] * normal[axis]
    return min(max(cosine, 1e-3), 1.0)  # a smooth normal may point away from the eye while its face does not
