"""Normals of surfaces: smooth where they are curved, sharp at edges."""

from __future__ import annotations

from math import sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit

_CREASE = 0.77  # cosine of the maximum angle (40 degrees) between two triangles of one smooth surface


@jit
def corner_normals(
    vertices: FloatArray, faces: IndexArray, corners: IndexArray, starts: IndexArray
) -> FloatArray:
    """Return a unit normal for each corner of each face: smooth over curved surfaces, sharp at edges.

    Args:
        vertices: shape ``(n, 3)``.
        faces: indices of vertices, counter-clockwise from outside, shape ``(m, 3)``.
        corners: numbers of corners (``3 * face + corner``), grouped by vertex.
        starts: index of the first corner of each vertex, shape ``(n + 1,)``.

    Returns:
        Normals, shape ``(m, 3, 3)``: face, corner, axis.
    """
    flat = np.empty((len(faces), 3))  # normals weighted by twice the area
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


@inlined
def find_normal(
    place: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    face: int,
    normals: FloatArray,
    turns: FloatArray,
    frame: int,
    normal: FloatArray,
) -> None:
    """Write the unit normal at a point of a triangle, in the world, interpolated between its corners."""
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
