"""Images with light and shadows, drawn on the CPU and the same for every engine, like the flat ones.

Surfaces are matt (Lambert's law), or glossy by their finish
(:mod:`nrp_core.world.render.gloss`); their edges are sharp and their curves smooth. Shadows come from
shadow maps (Williams, Casting curved shadows on curved surfaces, SIGGRAPH 1978). Light is added to SDF's
default ambient light, which comes from all directions; metals reflect it and not other objects. Glowing
surfaces do not light others. Images on surfaces are their colours; maps of their finish are averaged.

Colours and images are linear: a byte is proportional to the light, without gamma. A surface in the light that
makes white surfaces white has the bytes of a flat image.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import cos, inf, sqrt, tan
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit
from nrp_core._support.small_matrices import length
from nrp_core.scene.merged_bodies import WORLD_FRAME, Body
from nrp_core.scene.model import Light
from nrp_core.scene.rigid import BodyPath, ReadFrames
from nrp_core.world.render.cameras import CameraPath, ImageArray, Optics
from nrp_core.world.render.gloss import MATT, Gloss, add_gloss, begin_gloss, tint_gloss
from nrp_core.world.render.pixels import NOTHING, NearnessArray
from nrp_core.world.render.raster import RasterCameras

BIAS = 1.5
"""Offset of a point from its surface for the look-up in a shadow map, in texels."""


@inlined
def way_to(lamps: FloatArray, lamp: int, place: FloatArray) -> tuple[float, float, float, float]:
    """Return the unit vector from a point to a lamp, and the distance; 0 for a directional lamp."""
    if lamps[lamp, 9] <= 0:
        return -lamps[lamp, 3], -lamps[lamp, 4], -lamps[lamp, 5], 0.0
    x, y, z = lamps[lamp, 0] - place[0], lamps[lamp, 1] - place[1], lamps[lamp, 2] - place[2]
    distance = max(sqrt(x * x + y * y + z * z), 1e-9)
    return x / distance, y / distance, z / distance, distance


@inlined
def add_light(
    place: FloatArray,
    normal: FloatArray,
    lamps: FloatArray,
    lamp: int,
    maps: NearnessArray,
    map_eyes: FloatArray,
    map_focals: FloatArray,
    light: FloatArray,
) -> None:
    """Add the light from one lamp at a point.

    Args:
        place: the point.
        normal: normal of the surface there; light from behind does not count.
        lamps: one in each row, in the layout of :class:`~nrp_core.world.render.realistic.Lamps`.
        lamp: row of the lamp.
        maps: reciprocal depths seen from the lamps, shape ``(k, size, size)``.
        map_eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        map_focals: focal lengths of the maps.
        light: the sum: red, green and blue light on the surface; a white matt surface shows the same values.
    """
    x, y, z, distance = way_to(lamps, lamp, place)
    strength = 1.0
    if distance > 0:
        if distance > lamps[lamp, 10]:
            return
        strength = 1.0 / max(
            lamps[lamp, 11] + distance * (lamps[lamp, 12] + distance * lamps[lamp, 13]), 1e-9
        )
        cosine = -(x * lamps[lamp, 3] + y * lamps[lamp, 4] + z * lamps[lamp, 5])
        strength *= min(
            1.0, max(0.0, (cosine - lamps[lamp, 15]) / max(lamps[lamp, 14] - lamps[lamp, 15], 1e-9))
        )
    slope = x * normal[0] + y * normal[1] + z * normal[2]
    if slope <= 0 or strength <= 0:
        return
    for number in range(int(lamps[lamp, 16]), int(lamps[lamp, 17])):
        strength *= lit_share(place, normal, maps, map_eyes, map_focals[number], number, 1.0)
    for channel in range(3):
        light[channel] += lamps[lamp, 6 + channel] * slope * strength


@inlined
def lit_share(
    place: FloatArray,
    normal: FloatArray,
    maps: NearnessArray,
    eyes: FloatArray,
    focal: float,
    number: int,
    outside: float,
) -> float:
    """Return the lit share of the surroundings of a point; ``outside`` if not in the lamp's map."""
    size = maps.shape[1]
    depth = 0.0
    for axis in range(3):
        depth -= eyes[number, axis, 2] * (place[axis] - eyes[number, axis, 3])
    if depth <= 0:
        return outside
    lift = BIAS * depth / focal
    x = y = 0.0
    for axis in range(3):
        offset = place[axis] + lift * normal[axis] - eyes[number, axis, 3]
        x, y = x + eyes[number, axis, 0] * offset, y + eyes[number, axis, 1] * offset
        depth -= eyes[number, axis, 2] * lift * normal[axis]
    column, row = size / 2 + focal * x / depth - 0.5, size / 2 - focal * y / depth - 0.5
    if not (0 <= column < size - 1 and 0 <= row < size - 1):
        return outside
    left, top = int(column), int(row)
    across, down = column - left, row - top
    share = 0.0
    for i in range(2):
        for j in range(2):
            weight = (down if i else 1 - down) * (across if j else 1 - across)
            if maps[number, top + i, left + j] * depth <= 1.0:
                share += weight
    return share


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


def smooth_normals(vertices: FloatArray, faces: IndexArray) -> FloatArray:
    """Return a unit normal for each corner of each face, see :func:`corner_normals`."""
    corners = np.argsort(faces, axis=None, kind="stable").astype(np.int32)
    starts = np.searchsorted(faces.ravel()[corners], np.arange(len(vertices) + 1))
    return corner_normals(vertices, faces, corners, starts.astype(np.int32))


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


SIZE = 1024
"""Width and height of a shadow map, in texels."""
FAR = 1000.0
"""Distance of a directional light in sizes of the lit scene: its rays are practically parallel."""
NEAREST = 0.01
"""Objects nearer to a light (m) cast no shadow, such as its housing."""
CUBE_FOCAL = SIZE / 2 / 1.02  # a little more than a side of the cube, so that no point falls between two
SPOT_MARGIN = 1.02

DrawMap = Callable[[FloatArray, float, float, float, NearnessArray], object]
"""Draws reciprocal depths into a map, from an eye, with a focal length, a near and a far distance."""

_SIDES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
_WIDTH = 18


class Lamps:
    """The lights that are on, one in each row.

    Columns: place (3), direction (3), colour (3), whether it has a place; range, constant, linear and
    quadratic attenuation; cosines of half the inner and outer angle of the cone; the first of its shadow maps
    and the first of the next light's.

    Args:
        lights: lights of the scene; a black one is off.

    Attributes:
        rows: shape ``(n, 18)``.
        maps: reciprocal depths seen from the lights, shape ``(k, size, size)``.
        eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        focals: focal lengths of the maps, shape ``(k,)``.
    """

    def __init__(self, lights: Sequence[Light]) -> None:
        shining = [light for light in lights if any(light.diffuse[:3])]
        counts = [_maps_of(light) for light in shining]
        ends = np.cumsum([0, *counts])
        self._shadowing = [light for light, count in zip(shining, counts, strict=True) if count]
        self.rows = np.empty((len(shining), _WIDTH))
        for row, light, first, end in zip(self.rows, shining, ends[:-1], ends[1:], strict=True):
            row[:] = (*_shine(light), first, end)
        self.maps = np.empty((ends[-1], SIZE, SIZE), np.float32)
        self.eyes = np.empty((ends[-1], 3, 4))
        self.focals = np.empty(ends[-1])

    def draw_shadows(self, centre: FloatArray, radius: float, draw: DrawMap) -> None:
        """Draw all shadow maps.

        Args:
            centre: centre of the scene that directional lights light, m.
            radius: of a sphere around it.
            draw: draws a map.
        """
        views = (view for light in self._shadowing for view in _views(light, centre, radius))
        for number, (eye, focal, near, far) in enumerate(views):
            self.eyes[number], self.focals[number] = eye, focal
            draw(eye, focal, near, far, self.maps[number])


def _maps_of(light: Light) -> int:
    if not light.casts_shadows:
        return 0
    return len(_SIDES) if light.kind == "point" else 1


def _shine(light: Light) -> tuple[float, ...]:
    inner, outer = light.cone if light.kind == "spot" else (None, None)
    cosines = (-2.0, -3.0) if inner is None or outer is None else (cos(inner / 2), cos(outer / 2))
    placed = float(light.kind != "directional")
    direction = np.array(light.direction) / length(light.direction)
    return (*light.pose.position, *direction, *light.diffuse[:3], placed, *light.attenuation, *cosines)


def _views(
    light: Light, centre: FloatArray, radius: float
) -> Iterator[tuple[FloatArray, float, float, float]]:
    """Return eye, focal length, near and far distance of each map of a light."""
    place, direction = np.array(light.pose.position), np.array(light.direction, float)
    if light.kind == "directional":
        away = FAR * radius
        eye = eye_towards(centre - away * direction / length(direction), direction)
        yield eye, SIZE / 2 * FAR, away / 2, 4 * away
        return
    far = light.attenuation[0] if light.attenuation[0] < inf else 1e6
    if light.kind == "spot":
        yield eye_towards(place, direction), SIZE / 2 / (tan(light.cone[1] / 2) * SPOT_MARGIN), NEAREST, far
        return
    for side in _SIDES:
        yield eye_towards(place, np.array(side, float)), CUBE_FOCAL, NEAREST, far


def eye_towards(place: FloatArray, direction: FloatArray) -> FloatArray:
    """Return rotation and translation of an eye that looks in a direction, shape ``(3, 4)``."""
    back = -direction / length(direction)
    upwards = np.array([1.0, 0.0, 0.0]) if abs(back[2]) > 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(upwards, back)
    right /= length(right)
    return np.column_stack([right, np.cross(back, right), back, place])


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
        lamps: one in each row, in the layout of :class:`~nrp_core.world.render.realistic.Lamps`.
        maps: reciprocal depths seen from the lamps, shape ``(k, size, size)``.
        map_eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        map_focals: focal lengths of the maps.
        image: the colours, RGB, replaced by the result; the background does not change.
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
                to_eye = _view_direction(eye, place, normal, view)
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
def _view_direction(eye: FloatArray, place: FloatArray, normal: FloatArray, view: FloatArray) -> float:
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


AMBIENT = 0.4
"""The ambient light of a scene in SDF (its specification, ``<scene><ambient>``)."""

_MARGIN_M = 0.1


class RealisticCameras(RasterCameras):
    """Draws any camera of a scene with its lights.

    Args:
        bodies: bodies of each model.
        optics: optics of each camera.
        reader: as of :class:`~nrp_core.world.render.raster.RasterCameras`.
        lights: lights of the scene.
    """

    def __init__(
        self,
        bodies: Mapping[str, Sequence[Body]],
        optics: Mapping[CameraPath, Optics],
        reader: Callable[[Sequence[BodyPath]], ReadFrames],
        lights: Sequence[Light],
    ) -> None:
        super().__init__(bodies, optics, reader)
        mesh = self._mesh
        self._lamps = Lamps(lights)
        self._frame_of_face = mesh.vertex_frames[mesh.faces[:, 0]]
        self._normals = smooth_normals(mesh.vertices, mesh.faces)
        self._gloss = Gloss(mesh.finishes)
        self._framed = np.empty(0, bool)
        self._mapped: tuple[npt.NDArray[Any], ...] = ()

    def set_lights(self, lights: Sequence[Light]) -> None:
        self._lamps = Lamps(lights)
        self._mapped = ()

    def look(self, path: CameraPath) -> None:
        return None

    def image(self, path: CameraPath) -> ImageArray:
        mesh, lamps, optics = self._mesh, self._lamps, self._optics[path]
        nearness = self._work_of(path).nearness
        image, seen, points, eye = self._draw_flat(path)
        self._map_shadows(points)
        colors = mesh.palette[:-1] / 255
        finishes = self._gloss.of(colors), self._gloss.tables
        looks = (self._frame_of_face, mesh.surfaces, colors, mesh.glowing, *finishes)
        shapes = (points, mesh.faces, self._normals, self._frames, *looks)
        light = (AMBIENT, lamps.rows, lamps.maps, lamps.eyes, lamps.focals)
        shade(seen, nearness, optics.focal, eye, *shapes, *light, image)
        return image

    def _map_shadows(self, points: FloatArray) -> None:
        """Draw the shadow maps, unless they are up to date, as for a second camera at the same time."""
        now = points, self._mesh.shown.copy()
        if self._mapped and all(map(np.array_equal, now, self._mapped)):
            return
        if not self._mapped or not np.array_equal(now[1], self._mapped[1]):
            self._framed = self._mesh.framed(points)
        self._mapped = now
        self._lamps.draw_shadows(*self._lit_sphere(points), lambda *view: self._view.draw(points, *view))

    def _lit_sphere(self, points: FloatArray) -> tuple[FloatArray, float]:
        """Return centre and radius of the region in which directional lights cast shadows."""
        if not len(points):
            return np.zeros(3), 1.0
        low, high = points[self._framed].min(axis=0), points[self._framed].max(axis=0)
        return (low + high) / 2, length(high - low) / 2 + _MARGIN_M


_VIEW: Final[CameraPath] = ("", "", "")
_NEAR_M = 1e-3


class LitView(RealisticCameras):
    """Draws bodies from any place, as realistic cameras do.

    Args:
        bodies: the bodies of each model.
        lights: the lights.
        width, height: the size of the images, pixels.
        vertical_fov: vertical field of view, rad.
        samples: a pixel is the mean of ``samples`` times ``samples`` samples.
    """

    def __init__(
        self,
        bodies: Mapping[str, Sequence[Body]],
        lights: Sequence[Light],
        width: int,
        height: int,
        *,
        vertical_fov: float,
        samples: int = 2,
    ) -> None:
        self._size = width, height
        self._placed = np.empty((0, 3, 4))
        optics = Optics(width * samples, height * samples, vertical_fov, near=_NEAR_M, far=1e4)
        super().__init__(bodies, {}, self._reader, lights)
        self._optics = {_VIEW: optics}

    def draw(self, frames: FloatArray, eye: FloatArray) -> npt.NDArray[np.uint8]:
        """Return an image, RGB, shape ``(height, width, 3)``.

        Args:
            frames: rotation and translation of the bodies that move, shape ``(n, 3, 4)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        """
        import cv2

        self._placed = frames
        self._eyes[_VIEW] = WORLD_FRAME, eye
        image = cv2.resize(self.image(_VIEW), self._size, interpolation=cv2.INTER_AREA)
        return image.astype(np.uint8, copy=False)

    def _reader(self, paths: Sequence[BodyPath]) -> ReadFrames:
        def read(rows: FloatArray) -> None:
            rows[:] = self._placed

        return read
