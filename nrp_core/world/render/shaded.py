"""Pictures of a scene for people: a sun with shadows, light from the sky, and a grid on the floor.

Videos, portraits and the pictures in notebooks are drawn here, with the look of the cockpit. The images of
robots' cameras have the colours of the scene (:mod:`nrp_core.world.render.raster`) or its lights
(:mod:`nrp_core.world.render.realistic`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10, sqrt, tan

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.jit import inlined, jit
from nrp_core.scene.merged_bodies import WORLD_FRAME
from nrp_core.scene.model import Light
from nrp_core.world.render.cameras import Optics
from nrp_core.world.render.pixels import NOTHING, NearnessArray
from nrp_core.world.render.raster import FaceView
from nrp_core.world.render.realistic import FAR, SIZE, eye_towards, find_normal, lit_share, smooth_normals
from nrp_core.world.render.scene_mesh import SceneMesh

BACKGROUND = (240, 243, 247)
_NEAR_M = 1e-4  # depths are stored as reciprocals, so a short distance does not reduce precision

SUN = (0.5, -0.1, 0.9)
"""The direction to the sun of a scene without one: SDF's default."""
_LEAST_HEIGHT = 0.4  # minimum z of the unit vector to the sun, so that shadows do not cover a room
_SKY, _SKY_SLOPE, _SUNSHINE = 0.54, 0.14, 0.36
"""Sky light on a vertical surface, the additional sky light on a horizontal one, and sunlight."""

_LINES = 5.0  # the grid has at least this many steps in the width of the first image
_LINE = 0.012  # width of a line, in steps
_LINE_STRENGTH, _MAJOR_STRENGTH = 0.16, 0.30  # darkness of a line, and of each fifth line
_SHADE_ON_NOTHING = 0.16
_NEAR_MAP = 2.2  # radius of the detailed shadow map, in multiples of half the width of the image
_DENSE = 0.35  # lines are not resolved if a pixel is wider than this share of a step
_FLAT_M = 1e-3


@jit
def light(
    seen: IndexArray,
    nearness: NearnessArray,
    samples: int,
    focal: float,
    eye: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    normals: FloatArray,
    turns: FloatArray,
    face_frames: IndexArray,
    surfaces: IndexArray,
    palette: npt.NDArray[np.uint8],
    laid: npt.NDArray[np.uint8],
    covered: npt.NDArray[np.bool_],
    grounds: npt.NDArray[np.bool_],
    grid: FloatArray,
    sun: FloatArray,
    maps: NearnessArray,
    map_eyes: FloatArray,
    map_focals: FloatArray,
    image: npt.NDArray[np.uint8],
) -> None:
    """Fill an image with the light from surfaces to the eye.

    A pixel that shows one triangle is computed once, at its centre; others are the mean of their samples.

    Args:
        seen: the face at each sample, shape ``(samples * height, samples * width)``.
        nearness: reciprocals of their depths, of the same shape.
        samples: samples of a pixel in each direction.
        focal: focal length, in samples.
        eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
        points: vertices in the world, shape ``(n, 3)``.
        faces: indices of vertices, shape ``(m, 3)``.
        normals: normals of their corners, in their frames, shape ``(m, 3, 3)``.
        turns: rotation and translation of each frame to the world, shape ``(f, 3, 4)``.
        face_frames: the frame of each face, shape ``(m,)``.
        surfaces: the surface of each face, shape ``(m,)``.
        palette: the colours of the surfaces, and last of the background.
        laid: the images on surfaces, of the shape of ``seen`` with three channels.
        covered: which faces have an image; shape ``(m,)``.
        grounds: which surfaces carry the grid; shape ``(k,)``.
        grid: step and height of the grid, its centre (x, y) and its radius, m.
        sun: unit vector to the sun.
        maps: reciprocal depths seen from the sun, the most detailed first, shape ``(k, size, size)``.
        map_eyes: rotation and translation of each map's eye to the world, shape ``(k, 3, 4)``.
        map_focals: focal lengths of the maps.
        image: the result, RGB, shape ``(height, width, 3)``.
    """
    height, width = image.shape[:2]
    total, base, place, normal, up = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    up[2] = 1.0
    middle, centre = seen.shape[1] / 2, seen.shape[0] / 2
    flat = NOTHING
    for row in range(height):
        for column in range(width):
            top, left = row * samples, column * samples
            near = _mean_nearness(seen, nearness, top, left, samples)
            parts = 1 if near >= 0.0 else samples
            step = samples // parts
            total.fill(0.0)
            for i in range(top, top + parts):
                for j in range(left, left + parts):
                    face = seen[i, j]
                    # a ray from the eye, with depth 1
                    x, y = (j + 0.5 * step - middle) / focal, (centre - i - 0.5 * step) / focal
                    if face == NOTHING:
                        _find_place(eye, x, y, _depth_of_floor(eye, x, y, grid), place)
                        shadows = maps, map_eyes, map_focals
                        _add_floor(eye, place, x, y, step / focal, palette, grid, up, *shadows, total)
                        continue
                    depth = 1.0 / (near if parts == 1 else nearness[i, j])
                    _find_place(eye, x, y, depth, place)
                    if face != flat:  # the normal of a flat face is that of the previous point
                        find_normal(place, points, faces, face, normals, turns, face_frames[face], normal)
                        flat = face if _is_flat(normals[face]) else NOTHING
                    surface = surfaces[face]
                    _mix_colors(laid, palette[surface], covered[face], i, j, step, base)
                    bright = _brightness(place, normal, sun, maps, map_eyes, map_focals)
                    if grounds[surface] and normal[2] > 0.99:
                        bright *= 1.0 - _line(eye, place, x, y, depth * step / focal, grid)
                    for channel in range(3):
                        total[channel] += min(255.0, base[channel] * bright)
            for channel in range(3):
                image[row, column, channel] = int(total[channel] / (parts * parts) + 0.5)


@inlined
def _mean_nearness(seen: IndexArray, nearness: NearnessArray, top: int, left: int, samples: int) -> float:
    """Return the mean of the reciprocal depths of a pixel's samples; -1 if they show several faces."""
    total = 0.0
    for i in range(top, top + samples):
        for j in range(left, left + samples):
            if seen[i, j] != seen[top, left]:
                return -1.0
            total += nearness[i, j]
    return total / (samples * samples)


@inlined
def _find_place(eye: FloatArray, x: float, y: float, depth: float, place: FloatArray) -> None:
    for axis in range(3):
        place[axis] = eye[axis, 3] + depth * (eye[axis, 0] * x + eye[axis, 1] * y - eye[axis, 2])


@inlined
def _depth_of_floor(eye: FloatArray, x: float, y: float, grid: FloatArray) -> float:
    """Return the depth at which a ray meets the height of the grid; -1 if it does not."""
    down = eye[2, 0] * x + eye[2, 1] * y - eye[2, 2]
    depth: float = (grid[1] - eye[2, 3]) / down if down < -1e-6 else -1.0
    return depth


@inlined
def _brightness(
    place: FloatArray,
    normal: FloatArray,
    sun: FloatArray,
    maps: NearnessArray,
    eyes: FloatArray,
    focals: FloatArray,
) -> float:
    bright: float = _SKY + _SKY_SLOPE * normal[2]
    slope = sun[0] * normal[0] + sun[1] * normal[1] + sun[2] * normal[2]
    if slope > 0.0:
        bright += _SUNSHINE * slope * _sunlit(place, normal, maps, eyes, focals)
    return bright


@inlined
def _is_flat(corners: FloatArray) -> bool:
    for axis in range(3):
        if corners[0, axis] != corners[1, axis] or corners[0, axis] != corners[2, axis]:
            return False
    return True


@inlined
def _mix_colors(
    laid: npt.NDArray[np.uint8],
    color: npt.NDArray[np.uint8],
    is_covered: bool,
    top: int,
    left: int,
    step: int,
    base: FloatArray,
) -> None:
    """Write the colour of a surface, or the mean of the image on it."""
    for channel in range(3):
        if not is_covered:
            base[channel] = color[channel]
            continue
        base[channel] = 0.0
        for i in range(step):
            for j in range(step):
                base[channel] += laid[top + i, left + j, channel] / (step * step)


@inlined
def _sunlit(
    place: FloatArray, normal: FloatArray, maps: NearnessArray, eyes: FloatArray, focals: FloatArray
) -> float:
    """Return the share of sunlight at a point, from the first map that shows the point."""
    share = -1.0
    for number in range(len(maps)):
        if share < 0.0:
            share = lit_share(place, normal, maps, eyes, focals[number], number, -1.0)
    return 1.0 if share < 0.0 else share


@inlined
def _line(eye: FloatArray, place: FloatArray, x: float, y: float, pixel_m: float, grid: FloatArray) -> float:
    """Return the darkness of the lines of the grid at a point; a line is at least one pixel wide.

    Args:
        eye: pose of the camera.
        place: the point.
        x: the ray to it, with depth 1.
        y: upwards in the image.
        pixel_m: the size of a pixel at this distance.
        grid: see :func:`light`.
    """
    aside_x, aside_y = place[0] - grid[2], place[1] - grid[3]
    fade = 1.0 - sqrt(aside_x * aside_x + aside_y * aside_y) / grid[4]
    if fade <= 0.0:
        return 0.0
    down = abs(eye[2, 0] * x + eye[2, 1] * y - eye[2, 2]) / sqrt(x * x + y * y + 1.0)
    dark = 0.0
    for part in range(2):
        step = grid[0] * (5.0 if part else 1.0)
        strength = _MAJOR_STRENGTH if part else _LINE_STRENGTH
        for axis in range(2):
            wide = pixel_m / max(down, 0.05)
            if wide > _DENSE * step:
                continue
            line = max(_LINE * grid[0], pixel_m)
            away = place[axis] / step
            away = abs(away - np.floor(away + 0.5)) * step
            cover = min(1.0, max(0.0, 0.5 + (0.5 * line - away) / wide)) * min(1.0, line / wide)
            dark = max(dark, cover * strength * (1.0 - wide / (_DENSE * step)))
    shown: float = dark * min(1.0, 2.0 * fade)
    return shown


@inlined
def _add_floor(
    eye: FloatArray,
    place: FloatArray,
    x: float,
    y: float,
    pixel: float,
    palette: npt.NDArray[np.uint8],
    grid: FloatArray,
    up: FloatArray,
    maps: NearnessArray,
    eyes: FloatArray,
    focals: FloatArray,
    total: FloatArray,
) -> None:
    """Add the background, and the grid and shadows on it where the ray meets the height of the floor."""
    bright, depth = 1.0, _depth_of_floor(eye, x, y, grid)
    if depth > 0.0:
        bright -= _line(eye, place, x, y, depth * pixel, grid)
        bright -= _SHADE_ON_NOTHING * (1.0 - _sunlit(place, up, maps, eyes, focals))
    for channel in range(3):
        total[channel] += palette[-1, channel] * bright


def sun_of(lights: Sequence[Light]) -> tuple[float, float, float]:
    """Return the direction to the sun: opposite to the first directional light, otherwise :data:`SUN`."""
    suns = [light.direction for light in lights if light.kind == "directional"]
    if not suns or not any(suns[0]):
        return SUN
    x, y, z = suns[0]
    return -x, -y, -z


@dataclass(frozen=True)
class _Stage:
    """The parts of a view that are the same in all its images.

    Args:
        grid: see :func:`light`.
        grounds: which visuals carry the grid.
        casts: which visuals cast shadows.
        framed: which vertices are not part of the scenery.
    """

    grid: FloatArray
    grounds: npt.NDArray[np.bool_]
    casts: npt.NDArray[np.bool_]
    framed: npt.NDArray[np.bool_]


class ShadedView:
    """Draws a mesh from any pose, with smooth edges, the sun, its shadows and a grid on the floor.

    The step of the grid follows from the distance in the first image, so it is constant in a video.

    Args:
        mesh: the visuals.
        width, height: the size of the images, pixels.
        vertical_fov: vertical field of view, rad.
        samples: a pixel at an edge is the mean of ``samples`` times ``samples`` samples.
        sun: direction to the sun.
    """

    def __init__(
        self,
        mesh: SceneMesh,
        width: int,
        height: int,
        *,
        vertical_fov: float,
        samples: int = 3,
        sun: Sequence[float] = SUN,
    ) -> None:
        self._mesh, self._size, self._samples = mesh, (width, height), samples
        self._faces = FaceView(mesh)
        self.optics = Optics(width * samples, height * samples, vertical_fov, near=_NEAR_M, far=1e4)
        self._nearness = np.empty((self.optics.height, self.optics.width), np.float32)
        self._wide = width / height * tan(vertical_fov / 2)
        self._sun = np.array(sun, float) / np.linalg.norm(sun)
        self._sun[2] = max(self._sun[2], _LEAST_HEIGHT)
        self._sun /= np.linalg.norm(self._sun)
        self._normals = smooth_normals(mesh.vertices, mesh.faces)
        self._frame_of_face = mesh.vertex_frames[mesh.faces[:, 0]]
        self._maps = np.empty((2, SIZE, SIZE), np.float32)
        self._map_eyes, self._map_focals = np.empty((2, 3, 4)), np.empty(2)
        self._stage: _Stage | None = None

    def draw(
        self, frames: FloatArray, eye: FloatArray, near_m: float = _NEAR_M, away_m: float | None = None
    ) -> npt.NDArray[np.uint8]:
        """Return an image, RGB, shape ``(height, width, 3)``.

        Args:
            frames: rotation and translation to the world of all frames of the mesh, shape ``(n, 3, 4)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            near_m: the minimum distance of drawn objects, m.
            away_m: distance to the middle of the picture, m; by default that of the objects there.
        """
        mesh, optics = self._mesh, self.optics
        points = mesh.in_world(frames)
        seen = self._faces.draw(points, eye, optics.focal, near_m, optics.far, self._nearness)
        away_m = away_m or self._distance(seen)
        stage = self._stage = self._stage or self._begin(points, eye, away_m)
        self._draw_shadows(points, eye, away_m, stage)
        laid = np.empty((*seen.shape, 3) if mesh.textures else (1, 1, 3), np.uint8)
        covered = np.zeros(len(mesh.faces), bool)
        if mesh.textures is not None:
            mesh.textures.lay(seen, self._nearness, optics.focal, eye, points, mesh.faces, laid)
            covered = mesh.textures.shown[mesh.surfaces]
        palette = np.vstack([mesh.palette[:-1], BACKGROUND]).astype(np.uint8)
        image = np.empty((self._size[1], self._size[0], 3), np.uint8)
        shapes = (points, mesh.faces, self._normals, frames, self._frame_of_face, mesh.surfaces)
        looks = (palette, laid, covered, stage.grounds, stage.grid)
        shadows = (self._sun, self._maps, self._map_eyes, self._map_focals)
        light(seen, self._nearness, self._samples, optics.focal, eye, *shapes, *looks, *shadows, image)
        return image

    def _distance(self, seen: IndexArray) -> float:
        """Return the typical distance of objects in the middle of the image, m; 1 if there are none."""
        height, width = seen.shape
        middle = slice(height // 3, 2 * height // 3), slice(width // 3, 2 * width // 3)
        near = self._nearness[middle][seen[middle] != NOTHING]
        return 1.0 / float(np.median(near)) if len(near) else 1.0

    def _begin(self, points: FloatArray, eye: FloatArray, away_m: float) -> _Stage:
        mesh = self._mesh
        used = np.unique(mesh.faces)
        moving = points[used][mesh.vertex_frames[used] != WORLD_FRAME]
        bottom = float(moving[:, 2].min()) if len(moving) else 0.0
        top = float(moving[:, 2].max()) if len(moving) else np.inf
        wide_m = 2.0 * self._wide * away_m
        step_m = _round_down(wide_m / _LINES)
        casts, grounds = np.ones(len(mesh.shown), bool), np.zeros(len(mesh.shown), bool)
        lows, highs = _boxes(mesh, points)
        still = np.zeros(len(mesh.shown), bool)
        still[mesh.surfaces[self._frame_of_face == WORLD_FRAME]] = True
        sizes, framed, scenery = highs - lows, mesh.framed(points), np.ones(len(mesh.shown), bool)
        scenery[mesh.surfaces[framed[mesh.faces[:, 0]]]] = False
        casts[still & (lows[:, 2] > top) | scenery] = False  # as a dome around the room
        large = (sizes[:, :2] > 2 * step_m).all(axis=1) & (sizes[:, 2] < 0.5 * sizes[:, :2].min(axis=1))
        grounds[still & large] = True
        casts[grounds] = False
        floor_m = min(0.0, bottom, lows[grounds | ~scenery, 2].min(initial=0.0))
        middle = eye[:, 3] - away_m * eye[:, 2]
        grid = np.array([step_m, floor_m - _FLAT_M * step_m, *middle[:2], 5 * wide_m])
        return _Stage(grid, grounds, casts, framed)

    def _draw_shadows(self, points: FloatArray, eye: FloatArray, away_m: float, stage: _Stage) -> None:
        """Draw what the sun sees: around the middle of the image in detail, and all of it."""
        mesh, middle = self._mesh, eye[:, 3] - away_m * eye[:, 2]
        spheres = [(middle, max(_NEAR_MAP * self._wide * away_m, 1e-6))]
        if stage.framed.any():
            low, high = points[stage.framed].min(axis=0), points[stage.framed].max(axis=0)
            spheres.append(((low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-6)))
        self._maps[:] = 0.0
        shown, mesh.shown = mesh.shown, mesh.shown & stage.casts
        for number, (centre, radius) in enumerate(spheres):
            away = FAR * radius
            self._map_eyes[number] = eye_towards(centre + away * self._sun, -self._sun)
            self._map_focals[number] = SIZE / 2 * FAR
            lens = (SIZE / 2 * FAR, away / 2, 4 * away)
            self._faces.draw(points, self._map_eyes[number], *lens, self._maps[number])
        mesh.shown = shown


def _round_down(length_m: float) -> float:
    """Return the largest length of 1, 2 or 5 times a power of ten that is not longer than the given one."""
    power = 10.0 ** np.floor(log10(max(length_m, 1e-9)))
    return float(power * max(factor for factor in (1, 2, 5) if factor * power <= length_m * 1.000001))


def _boxes(mesh: SceneMesh, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest corner of each visual, m, shape ``(k, 3)``."""
    lows, highs = np.full((len(mesh.shown), 3), np.inf), np.full((len(mesh.shown), 3), -np.inf)
    for corner in range(3):
        np.minimum.at(lows, mesh.surfaces, points[mesh.faces[:, corner]])
        np.maximum.at(highs, mesh.surfaces, points[mesh.faces[:, corner]])
    return lows, highs
