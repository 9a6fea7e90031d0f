"""The light of a lamp at a point: attenuation and shadows."""

from __future__ import annotations

from math import sqrt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined
from nrp_core.world.render.pixels import NearnessArray

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
        lamps: one in each row, in the layout of :class:`~nrp_core.world.render.lamps.Lamps`.
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
        strength *= _lit(place, normal, maps, map_eyes, map_focals[number], number)
    for channel in range(3):
        light[channel] += lamps[lamp, 6 + channel] * slope * strength


@inlined
def _lit(
    place: FloatArray, normal: FloatArray, maps: NearnessArray, eyes: FloatArray, focal: float, number: int
) -> float:
    """Return the share of a point's surroundings that is lit by a lamp; 1 outside its map."""
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
