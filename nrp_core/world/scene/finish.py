"""How surfaces shine."""

from __future__ import annotations

from dataclasses import dataclass

PLASTIC = (0.04, 0.04, 0.04)
"""Reflectance of glass, plastics and paint at normal incidence."""


@dataclass(frozen=True, slots=True)
class Finish:
    """How a surface shines in realistic images; a surface without a finish is matt.

    Args:
        roughness: 0 (smooth as a mirror) to 1; its square is the width of the distribution of the slopes of
            the facets that the surface consists of.
        metalness: from 0 for a dielectric, whose colour is diffuse, to 1 for a metal, whose colour is that of
            its reflection.
        reflectance: the share of red, green and blue that a dielectric reflects at normal incidence.
    """

    roughness: float = 0.5
    metalness: float = 0.0
    reflectance: tuple[float, float, float] = PLASTIC
