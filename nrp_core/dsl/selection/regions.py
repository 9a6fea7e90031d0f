"""Regions of space, for selectors by location; all lengths in um, as PyNN's positions.

A point of two numbers ignores the third coordinate: ``Box((0, 0), (100, 50))`` is as high as
the brain.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NeuronSelectionError


class Region(ABC):
    """A part of space."""

    @abstractmethod
    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which positions lie in it, its border included; shape ``(n, 3)`` gives ``(n,)``."""


class Box(Region):
    """A box along the axes.

    Args:
        low, high: two opposite corners, um; infinite on an open side.

    Raises:
        NeuronSelectionError: these are not points, or the first is not below the second.
    """

    def __init__(self, low: Sequence[float], high: Sequence[float]) -> None:
        self.low, self.high = point(low, "a corner of a box"), point(high, "a corner of a box")
        if len(self.low) != len(self.high):
            raise NeuronSelectionError(
                f"{self!r}: its corners must be alike, not of {len(self.low)} and {len(self.high)} numbers"
            )
        if (self.low > self.high).any():
            raise NeuronSelectionError(f"{self!r} is empty: its first corner must have the smaller numbers")

    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        some = positions_um[:, : len(self.low)]
        return np.asarray(((some >= self.low) & (some <= self.high)).all(axis=1))

    def __repr__(self) -> str:
        return f"Box({_text(self.low)}, {_text(self.high)})"


class Sphere(Region):
    """A ball, or a cylinder if the center has two numbers.

    Args:
        center: a point, um.
        radius: um.

    Raises:
        NeuronSelectionError: the point or the radius is invalid.
    """

    def __init__(self, center: Sequence[float], radius: float) -> None:
        self.center, self.radius = point(center, "the center of a sphere", finite=True), radius
        if not (isinstance(radius, (int, float, np.number)) and radius >= 0):
            raise NeuronSelectionError(f"the radius of a sphere is 0 um or more, not {radius!r}")

    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        return np.asarray(distances_um(positions_um, self.center) <= self.radius)

    def __repr__(self) -> str:
        return f"Sphere({_text(self.center)}, {self.radius:g})"


def point(value: Any, what: str, *, finite: bool = False) -> FloatArray:
    """Return a point of two or three numbers.

    Args:
        value: the numbers, um.
        what: name of the point, for the message.
        finite: whether to refuse infinity; NaN is always refused.

    Raises:
        NeuronSelectionError: the value is not a point.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    unusable = np.isnan(array).any() or (finite and np.isinf(array).any())
    if array.ndim != 1 or len(array) not in (2, 3) or unusable:
        raise NeuronSelectionError(f"{what} is two or three numbers in um, e.g. (0, 50, 100), not {value!r}")
    return array


def distances_um(positions_um: FloatArray, center: FloatArray) -> FloatArray:
    """Return the distances of positions, shape ``(n, 3)``, from a point, in the coordinates of the point."""
    distances: FloatArray = np.linalg.norm(positions_um[:, : len(center)] - center, axis=1)
    return distances


def _text(values: FloatArray) -> str:
    return f"({', '.join(f'{value:g}' for value in values)})"
