"""The lights of a scene as rows for the shading, with their shadow maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import cos, inf, tan

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.pixels import NearnessArray
from nrp_core.world.scene.model import Light

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

    def look(self, centre: FloatArray, radius: float, draw: DrawMap) -> None:
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
    direction = np.array(light.direction) / np.linalg.norm(light.direction)
    return (*light.pose.position, *direction, *light.diffuse[:3], placed, *light.attenuation, *cosines)


def _views(
    light: Light, centre: FloatArray, radius: float
) -> Iterator[tuple[FloatArray, float, float, float]]:
    """Return eye, focal length, near and far distance of each map of a light."""
    place, direction = np.array(light.pose.position), np.array(light.direction, float)
    if light.kind == "directional":
        away = FAR * radius
        eye = _eye(centre - away * direction / np.linalg.norm(direction), direction)
        yield eye, SIZE / 2 * FAR, away / 2, 4 * away
        return
    far = light.attenuation[0] if light.attenuation[0] < inf else 1e6
    if light.kind == "spot":
        yield _eye(place, direction), SIZE / 2 / (tan(light.cone[1] / 2) * SPOT_MARGIN), NEAREST, far
        return
    for side in _SIDES:
        yield _eye(place, np.array(side, float)), CUBE_FOCAL, NEAREST, far


def _eye(place: FloatArray, direction: FloatArray) -> FloatArray:
    """Return rotation and translation of an eye that looks in a direction, shape ``(3, 4)``."""
    back = -direction / np.linalg.norm(direction)
    upwards = np.array([1.0, 0.0, 0.0]) if abs(back[2]) > 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(upwards, back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back, place])
