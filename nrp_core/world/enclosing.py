"""The shapes that a camera stands inside: they are drawn from outside only, so its images lack them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, pi
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import drawn
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.model import Geometry, Visual
from nrp_core.world.scene.tessellation import triangles_of

CLOSED: Final = 0.9
"""Share of the directions around a place inside it that a closed shape fills; some have small gaps."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A visual, the model and link that have it, and its pose in the world."""

    model: str
    link: str
    visual: Visual
    pose: Pose


@dataclass(frozen=True, slots=True)
class Enclosure:
    """A closed shape around a camera.

    Args:
        model, link: names of those that have it.
        through_m: how far the line of sight runs inside it, m.
        extent_m: its longest edge along the axes of the world, m.
    """

    model: str
    link: str
    through_m: float
    extent_m: float


def enclosures(eyes: Sequence[Pose], placed: Iterable[Placed]) -> list[list[Enclosure]]:
    """Return the visible closed shapes that each camera stands inside.

    Args:
        eyes: the cameras, which look along x, in the world.
        placed: visuals.

    Raises:
        SceneError: a mesh cannot be read.
    """
    found: list[list[Enclosure]] = [[] for _ in eyes]
    for one in placed:
        corners = (
            corners_of(*drawn(one.visual.geometry, one.pose))
            if one.visual.rgba[3] > 0
            else np.empty((0, 3, 3))
        )
        low, high = corners.min((0, 1), initial=inf), corners.max((0, 1), initial=-inf)
        for eye, around in zip(eyes, found, strict=True):
            if (low < eye.position).all() and (eye.position < high).all():
                here = corners - eye.position
                through_m = _leaves_m(here, np.array(eye.rotate((1.0, 0.0, 0.0))))
                if through_m < inf and filled_share(here) >= CLOSED:
                    around.append(Enclosure(one.model, one.link, through_m, float((high - low).max())))
    return found


def corners_of(geometry: Geometry, pose: Pose) -> FloatArray:
    """Return the triangles of a shape with this pose, shape ``(n, 3, 3)``.

    Raises:
        SceneError: a mesh cannot be read.
    """
    vertices, faces = triangles_of(geometry)
    place = matrix_of(pose)
    return np.asarray((vertices @ place[:, :3].T + place[:, 3])[faces], float)


def _leaves_m(corners: FloatArray, way: FloatArray) -> float:
    """Return the length of a ray from the origin to the first triangle; infinite if that faces the origin.

    Args:
        corners: of triangles, counter-clockwise from outside, shape ``(n, 3, 3)``.
        way: the unit vector along the ray, shape ``(3,)``.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    # the volumes between the ray and the edges have one sign where it crosses a triangle
    sides = np.stack([np.cross(one, other) @ way for one, other in ((a, b), (b, c), (c, a))])
    volume = sides.sum(0)
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths_m = np.einsum("ij,ij->i", a, np.cross(b - a, c - a)) / volume
    crossed = ((sides >= 0).all(0) | (sides <= 0).all(0)) & (lengths_m > 0) & (volume != 0)
    if not crossed.any():
        return inf
    nearest = int(np.where(crossed, lengths_m, inf).argmin())
    return float(lengths_m[nearest]) if volume[nearest] > 0 else inf


def filled_share(corners: FloatArray) -> float:
    """Return the share of the directions around the origin that triangles fill.

    It is the sum of their solid angles (Van Oosterom and Strackee 1983), negative for those that face it.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", one, other) for one, other in ((a, b), (b, c), (c, a)))
    return float(2 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (4 * pi))
