"""How surfaces shine."""

from __future__ import annotations

from dataclasses import dataclass

PLASTIC = (0.04, 0.04, 0.04)
"""What glass, plastics and paint reflect head-on."""


@dataclass(frozen=True, slots=True)
class Finish:
    """How a surface shines, as realistic pictures show it; what has no finish is matt.

    Args:
        roughness: 0 (smooth as a mirror) to 1; its square is the width of the distribution of the slopes of
            the facets that the surface consists of.
        metalness: 0 for what has its colour from within to 1 for a metal, whose colour is that of its gloss.
        reflectance: the share of red, green and blue that what is no metal reflects head-on.
    """

    roughness: float = 0.5
    metalness: float = 0.0
    reflectance: tuple[float, float, float] = PLASTIC
