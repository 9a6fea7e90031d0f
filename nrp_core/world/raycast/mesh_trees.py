"""Trees of boxes around the triangles of meshes, so that a ray is tested against few of them.

A tree is complete and binary: the children of node ``i`` are ``2 i + 1`` and ``2 i + 2``. Its leaves contain
triangles that follow each other on a Z-order curve (Morton 1966).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.world.rigid import Vector

LEAF = 4
"""Maximum number of triangles in a leaf."""
MAX_DEPTH = 64

_BITS = 20  # of each axis of the curve
_SLACK = 1e-9  # of a box, as a share of the mesh, against rounding


@dataclass(frozen=True)
class MeshTrees:
    """The trees of several meshes in common arrays.

    Args:
        triangles: corners of all triangles in the order of the leaves, shape ``(m, 3, 3)``.
        boxes: lowest and highest corner of each node's box, shape ``(k, 6)``.
        places: for each mesh its first triangle, the triangle after its last, its first node and the number
            of its leaves, which is 0 without triangles; shape ``(n, 4)``.
    """

    triangles: FloatArray
    boxes: FloatArray
    places: IntArray

    def distance(self, mesh: int, point: Vector) -> float:
        """Return the distance of a point from the nearest leaf of a mesh, m; ``inf`` without triangles."""
        _, _, root, leaves = self.places[mesh]
        last = self.boxes[root + leaves - 1 : root + 2 * leaves - 1]
        beyond = np.maximum(np.maximum(last[:, :3] - point, point - last[:, 3:]), 0.0)
        return float(np.linalg.norm(beyond, axis=1).min(initial=inf))


def mesh_trees(meshes: Sequence[FloatArray]) -> MeshTrees:
    """Return the trees of meshes, each an array of the corners of triangles, shape ``(m, 3, 3)``."""
    ordered = [mesh[_curve(mesh.mean(axis=1))] for mesh in meshes]
    boxes = [_boxes(mesh) for mesh in ordered]
    ends, nodes = (np.cumsum([0, *map(len, each)]) for each in (ordered, boxes))
    leaves = [(len(each) + 1) // 2 for each in boxes]
    places = np.column_stack([ends[:-1], ends[1:], nodes[:-1], leaves]).astype(np.int64)
    return MeshTrees(
        np.concatenate([np.empty((0, 3, 3)), *ordered]), np.concatenate([np.empty((0, 6)), *boxes]), places
    )


def _curve(points: FloatArray) -> IntArray:
    """Return the order of points along a Z-order curve through the box around them."""
    if not len(points):
        return np.empty(0, np.int64)
    low, extent = points.min(axis=0), np.ptp(points, axis=0).max() or 1.0
    bits = ((points - low) / extent * (2**_BITS - 1)).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(_BITS):
        for axis in range(3):
            code |= ((bits[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable")


def _boxes(triangles: FloatArray) -> FloatArray:
    """Return the boxes of a tree from its root, shape ``(2 leaves - 1, 6)``; empty leaves have void boxes."""
    if not len(triangles):
        return np.empty((0, 6))
    starts = np.arange(0, len(triangles), LEAF)
    slack = _SLACK * np.abs(triangles).max()
    low = np.minimum.reduceat(triangles.min(axis=1), starts) - slack
    high = np.maximum.reduceat(triangles.max(axis=1), starts) + slack
    leaves = 1 << (len(starts) - 1).bit_length()
    missing = [(0, leaves - len(starts)), (0, 0)]
    low = np.pad(low, missing, constant_values=inf)
    high = np.pad(high, missing, constant_values=-inf)
    levels = [np.column_stack([low, high])]
    while len(low) > 1:
        low, high = np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])
        levels.append(np.column_stack([low, high]))
    return np.concatenate(levels[::-1])


@jit
def first_crossing(
    triangles: FloatArray,
    boxes: FloatArray,
    leaves: int,
    origin: FloatArray,
    ray: FloatArray,
    nearest: float,
    farthest: float,
    waiting: IntArray,
) -> float:
    """Return the distance at which a ray first crosses a mesh, ``inf`` for never.

    Args:
        triangles: those of the mesh.
        boxes: those of its tree.
        leaves: the number of leaves of its tree.
        origin: start of the ray in the frame of the mesh, shape ``(3,)``.
        ray: unit vector along it.
        nearest: minimum distance, m.
        farthest: maximum distance that matters, m.
        waiting: working memory of at least ``MAX_DEPTH`` numbers.
    """
    best = inf
    count = 0
    if leaves:
        waiting[0], count = 0, 1
    while count:
        count -= 1
        node = waiting[count]
        if _enters(boxes[node], origin, ray) > min(best, farthest):
            continue
        if node < leaves - 1:
            near, far = 2 * node + 1, 2 * node + 2
            if _enters(boxes[far], origin, ray) < _enters(boxes[near], origin, ray):
                near, far = far, near
            waiting[count], waiting[count + 1] = far, near
            count += 2
            continue
        first = (node - leaves + 1) * LEAF
        for i in range(first, min(first + LEAF, len(triangles))):
            t = _crossing(triangles[i], origin, ray)
            if nearest <= t < best:
                best = t
    return best


@jit
def _enters(box: FloatArray, origin: FloatArray, ray: FloatArray) -> float:
    """Return the distance at which a ray enters a box, 0 if it starts inside and ``inf`` for never."""
    enter, leave = 0.0, inf
    for axis in range(3):
        if ray[axis] == 0.0:
            if origin[axis] < box[axis] or origin[axis] > box[3 + axis]:
                return inf
            continue
        one = (box[axis] - origin[axis]) / ray[axis]
        other = (box[3 + axis] - origin[axis]) / ray[axis]
        enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
    return enter if enter <= leave else inf


@jit
def _crossing(triangle: FloatArray, origin: FloatArray, ray: FloatArray) -> float:
    """Return the distance at which a ray crosses a triangle, else ``inf`` (Moeller and Trumbore 1997)."""
    a, b, c = triangle[0], triangle[1], triangle[2]
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = ray[1] * vz - ray[2] * vy, ray[2] * vx - ray[0] * vz, ray[0] * vy - ray[1] * vx
    volume = ux * px + uy * py + uz * pz
    if volume == 0.0:
        return inf
    sx, sy, sz = origin[0] - a[0], origin[1] - a[1], origin[2] - a[2]
    u = (sx * px + sy * py + sz * pz) / volume
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    v = (ray[0] * qx + ray[1] * qy + ray[2] * qz) / volume
    if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
        return float((vx * qx + vy * qy + vz * qz) / volume)
    return inf
