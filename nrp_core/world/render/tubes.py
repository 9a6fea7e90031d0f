"""Muscles as tubes along their paths, in the colour of their activation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.model import (
    Cylinder,
    Geometry,
    Inertial,
    Link,
    Model,
    Rgba,
    Sphere,
    Visual,
)

_RELAXED, _ACTIVE = np.array((0.2, 0.35, 1.0)), np.array((1.0, 0.1, 0.1))


def activation_rgba(activation: float) -> Rgba:
    """Return the colour of a muscle: blue at an activation of 0, red at 1."""
    share = min(max(activation, 0.0), 1.0)
    red, green, blue = ((1 - share) * _RELAXED + share * _ACTIVE).tolist()
    return red, green, blue, 1.0


class Tubes:
    """Tubes along paths of straight lines: a cylinder for each line, and a ball at each point.

    Each is a model whose only frame moves it, and stretches a cylinder to its line.

    Args:
        counts: the number of points of each path.
        radii: the radius of each tube, m.
    """

    def __init__(self, counts: Sequence[int], radii: Sequence[float]) -> None:
        self._counts, self._radii = tuple(counts), tuple(radii)

    @property
    def models(self) -> list[Model]:
        """The models of all tubes; their frames are those of :meth:`frames`."""
        return [
            _piece(name, shape(self._radii[tube]))
            for tube in range(len(self._counts))
            for shape, names in ((_cylinder, self._lines(tube)), (Sphere, self._balls(tube)))
            for name in names
        ]

    def frames(self, paths: Sequence[FloatArray]) -> dict[str, FloatArray]:
        """Return the frame of each model, which maps its points to the world, shape ``(3, 4)``.

        Args:
            paths: the points of each path in the world, m, shape ``(n, 3)``.
        """
        found = {}
        for tube, points in enumerate(paths):
            for name, start, end in zip(self._lines(tube), points, points[1:], strict=False):
                found[name] = _stretched(start, end)
            for name, point in zip(self._balls(tube), points, strict=True):
                found[name] = np.column_stack([np.eye(3), point])
        return found

    def visuals(self, tube: int) -> Iterator[str]:
        """Yield the paths of the visuals of a tube."""
        for name in (*self._lines(tube), *self._balls(tube)):
            yield f"{name}/piece/piece"

    def _lines(self, tube: int) -> list[str]:
        return [f"tube {tube} line {number}" for number in range(self._counts[tube] - 1)]

    def _balls(self, tube: int) -> list[str]:
        return [f"tube {tube} ball {number}" for number in range(self._counts[tube])]


def _cylinder(radius: float) -> Cylinder:
    return Cylinder(radius, 1.0)


def _piece(name: str, shape: Geometry) -> Model:
    visual = Visual("piece", shape, rgba=activation_rgba(0.0))
    return Model(name, (Link("piece", visuals=(visual,), inertial=Inertial(1.0)),))


def _stretched(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the frame in which a line from -0.5 to 0.5 along z goes from one point to another."""
    line = end - start
    length = float(np.linalg.norm(line))
    along = line / length if length else np.array((0.0, 0.0, 1.0))
    side = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    side /= np.linalg.norm(side)
    return np.column_stack([side, np.cross(along, side), line, (start + end) / 2])
