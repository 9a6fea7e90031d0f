"""The collision shapes of a scene in one space: ray casting, and the shape at a point.

It is built from the neutral scene, so that lasers measure the same and contacts have the same names in all
engines; an engine only supplies the poses of bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from math import hypot, inf, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core._support.small_matrices import product
from nrp_core.scene.merged_bodies import WORLD_FRAME, Body, body_of, place_in_frame
from nrp_core.scene.model import (
    Box,
    Capsule,
    Collision,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Plane,
    Sphere,
)
from nrp_core.scene.rigid import BodyPath, Pose, ReadFrames, Touch, Vector, matrix_of
from nrp_core.scene.tessellation import triangles_of
from nrp_core.world.raycast.beams import Beams, directions

LEAF = 4
"""Maximum number of triangles in a leaf."""
MAX_DEPTH = 64

_BITS = 20  # of each axis of the curve
_SLACK = 1e-9  # of a box, as a share of the mesh, against rounding


@dataclass(frozen=True)
class MeshTrees:
    """Trees of boxes around the triangles of meshes in common arrays, so that a ray is tested against few.

    A tree is complete and binary: the children of node ``i`` are ``2 i + 1`` and ``2 i + 2``. Its leaves
    contain triangles that follow each other on a Z-order curve (Morton 1966).

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


PLANE, SPHERE, BOX, CYLINDER, CAPSULE, MESH = range(6)

_NO_TRIANGLES = np.empty((0, 3, 3))


class _Shapes(NamedTuple):
    """Collision shapes.

    Args:
        kinds: kind of each shape, shape ``(n,)``.
        sizes: half edges of a box; radius (first) and half length (last) of round shapes; shape ``(n, 3)``.
        radii: radii of bounding spheres about the shapes' origins, shape ``(n,)``.
        meshes: places of the shapes in the trees of meshes, shape ``(n, 4)``.
        triangles: corners relative to the middle of the mesh's bounding box, shape ``(m, 3, 3)``.
        boxes: boxes of the trees' nodes, shape ``(k, 6)``.
        held: the frame of each shape, shape ``(n,)``.
        local: rotation and translation of each shape to its frame, shape ``(n, 3, 4)``.
    """

    kinds: IntArray
    sizes: FloatArray
    radii: FloatArray
    meshes: IntArray
    triangles: FloatArray
    boxes: FloatArray
    held: IntArray
    local: FloatArray


@jit
def _cast(
    shapes: _Shapes,
    places: FloatArray,
    hidden: npt.NDArray[np.bool_],
    nearest: FloatArray,
    eye: FloatArray,
    rays: FloatArray,
    distances: FloatArray,
) -> None:
    """Shorten ``distances`` to the points where rays enter shapes.

    Args:
        shapes: the shapes.
        places: rotation and translation of each shape to the world, shape ``(n, 3, 4)``.
        hidden: shapes that are ignored.
        nearest: minimum distance of a hit of each shape, m, shape ``(n,)``.
        eye: origin of the rays, shape ``(3,)``.
        rays: unit vectors in the world, shape ``(k, 3)``.
        distances: length of each ray, shortened in place, shape ``(k,)``.
    """
    kinds, sizes, radii, triangles, boxes = (
        shapes.kinds, shapes.sizes, shapes.radii, shapes.triangles, shapes.boxes
    )  # fmt: skip
    origin, ray = np.empty(3), np.empty(3)
    waiting = np.empty(MAX_DEPTH, np.int64)
    for shape in _by_distance(places, radii, eye):
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
                first, end, root, leaves = shapes.meshes[shape]
                mesh, tree = triangles[first:end], boxes[root:]
                t = first_crossing(mesh, tree, leaves, origin, ray, nearest[shape], distances[i], waiting)
            else:
                t = _entry(kind, size, origin, ray)
            if nearest[shape] <= t < distances[i]:
                distances[i] = t


@jit
def _by_distance(places: FloatArray, radii: FloatArray, eye: FloatArray) -> IntArray:
    """Return the shapes, the nearest first, so that most of the others can be skipped."""
    away = np.empty(len(radii))
    for shape in range(len(radii)):
        x, y, z = places[shape, 0, 3] - eye[0], places[shape, 1, 3] - eye[1], places[shape, 2, 3] - eye[2]
        away[shape] = sqrt(x * x + y * y + z * z) - radii[shape]
    return np.argsort(away)


@jit
def _place(shapes: _Shapes, frames: FloatArray, places: FloatArray) -> None:
    """Store the places of shapes that move, by those of their frames; both have the shape ``(n, 3, 4)``."""
    for shape in range(len(shapes.held)):
        if shapes.held[shape] != WORLD_FRAME:
            _compose(frames[shapes.held[shape]], shapes.local[shape], places[shape])


@jit
def _compose(outer: FloatArray, inner: FloatArray, result: FloatArray) -> None:
    """Store the transform that applies first the inner and then the outer one, all of shape ``(3, 4)``."""
    for row in range(3):
        x, y, z = outer[row, 0], outer[row, 1], outer[row, 2]
        for column in range(4):
            result[row, column] = x * inner[0, column] + y * inner[1, column] + z * inner[2, column]
        result[row, 3] += outer[row, 3]


@jit
def _scan(
    shapes: _Shapes,
    places: FloatArray,
    hidden: npt.NDArray[np.bool_],
    nearest: FloatArray,
    frame: FloatArray,
    local: FloatArray,
    directions: FloatArray,
    reach: tuple[float, float, float],
) -> FloatArray:
    """Return the distance along each ray of a scanner, as :meth:`CollisionSpace.scan` does.

    Args:
        shapes: the shapes.
        places: rotation and translation of each shape to the world, shape ``(n, 3, 4)``.
        hidden: shapes that are ignored.
        nearest: minimum distance of a hit of each shape, m, shape ``(n,)``.
        frame: rotation and translation of the scanner's frame to the world, shape ``(3, 4)``.
        local: those of the scanner to this frame.
        directions: of the rays from the scanner, shape ``(k, 3)``.
        reach: the minimum distance, the maximum distance, and the next number, m.
    """
    scanner, rays = np.empty((3, 4)), np.empty((len(directions), 3))
    _compose(frame, local, scanner)
    for i in range(len(rays)):
        x, y, z = directions[i]
        for axis in range(3):
            rays[i, axis] = x * scanner[axis, 0] + y * scanner[axis, 1] + z * scanner[axis, 2]
    low, high, beyond = reach
    eye, distances = scanner[:, 3].copy(), np.full(len(rays), beyond)
    _cast(shapes, places, hidden, nearest, eye, rays, distances)
    for i in range(len(rays)):
        if distances[i] > high:
            distances[i] = inf
        elif distances[i] < low:
            distances[i] = -inf
    return distances


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


class _Scanner(NamedTuple):
    """A scanner in a space.

    Args:
        hidden: the shapes that it ignores.
        starts: minimum distance of a hit of each shape, m.
        frame: number of the frame that it moves with.
        local: its rotation and translation in that frame, shape ``(3, 4)``.
        directions: of its rays, shape ``(rays, 3)``.
        reach: the minimum distance, the maximum distance, and the next number, m.
    """

    hidden: npt.NDArray[np.bool_]
    starts: FloatArray
    frame: int
    local: FloatArray
    directions: FloatArray
    reach: tuple[float, float, float]


class CollisionSpace:
    """All collision shapes of a scene.

    Args:
        bodies: of each model.
        reader: called once with the paths of the moving bodies; returns a function that writes their poses.
    """

    def __init__(
        self, bodies: Mapping[str, Sequence[Body]], reader: Callable[[Sequence[BodyPath]], ReadFrames]
    ) -> None:
        self._bodies = bodies
        moving = [
            (model, i) for model, each in bodies.items() for i, body in enumerate(each) if not body.fixed
        ]
        self._numbers = {path: number for number, path in enumerate(moving, start=WORLD_FRAME + 1)}
        shapes = [shape for model, each in bodies.items() for shape in _shapes_of(model, each)]
        self._scanners: dict[tuple[str, str, Beams], _Scanner] = {}
        self._owners = [path for path, *_ in shapes]
        self._names = [name for _, name, *_ in shapes]
        self._shapes = [(collision.geometry, place @ collision.pose) for *_, collision, place in shapes]
        self._set_up([geometry for geometry, _ in self._shapes])
        self._observe(reader)

    def copy(self, reader: Callable[[Sequence[BodyPath]], ReadFrames]) -> CollisionSpace:
        """Return the shapes of the same scene in another state."""
        other = copy(self)
        other._observe(reader)
        return other

    def _observe(self, reader: Callable[[Sequence[BodyPath]], ReadFrames]) -> None:
        self._frames = np.tile(np.eye(3, 4), (1 + len(self._numbers), 1, 1))
        self._read = reader(list(self._numbers))
        self._places = self._arrays.local.copy()

    def _set_up(self, geometries: Sequence[Geometry]) -> None:
        """Arrange the shapes in arrays."""
        n = len(geometries)
        meshes = [_triangles(each) for each in geometries]
        middles = [_middle(each) for each in meshes]
        meshes = [mesh - middle for mesh, middle in zip(meshes, middles, strict=True)]
        self._trees = trees = mesh_trees(meshes)
        places = [pose @ Pose(middle) for (_, pose), middle in zip(self._shapes, middles, strict=True)]
        self._arrays = _Shapes(
            np.array([_KINDS[type(each)] for each in geometries], np.int64),
            np.array([_size(each) for each in geometries]).reshape(n, 3),
            np.array([_radius(*each) for each in zip(geometries, meshes, strict=True)]),
            trees.places,
            trees.triangles,
            trees.boxes,
            np.array([self._numbers.get(path, WORLD_FRAME) for path in self._owners], np.int64),
            np.array([matrix_of(place) for place in places]).reshape(n, 3, 4),
        )

    def scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        """Return the distance along each ray, layer by layer, m.

        It is ``inf`` for a ray that hits nothing, and ``-inf`` for one that another model blocks nearer than
        the minimum distance (REP 117). The body that carries the scanner is ignored, and so are parts of its
        model that are nearer than the minimum.
        """
        self._update()
        scanner = self._scanner(model, link, beams)
        frame = self._frames[scanner.frame]
        hidden, starts, local, rays = scanner.hidden, scanner.starts, scanner.local, scanner.directions
        return _scan(self._arrays, self._places, hidden, starts, frame, local, rays, scanner.reach)

    def _scanner(self, model: str, link: str, beams: Beams) -> _Scanner:
        """Return the data that all scans of a scanner share."""
        key = model, link, beams
        if key not in self._scanners:
            low, high = map(float, beams.reach)
            index = body_of(self._bodies[model], link)
            body = self._bodies[model][index]
            held = next(part.pose for part in body.links if part.name == link)
            self._scanners[key] = _Scanner(
                np.array([path == (model, index) for path in self._owners], bool),
                np.where([owner == model for owner, _ in self._owners], low, 0.0),
                self._numbers.get((model, index), WORLD_FRAME),
                matrix_of(place_in_frame(body) @ held @ beams.pose),
                directions(beams),
                (low, high, float(np.nextafter(high, inf))),
            )
        return self._scanners[key]

    def named(self, touches: Iterable[Touch]) -> list[tuple[Touch, tuple[str, str]]]:
        """Return contacts with the names of both collisions, ``model/link/collision``."""
        return [
            (
                each,
                (self._name_at(each.bodies[0], each.position), self._name_at(each.bodies[1], each.position)),
            )
            for each in touches
        ]

    def _name_at(self, path: BodyPath, position: Vector) -> str:
        """Return the collision of a body, ``model/link/collision``, whose surface is nearest to a point."""
        mine = [i for i, owner in enumerate(self._owners) if owner == path]
        if len(mine) > 1:
            self._update()
            mine.sort(key=lambda i: self._distance(i, position))
        return self._names[mine[0]]

    def _distance(self, shape: int, position: Vector) -> float:
        """Return the distance of a point of the world from a shape's surface, of meshes to few triangles."""
        geometry, place = self._shapes[shape][0], self._places[shape]
        x, y, z = product(place[:, :3].T, position - place[:, 3]).tolist()
        if isinstance(geometry, Mesh):
            return self._trees.distance(shape, (x, y, z))
        return abs(signed_distance(geometry, _NO_TRIANGLES, (x, y, z)))

    def _update(self) -> None:
        self._read(self._frames[WORLD_FRAME + 1 :])
        _place(self._arrays, self._frames, self._places)


_KINDS: Mapping[type[Geometry], int] = {
    Plane: PLANE, Sphere: SPHERE, Box: BOX, Cylinder: CYLINDER, Capsule: CAPSULE, Mesh: MESH, Heightmap: MESH,
    ConcaveMesh: MESH,
}  # fmt: skip


def _shapes_of(model: str, bodies: Sequence[Body]) -> Iterator[tuple[BodyPath, str, Collision, Pose]]:
    """Return each collision with its body, its name, and the pose of its link in the body's frame."""
    for index, body in enumerate(bodies):
        for link in body.links:
            for collision in link.collisions:
                name = f"{model}/{link.name}/{collision.name}"
                yield (model, index), name, collision, place_in_frame(body) @ link.pose


def _triangles(geometry: Geometry) -> FloatArray:
    """Return the triangles of a mesh, shape ``(n, 3, 3)``; empty for other shapes."""
    if not isinstance(geometry, Mesh):
        return np.empty((0, 3, 3))
    vertices, faces = triangles_of(geometry)
    return np.asarray(vertices[faces], float)


def _middle(triangles: FloatArray) -> Vector:
    """Return the middle of the bounding box of triangles; the origin without triangles."""
    if not len(triangles):
        return 0.0, 0.0, 0.0
    x, y, z = ((triangles.min((0, 1)) + triangles.max((0, 1))) / 2).tolist()
    return x, y, z


def _size(geometry: Geometry) -> Vector:
    match geometry:
        case Box((x, y, z)):
            return x / 2, y / 2, z / 2
        case Cylinder(radius, length) | Capsule(radius, length):
            return radius, radius, length / 2
        case Sphere(radius):
            return radius, radius, radius
    return inf, inf, inf


def _radius(geometry: Geometry, triangles: FloatArray) -> float:
    """Return the radius of the bounding sphere of a shape about the origin."""
    match geometry:
        case Box():
            return hypot(*_size(geometry))
        case Cylinder(radius, length):
            return hypot(radius, length / 2)
        case Capsule(radius, length):
            return radius + length / 2
        case Sphere(radius):
            return radius
        case Mesh():
            return float(np.linalg.norm(triangles, axis=2).max(initial=0.0))
    return inf


def signed_distance(geometry: Geometry, triangles: FloatArray, point: Vector) -> float:
    """Return the distance of a point from a surface, negative inside; a mesh counts as the box around it."""
    x, y, z = point
    match geometry:
        case Plane():
            return z
        case Sphere(radius):
            return hypot(x, y, z) - radius
        case Capsule(radius, length):
            return hypot(x, y, z - max(-length / 2, min(length / 2, z))) - radius
        case Cylinder(radius, length):
            return _outside((hypot(x, y) - radius, abs(z) - length / 2))
        case Box((a, b, c)):
            return _outside((abs(x) - a / 2, abs(y) - b / 2, abs(z) - c / 2))
    low, high = triangles.min((0, 1)), triangles.max((0, 1))
    return _outside(np.maximum(low - point, point - high).tolist())


def _outside(beyond: Sequence[float]) -> float:
    return hypot(*(max(each, 0.0) for each in beyond)) + min(max(beyond), 0.0)
