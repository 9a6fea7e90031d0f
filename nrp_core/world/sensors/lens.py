"""Lenses: at which distance from the centre of an image a ray at some angle arrives, and the other way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, sin, tan
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import did_you_mean
from nrp_core.world.scene.reading.xml import Element

_FUNCTIONS: Final[Mapping[str, Callable[[float], float]]] = {"sin": sin, "tan": tan, "id": float}
_INVERSES: Final[Mapping[str, Callable[[FloatArray], FloatArray]]] = {
    "sin": lambda share: np.arcsin(np.where(np.abs(share) <= 1, share, np.nan)),
    "tan": np.arctan,
    "id": np.asarray,
}
_KNOWN: Final[Mapping[str, tuple[float, float, str]]] = {
    "gnomonical": (1.0, 1.0, "tan"),
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}
"""Scale, divisor of the angle and function of the lenses that SDF names."""
_CUSTOM: Final = "custom"


@dataclass(frozen=True, slots=True)
class Lens:
    """A lens of SDF: ``r = c1 * f * fun(theta / c2 + c3)`` in half widths of the image, ``theta`` in rad.

    Args:
        cutoff: the angle (rad) to the line of sight beyond which the image is black.
    """

    c1: float = 2.0
    c2: float = 2.0
    c3: float = 0.0
    f: float = 1.0
    fun: str = "tan"
    cutoff: float = pi / 2

    @classmethod
    def read(cls, lens: Element, fov: float) -> Lens:
        """Read a ``<lens>``.

        Args:
            lens: the element, which may be empty.
            fov: the horizontal field of view, rad, to which the image is scaled if the file asks for it.

        Raises:
            SceneError: its type or function is unknown, or a number is impossible.
        """
        kind = lens.word("type", "stereographic")
        if kind not in (*_KNOWN, _CUSTOM):
            hint = did_you_mean(kind, [*_KNOWN, _CUSTOM])
            raise lens.require("type").error(f"unknown type '{kind}' of a <lens>{hint}")
        given = lens.section("custom_function")
        if kind == _CUSTOM:
            c1, c2, fun = given.positive("c1", 1.0), given.positive("c2", 1.0), given.word("fun", "tan")
            c3, f = given.number("c3", 0.0), given.positive("f", 1.0)
            if fun not in _FUNCTIONS:
                raise given.require("fun").error(f"unknown <fun> '{fun}'{did_you_mean(fun, _FUNCTIONS)}")
        else:
            (c1, c2, fun), c3, f = _KNOWN[kind], 0.0, 1.0
        if lens.flag("scale_to_hfov", True):
            edge = c1 * _FUNCTIONS[fun](fov / 2 / c2 + c3)
            if edge <= 0:
                raise lens.error(f"a <lens> of type '{kind}' cannot show a <horizontal_fov> of {fov:g}")
            f = 1 / edge
        return cls(c1, c2, c3, f, fun, lens.positive("cutoff_angle", pi / 2))

    def radius(self, theta: float) -> float:
        """Return where a ray at an angle to the line of sight arrives, in half widths."""
        return self.c1 * self.f * _FUNCTIONS[self.fun](theta / self.c2 + self.c3)

    def angles(self, radii: FloatArray) -> FloatArray:
        """Return the angles (rad) of the rays that arrive at some distances from the centre.

        It is NaN where none arrives: outside the lens, or beyond the angle at which it cuts off.
        """
        thetas = self.c2 * (_INVERSES[self.fun](radii / (self.c1 * self.f)) - self.c3)
        return np.where((thetas >= 0) & (thetas <= min(self.cutoff, pi)), thetas, np.nan)
