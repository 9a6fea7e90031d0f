"""The reflection of a rough surface, modelled by many facets, each of them a mirror.

The facets' slopes are distributed as Trowbridge and Reitz have it (GGX; Walter et al., Microfacet models for
refraction through rough surfaces, EGSR 2007), they hide each other as Smith assumed (with the correlation
of Heitz, Understanding the masking-shadowing function, JCGT 2014), and each reflects by Schlick's form of
Fresnel's law. The width of the distribution is the square of the roughness (Burley, Physically based shading
at Disney, SIGGRAPH 2012). Uniform light from all directions is reflected by two numbers for each angle and
roughness, the split of Karis (Real shading in Unreal Engine 4, SIGGRAPH 2013). Light between facets is
returned in all directions (Kulla and Conty, Revisiting physically based shading at Imageworks, SIGGRAPH
2017).

Cosines are of the angles between the normal and the directions to the light, to the eye and halfway between
them.
"""

from __future__ import annotations

from math import cos, pi, sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit

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
def looked_up(table: FloatArray, part: int, cosine: float) -> float:
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
