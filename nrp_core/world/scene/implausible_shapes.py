"""Shapes that do not belong to the rest of their robot: elsewhere, or many times as large."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Link,
    Model,
    Plane,
    Sphere,
    Visual,
)
from nrp_core.world.scene.tessellation import triangles_of

_FAR: Final = 30.0
"""How far away a shape is, in sizes of the other shapes, if its place is in millimetres."""
_FEWEST: Final = 4
"""Shapes of a model, without which none of them is the exception."""
_TIMES: Final = 100.0
"""How many times a robot's visuals are larger than its collision shapes if they are in millimetres."""
_UNITS: Final = (5.0, 20.0), (50.0, 200.0), (500.0, 2000.0)
"""How many times larger than the visuals of a link its collision shapes are, in every direction, if they are
in another unit and roughly of the same form."""
_THIN_M: Final = 1e-3

Shape = Collision | Visual


def without_strays(model: Model) -> tuple[list[str], Model]:
    """Return a sentence for each shape that is not where or as large as the others, and the rest of a model.

    Raises:
        SceneError: a mesh cannot be read.
    """
    places = _places(model)
    strays = _strays(places)
    said = [
        f"the {_kind(shape)} '{shape.name}' of the link '{link.name}' of '{model.name}' is {away_m:.3g} m "
        f"away from the others, which are within {spread_m:.2g} m; is its place meant in mm?"
        for (link, shape, _, _), away_m, spread_m in strays
    ]
    rest = _without(model, [id(shape) for (_, shape, _, _), *_ in strays])
    touched, shown = (_sides(rest, kind) for kind in (Collision, Visual))
    if touched is not None and shown is not None and shown.max() > _TIMES * touched.max() > 0:
        said.append(
            f"the visuals of '{model.name}' are {shown.max():.3g} m large and its collision shapes "
            f"{touched.max():.3g} m; are they meant in mm?"
        )
        rest = replace(rest, links=tuple(replace(link, visuals=()) for link in rest.links))
    found = {link.name: list(_of_pairs(link, model.name)) for link in rest.links}
    links = tuple(_as_seen(link) if found[link.name] else link for link in rest.links)
    return [*said, *(sentence for one in found.values() for sentence in one)], replace(rest, links=links)


def _as_seen(link: Link) -> Link:
    """Return a link that is as solid as it looks."""
    shapes = (Collision(one.name, one.geometry, one.pose) for one in link.visuals)
    return replace(link, collisions=tuple(shapes))


def box_around(shapes: Iterable[tuple[Pose, Geometry]]) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners of the box around bounded shapes at their poses, m; None without any."""
    boxes = [_box(pose, geometry) for pose, geometry in shapes if not isinstance(geometry, Plane)]
    if not boxes:
        return None
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


@lru_cache(maxsize=2048)
def _box(pose: Pose, geometry: Geometry) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around a shape; the files of meshes are named after their contents."""
    place = matrix_of(pose)
    points = _corners(geometry) @ place[:, :3].T + place[:, 3]
    return points.min(0), points.max(0)


def _corners(geometry: Geometry) -> FloatArray:
    if isinstance(geometry, Box):
        half = np.array(geometry.size) / 2
        return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    return np.asarray(triangles_of(geometry)[0])


def solid_or_seen(link: Link) -> tuple[Shape, ...]:
    """Return all shapes of a link."""
    return (*link.collisions, *link.visuals)


def _kind(shape: Shape) -> str:
    return "collision" if isinstance(shape, Collision) else "visual"


_Place = tuple[Link, Shape, FloatArray, float]


def _places(model: Model) -> list[_Place]:
    """Return each bounded shape with its link, its centre in the model and its size, m."""
    found = []
    for link in model.links:
        for shape in solid_or_seen(link):
            if not isinstance(shape.geometry, Plane):
                low, high = _box(link.pose @ shape.pose, shape.geometry)
                found.append((link, shape, (low + high) / 2, float(np.linalg.norm(high - low))))
    return found


def _strays(places: list[_Place]) -> list[tuple[_Place, float, float]]:
    """Return the shapes far from all others, with how far that is, and how far apart the others are, m."""
    if len(places) < _FEWEST:
        return []
    centres, sizes = np.array([one[2] for one in places]), np.array([one[3] for one in places])
    away_m = np.linalg.norm(centres - np.median(centres, axis=0), axis=1)
    near = away_m <= _FAR * (np.median(away_m) + np.median(sizes))
    # a shape that is large itself is not elsewhere, and those of half a robot are no exception
    if near.all() or near.sum() <= len(places) / 2 or sizes[~near].max() > away_m[~near].min():
        return []
    spread_m = float((away_m + sizes)[near].max())
    far = np.flatnonzero(~near & (away_m > _FAR * spread_m))
    return [(places[one], float(away_m[one]), spread_m) for one in far]


def _without(model: Model, shapes: list[int]) -> Model:
    if not shapes:
        return model
    links = [
        replace(
            link,
            collisions=tuple(one for one in link.collisions if id(one) not in shapes),
            visuals=tuple(one for one in link.visuals if id(one) not in shapes),
        )
        for link in model.links
    ]
    return replace(model, links=tuple(links))


def _sides(model: Model, kind: type[Collision] | type[Visual]) -> FloatArray | None:
    """Return the sides of the box around the shapes of a kind, m; None without any."""
    shapes = [(link, one) for link in model.links for one in solid_or_seen(link) if isinstance(one, kind)]
    box = box_around((link.pose @ one.pose, one.geometry) for link, one in shapes)
    return None if box is None else box[1] - box[0]


def _of_pairs(link: Link, model: str) -> Iterator[str]:
    """Yield that the collision shapes of a link are not the simplified shape of its visuals."""
    owner = f"of the link '{link.name}' of '{model}'"
    solid, seen = (box_around((one.pose, one.geometry) for one in shapes)
                   for shapes in (link.collisions, link.visuals))  # fmt: skip
    if solid is None or seen is None:
        return
    touched, shown = solid[1] - solid[0], seen[1] - seen[0]
    times = touched / shown if shown.min() > _THIN_M else np.ones(3)
    if any(low < times.min() and times.max() < high for low, high in _UNITS):
        yield (
            f"the collision shapes {owner} are {_sizes(touched)} m, and its visuals {_sizes(shown)} m; "
            "is one of them in another unit?"
        )
    drawn = [one.geometry for one in link.visuals if isinstance(one.geometry, Cylinder)]
    for one in link.collisions:
        shape = one.geometry
        if isinstance(shape, Cylinder) and shape not in drawn and shape.radius != shape.length:
            exchanged = Cylinder(radius=shape.length, length=shape.radius)
            if exchanged in drawn:
                yield (
                    f"the collision '{one.name}' {owner} has a radius of {shape.radius:g} m and a length of "
                    f"{shape.length:g} m, and its visual the same numbers exchanged"
                )


def of_radii(model: Model) -> Iterator[str]:
    """Yield the round collision shapes of a thing that stands still and is twice or half as wide as it looks.

    Robots have larger ones on purpose, for feet.
    """
    for link in model.links if model.static else ():
        drawn = [(one.pose, one.geometry) for one in link.visuals]
        for one in link.collisions:
            shape = one.geometry
            if not isinstance(shape, Cylinder | Sphere | Capsule) or (one.pose, shape) in drawn:
                continue
            for radius in (shape.radius / 2, shape.radius * 2):
                if (one.pose, replace(shape, radius=radius)) in drawn:
                    owner = f"the collision '{one.name}' of the link '{link.name}' of '{model.name}'"
                    yield (
                        f"{owner} has a radius of {shape.radius:g} m, and its visual one of {radius:g} m; "
                        "is one of them a diameter?"
                    )


def _sizes(sides: FloatArray) -> str:
    return " x ".join(f"{one:.2g}" for one in sides)
