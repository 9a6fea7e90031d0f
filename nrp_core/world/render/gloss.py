"""The finishes of the surfaces of a scene as rows for the shading, and the light that they reflect."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sqrt

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit
from nrp_core.scene.model import Finish

SMOOTHEST = 0.07
"""Minimum roughness: it shows the sun half a degree wide, its real size."""
STEPS = 64
"""Number of intervals in a table of cosines from 0 to 1."""
_HEIGHTS, _TURNS = 256, 64  # facets sampled for an entry of a table


def width_of(roughness: float) -> float:
    """Return the width of the distribution of slopes."""
    return max(roughness, SMOOTHEST) ** 2


@inlined
def schlick(cosine: float) -> float:
    """Return Schlick's weight between the reflectance at normal incidence and 1, by the facet's cosine."""
    rest = 1.0 - cosine
    weight: float = rest * rest * rest * rest * rest
    return weight


@inlined
def hiding(to_light: float, to_eye: float, width: float) -> float:
    """Return the share of facets visible from both directions, over four times the product of the cosines."""
    square = width * width
    light = to_eye * sqrt(to_light * to_light * (1 - square) + square)
    eye = to_light * sqrt(to_eye * to_eye * (1 - square) + square)
    return 0.5 / (light + eye)


@inlined
def lobe(to_light: float, to_eye: float, halfway: float, width: float) -> float:
    """Return pi times the light from perfect facets to the eye, divided by the light on the surface."""
    square = width * width
    spread = halfway * halfway * (square - 1) + 1
    return square / (spread * spread) * hiding(to_light, to_eye, width)


@jit
def tabulate(width: float, table: FloatArray) -> None:
    """Compute the reflection of uniform light from all directions.

    Args:
        width: width of the distribution of slopes.
        table: the result, shape ``(STEPS + 1, 2)``, for cosines to the eye from 0 to 1: a surface that
            reflects ``f`` head-on reflects ``f * table[:, 0] + table[:, 1]``.
    """
    for entry in range(STEPS + 1):
        to_eye = max(entry / STEPS, 1e-3)
        across = sqrt(1 - to_eye * to_eye)
        table[entry, :] = 0.0
        for height in range(_HEIGHTS):
            share = (height + 0.5) / _HEIGHTS  # equal shares of the facets that a beam from above hits
            halfway = sqrt((1 - share) / (1 + (width * width - 1) * share))
            aside = sqrt(1 - halfway * halfway)
            for turn in range(_TURNS):
                along = aside * cos(pi * (turn + 0.5) / _TURNS)
                facet = across * along + to_eye * halfway
                to_light = 2 * facet * halfway - to_eye
                if facet > 0 and to_light > 0:
                    seen = 4 * hiding(to_light, to_eye, width) * to_light * facet / halfway
                    weight = schlick(facet)
                    table[entry, 0] += seen * (1 - weight) / (_HEIGHTS * _TURNS)
                    table[entry, 1] += seen * weight / (_HEIGHTS * _TURNS)


@inlined
def interpolate_table(table: FloatArray, part: int, cosine: float) -> float:
    """Return a value of a table by linear interpolation."""
    at = cosine * STEPS
    below = min(int(at), STEPS - 1)
    value: float = table[below, part] + (at - below) * (table[below + 1, part] - table[below, part])
    return value


def returning(head_on: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the returned share of light between facets.

    Args:
        head_on: reflectance of a facet at normal incidence, 0..1.
        mean: mean share that perfect facets return by a single reflection.
    """
    facet = head_on + (1 - head_on) / 21  # Schlick's formula averaged over all directions
    share: FloatArray = facet * facet * mean / (1 - facet * (1 - mean))
    return share


def mean_of(tables: FloatArray) -> FloatArray:
    """Return the means of tables over all directions, weighted by cosine; shape ``(k, 2)``."""
    cosines = np.linspace(0.0, 1.0, STEPS + 1)
    return np.asarray(np.trapezoid(2 * cosines[:, None] * tables, cosines, axis=1))


MATT = -1.0
"""The table of a surface without a finish."""
_WIDTH = 16
_LEAST = 1e-6  # minimum of a mean share, which is 0 for the smoothest surfaces


class Gloss:
    """The finishes of surfaces, one in each row.

    Columns: the table, or :data:`MATT`; the width of the distribution of slopes; the reflectance of a facet
        at normal incidence (3); the diffuse colour (3), and the same divided by the mean share of light that
        enters (3); the returned share of light between facets (3), the reciprocal of the mean share of such
        light, and the metalness.

    Args:
        finishes: finish of each surface, None for a matt one.

    Attributes:
        tables: reflectances for uniform light from all directions, shape ``(k, STEPS + 1, 2)``.
    """

    def __init__(self, finishes: Sequence[Finish | None]) -> None:
        widths = [width_of(finish.roughness) if finish else 0.0 for finish in finishes]
        distinct = sorted({*widths} - {0.0})
        self.tables = np.zeros((max(1, len(distinct)), STEPS + 1, 2))  # at least one, unread
        for table, width in zip(self.tables, distinct, strict=False):
            tabulate(width, table)
        shining = [finish for finish in finishes if finish]
        self._glossy = np.array([finish is not None for finish in finishes], bool)
        self._metalness = np.array([[finish.metalness] for finish in shining]).reshape(-1, 1)
        self._reflectance = np.array([finish.reflectance for finish in shining]).reshape(-1, 3)
        self._rows = np.full((len(finishes), _WIDTH), MATT)
        self._rows[:, 1] = widths
        tables = np.searchsorted(distinct, self._rows[self._glossy, 1])
        self._rows[self._glossy, 0] = tables
        self._scale, self._offset = (mean_of(self.tables)[tables].T)[:, :, None]

    def of(self, colors: FloatArray) -> FloatArray:
        """Return the rows of surfaces in these colours, shape ``(n, 16)``; valid until the next call."""
        mine, scale, offset = colors[self._glossy], self._scale, self._offset
        head_on = self._reflectance + self._metalness * (mine - self._reflectance)
        within = (1 - self._metalness) * mine
        again = returning(head_on, scale + offset)
        caught = 1 - (scale + offset)
        entering = 1 - (scale * head_on + offset + again * caught)
        columns = [
            head_on,
            within,
            within / np.maximum(entering, _LEAST),
            again,
            1 / np.maximum(caught, _LEAST),
            self._metalness,
        ]
        self._rows[self._glossy, 2:] = np.hstack(columns)
        return self._rows


@inlined
def tint_gloss(row: FloatArray, mean: FloatArray, color: npt.NDArray[np.uint8], finish: FloatArray) -> None:
    """Write the row of a surface at a point of an image on it.

    The light between its facets stays that of the mean, which is exact for surfaces that are not metal.

    Args:
        row: its row, for the mean colour.
        mean: the mean colour, 0..1.
        color: the colour at the point, 0..255.
        finish: the result.
    """
    finish[:] = row
    for channel in range(3):
        here, usual = color[channel] / 255.0, mean[channel]
        if here != usual:
            finish[2 + channel] += row[15] * (here - usual)
            for column in (5, 8):
                finish[column + channel] *= here / max(usual, _LEAST)


@inlined
def begin_gloss(
    row: FloatArray, table: FloatArray, to_eye: float, ambient: float, leaving: FloatArray, light: FloatArray
) -> None:
    """Write the light that a point of a glossy surface reflects to the eye from uniform ambient light.

    Light that the facets do not reflect enters the surface; the part that is not absorbed leaves in all
    directions.

    Args:
        row: the row of its finish.
        table: the table of its roughness.
        to_eye: cosine of the normal with the direction to the eye.
        ambient: the light.
        leaving: filled with the shares of red, green and blue diffuse light that leave to the eye, and the
            share of light from other facets.
        light: the result.
    """
    scale, offset = interpolate_table(table, 0, to_eye), interpolate_table(table, 1, to_eye)
    caught = 1 - (scale + offset)
    leaving[3] = caught * row[14]
    for channel in range(3):
        reflected = scale * row[2 + channel] + offset + row[11 + channel] * caught
        leaving[channel] = 1 - reflected
        light[channel] = ambient * (reflected + row[5 + channel] * leaving[channel])


@inlined
def add_gloss(
    row: FloatArray,
    table: FloatArray,
    normal: FloatArray,
    to_eye: float,
    view: FloatArray,
    towards: tuple[float, float, float],
    leaving: FloatArray,
    arriving: FloatArray,
    light: FloatArray,
) -> None:
    """Add the light of a lamp that a point of a glossy surface reflects to the eye.

    The diffuse share is that of Ashikhmin and Shirley (An anisotropic Phong BRDF model, 2000) with the tables
    instead of Fresnel's law, so that diffuse and reflected light add up to the arriving light.

    Args:
        row: the row of its finish.
        table: the table of its roughness.
        normal: unit vector.
        to_eye: cosine of the normal with the direction to the eye.
        view: unit vector to the eye.
        towards: unit vector to the lamp.
        leaving: as :func:`begin_gloss` fills it.
        arriving: red, green and blue of its light that falls on the surface.
        light: the sum; the light is added to it.
    """
    to_light = towards[0] * normal[0] + towards[1] * normal[1] + towards[2] * normal[2]
    if to_light <= 0:
        return
    x, y, z = view[0] + towards[0], view[1] + towards[1], view[2] + towards[2]
    length = max(sqrt(x * x + y * y + z * z), 1e-300)
    halfway = (x * normal[0] + y * normal[1] + z * normal[2]) / length
    facet = (x * view[0] + y * view[1] + z * view[2]) / length
    glint, weight = lobe(to_light, to_eye, halfway, row[1]), schlick(facet)
    scale, offset = interpolate_table(table, 0, to_light), interpolate_table(table, 1, to_light)
    caught = 1 - (scale + offset)
    for channel in range(3):
        head_on, again = row[2 + channel], row[11 + channel]
        once = glint * (head_on + (1 - head_on) * weight)
        entering = 1 - (scale * head_on + offset + again * caught)
        within = row[8 + channel] * leaving[channel] * entering
        light[channel] += arriving[channel] * (once + again * leaving[3] * caught + within)
