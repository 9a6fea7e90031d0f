"""How a rough surface reflects: a face of many facets, each of them a mirror.

The facets' slopes are distributed as Trowbridge and Reitz have it (GGX; Walter et al., Microfacet models for
refraction through rough surfaces, EGSR 2007), they hide each other as Smith assumed (with the correlation
of Heitz, Understanding the masking-shadowing function, JCGT 2014), and each reflects by Schlick's form of
Fresnel's law. The width of the distribution is the square of the roughness (Burley, Physically based shading
at Disney, SIGGRAPH 2012). What all directions send back to the eye is two numbers for each slope and
roughness, the split of Karis (Real shading in Unreal Engine 4, SIGGRAPH 2013). What the facets send to each
other first comes back to all sides (Kulla and Conty, Revisiting physically based shading at Imageworks,
SIGGRAPH 2017).

Cosines are those of the normal with the directions to the light, to the eye and halfway between them.
"""

from __future__ import annotations

from math import cos, pi, sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit

SMOOTHEST = 0.07
"""What is less rough counts as this: it shows the sun half a degree wide, as it is."""
STEPS = 64
"""Into how many parts a table divides the cosines from 0 to 1."""
_HEIGHTS, _TURNS = 256, 64  # facets that are looked at for an entry of a table


def width_of(roughness: float) -> float:
    """Return the width of the distribution of slopes."""
    return max(roughness, SMOOTHEST) ** 2


@inlined
def schlick(cosine: float) -> float:
    """Return Schlick's weight: of the way from what is reflected head-on to all, by the facet's cosine."""
    rest = 1.0 - cosine
    weight: float = rest * rest * rest * rest * rest
    return weight


@inlined
def hiding(to_light: float, to_eye: float, width: float) -> float:
    """Return the share of facets that both see, by four times the product of the cosines."""
    square = width * width
    light = to_eye * sqrt(to_light * to_light * (1 - square) + square)
    eye = to_light * sqrt(to_eye * to_eye * (1 - square) + square)
    return 0.5 / (light + eye)


@inlined
def lobe(to_light: float, to_eye: float, halfway: float, width: float) -> float:
    """Return pi times what facets that reflect all light send to the eye, by what falls on the surface."""
    square = width * width
    spread = halfway * halfway * (square - 1) + 1
    return square / (spread * spread) * hiding(to_light, to_eye, width)


@jit
def tabulate(width: float, table: FloatArray) -> None:
    """Find what a surface reflects of equal light from everywhere.

    Args:
        width: of the distribution of slopes.
        table: the result, shape ``(STEPS + 1, 2)``, for cosines to the eye from 0 to 1: a surface that
            reflects ``f`` head-on reflects ``f * table[:, 0] + table[:, 1]``.
    """
    for entry in range(STEPS + 1):
        to_eye = max(entry / STEPS, 1e-3)
        across = sqrt(1 - to_eye * to_eye)
        table[entry, :] = 0.0
        for height in range(_HEIGHTS):
            share = (height + 0.5) / _HEIGHTS  # equal shares of the facets that a beam from above meets
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
def looked_up(table: FloatArray, part: int, cosine: float) -> float:
    """Return an entry of a table, between those beside it."""
    at = cosine * STEPS
    below = min(int(at), STEPS - 1)
    value: float = table[below, part] + (at - below) * (table[below + 1, part] - table[below, part])
    return value


def returning(head_on: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the share that comes back of what the facets send to each other.

    Args:
        head_on: what a facet reflects head-on, 0..1.
        mean: of what facets that reflect all light send back at once.
    """
    facet = head_on + (1 - head_on) / 21  # Schlick's form over all directions
    share: FloatArray = facet * facet * mean / (1 - facet * (1 - mean))
    return share


def mean_of(tables: FloatArray) -> FloatArray:
    """Return the means of tables over all directions, each by its cosine; shape ``(k, 2)``."""
    cosines = np.linspace(0.0, 1.0, STEPS + 1)
    return np.asarray(np.trapezoid(2 * cosines[:, None] * tables, cosines, axis=1))
