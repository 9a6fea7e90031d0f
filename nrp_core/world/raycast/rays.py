"""Intersections of rays with shapes: where each ray first enters one.

Shapes are hit from outside only: a ray that starts inside one leaves it without a hit. The triangles of a
mesh are hit from both sides, because their orientation in files is unreliable.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit

PLANE, SPHERE, BOX, CYLINDER, CAPSULE, MESH = range(6)


@jit
def cast(
    kinds: IntArray,
    sizes: FloatArray,
    radii: FloatArray,
    places: FloatArray,
    meshes: IntArray,
    triangles: FloatArray,
    hidden: npt.NDArray[np.bool_],
    eye: FloatArray,
    rays: FloatArray,
    nearest: float,
    distances: FloatArray,
) -> None:
    """Shorten ``distances`` to the points where rays enter shapes.

    Args:
        kinds: kind of each shape, shape ``(n,)``.
        sizes: half edges of a box, or of the bounding box of a mesh; radius (first) and half length (last) of
            round shapes; shape ``(n, 3)``.
        radii: radii of bounding spheres about the shapes' origins, shape ``(n,)``.
        places: rotation and translation of each shape to the world, shape ``(n, 3, 4)``.
        meshes: index of the first triangle of each shape and the index after its last, shape ``(n, 2)``.
        triangles: corners relative to the middle of the mesh's bounding box, shape ``(m, 3, 3)``.
        hidden: shapes that are ignored.
        eye: origin of the rays, shape ``(3,)``.
        rays: unit vectors in the world, shape ``(k, 3)``.
        nearest: minimum distance of a hit, m.
        distances: length of each ray, shortened in place, shape ``(k,)``.
    """
    origin, ray = np.empty(3), np.empty(3)
    for shape in range(len(kinds)):
        if hidden[shape]:
            continue
        place, kind, size = places[shape], kinds[shape], sizes[shape]
        from_x, from_y, from_z = eye[0] - place[0, 3], eye[1] - place[1, 3], eye[2] - place[2, 3]
        away_squared = from_x**2 + from_y**2 + from_z**2
        for axis in range(3):
            origin[axis] = place[0, axis] * from_x + place[1, axis] * from_y + place[2, axis] * from_z
        for i in range(len(rays)):
            x, y, z = rays[i, 0], rays[i, 1], rays[i, 2]
            ahead = from_x * x + from_y * y + from_z * z
            if kind != PLANE and away_squared - ahead**2 > radii[shape] ** 2:
                continue
            if kind != PLANE and -ahead - radii[shape] > distances[i]:
                continue
            for axis in range(3):
                ray[axis] = place[0, axis] * x + place[1, axis] * y + place[2, axis] * z
            if kind == MESH:
                first, end = meshes[shape]
                t = _mesh(triangles[first:end], size, origin, ray, nearest, distances[i])
            else:
                t = _entry(kind, size, origin, ray)
            if nearest <= t < distances[i]:
                distances[i] = t


@jit
def _entry(kind: int, size: FloatArray, origin: FloatArray, ray: FloatArray) -> float:
    """Return the distance at which a ray enters a shape, ``inf`` for never; negative if it starts inside."""
    if kind == PLANE:
        return -origin[2] / ray[2] if ray[2] < 0.0 and origin[2] > 0.0 else inf
    if kind == BOX:
        return _box(size, origin, ray)
    if kind == SPHERE:
        return _ball(size[0], origin[0], origin[1], origin[2], ray)
    return _cylinder(size[0], size[2], origin, ray, kind == CAPSULE)


@jit
def _box(half: FloatArray, origin: FloatArray, ray: FloatArray) -> float:
    enter, leave = -inf, inf
    for axis in range(3):
        if ray[axis] == 0.0:
            if abs(origin[axis]) > half[axis]:
                return inf
            continue
        one = (-half[axis] - origin[axis]) / ray[axis]
        other = (half[axis] - origin[axis]) / ray[axis]
        enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
    return enter if enter <= leave else inf


@jit
def _ball(radius: float, x: float, y: float, z: float, ray: FloatArray) -> float:
    b = x * ray[0] + y * ray[1] + z * ray[2]
    discriminant = b * b - (x * x + y * y + z * z - radius * radius)
    return -b - sqrt(discriminant) if discriminant >= 0.0 else inf


@jit
def _cylinder(radius: float, half: float, origin: FloatArray, ray: FloatArray, rounded: bool) -> float:
    """Return the same for a cylinder along z, with flat or round ends."""
    a = ray[0] ** 2 + ray[1] ** 2
    b = origin[0] * ray[0] + origin[1] * ray[1]
    c = origin[0] ** 2 + origin[1] ** 2 - radius**2
    best = inf
    if a > 0.0:
        discriminant = b * b - a * c
        if discriminant < 0.0:
            return inf
        t = (-b - sqrt(discriminant)) / a
        if abs(origin[2] + t * ray[2]) <= half:
            best = t
    for end in (-half, half):
        if rounded:
            best = min(best, _ball(radius, origin[0], origin[1], origin[2] - end, ray))
        elif ray[2] * end < 0.0:  # an end is entered against its normal
            t = (end - origin[2]) / ray[2]
            if (origin[0] + t * ray[0]) ** 2 + (origin[1] + t * ray[1]) ** 2 <= radius**2:
                best = min(best, t)
    return best


@jit
def _mesh(
    triangles: FloatArray,
    half: FloatArray,
    origin: FloatArray,
    ray: FloatArray,
    nearest: float,
    farthest: float,
) -> float:
    """Return the nearest crossing of a triangle (Moeller and Trumbore 1997)."""
    best = inf
    if _box(half, origin, ray) > farthest:
        return best
    for i in range(len(triangles)):
        a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        px, py, pz = ray[1] * vz - ray[2] * vy, ray[2] * vx - ray[0] * vz, ray[0] * vy - ray[1] * vx
        volume = ux * px + uy * py + uz * pz
        if volume == 0.0:
            continue
        sx, sy, sz = origin[0] - a[0], origin[1] - a[1], origin[2] - a[2]
        u = (sx * px + sy * py + sz * pz) / volume
        qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
        v = (ray[0] * qx + ray[1] * qy + ray[2] * qz) / volume
        if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            t = (vx * qx + vy * qy + vz * qz) / volume
            if nearest <= t < best:
                best = t
    return best
