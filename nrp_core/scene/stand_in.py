"""Replacement shapes for meshes that are missing.

The size of a moving link is estimated from its other shapes; else from its inertia, if the density of a body
with that inertia is plausible; else from its joints and its mass. It begins where the file places its
collision, and reaches no lower than the known shapes of the model if its centre is above them. Of a static
model only the place is known: the first one named like a ground becomes a plane, if the room has no other
ground; the others become boxes that do not reach their neighbours. :mod:`.clearance` cuts what overlaps other
models at the start.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist, inf, sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.findings import Code
from nrp_core.scene.clearance import part_above
from nrp_core.scene.inertia import WATER, equivalent_box
from nrp_core.scene.model import Box, Geometry, Joint, Link, Model, Plane
from nrp_core.scene.rigid import Pose, Vector, matrix_of, transform
from nrp_core.scene.tessellation import triangles_of

DENSITIES = 50.0, 20_000.0
"""Limits of a plausible mean density of a body, kg/m^3: hollow plastic and metal."""
LARGEST_BOX_M = 0.5
"""Edge of the box that replaces a static object with nothing around it."""
MASSLESS_BOX_M = 0.05
"""Edge of the box of a link without mass or length, such as a sensor."""
_SMALLEST_M = 1e-3
_NOTICEABLE_M = 0.01
_THIN, _THICK = 0.05, 0.5  # of a link, relative to its length
_GROUND_NAMES = re.compile(
    r"ground|floor|terrain|plane|world|room|arena|lab|environment|maze|hall|house|building", re.IGNORECASE
)
_GROUND_M = 2.0
"""Minimum width of a shape that counts as ground."""

Measured = tuple[Geometry, Pose]


@dataclass(frozen=True, slots=True)
class Missing(Box):
    """A placeholder for a shape of unknown size; a complete scene contains none."""

    size: Vector = (0.0, 0.0, 0.0)


def lacks_shape(link: Link) -> bool:
    """Whether a link has shapes of unknown size."""
    geometries = [*(each.geometry for each in link.visuals), *(each.geometry for each in link.collisions)]
    return any(isinstance(geometry, Missing) for geometry in geometries)


def with_sizes(links: Sequence[Link], joints: Sequence[Joint]) -> tuple[Link, ...]:
    """Return the links of a movable model with its missing shapes replaced by boxes.

    Their sizes are estimates, so no box reaches lower than known shapes that are below its centre: a robot
    that stands on its wheels does not begin with its body in the floor, and one that holds a known tool
    stands on its unknown base.
    """
    if not any(map(lacks_shape, links)):
        return tuple(links)
    lowest = _lowest_known(links)
    return tuple(
        _fill_missing(link, *_above(lowest, link, *_box_of(link, joints))) if lacks_shape(link) else link
        for link in links
    )


def with_static_shapes(models: Sequence[Model], warn: Callable[..., None]) -> tuple[Model, ...]:
    """Return models, with the missing shapes of the static ones replaced.

    Args:
        models: all models of a room.
        warn: called with a warning about each replaced shape.
    """
    lacking = [model for model in models if any(map(lacks_shape, model.links))]
    named = [one for one in lacking if _GROUND_NAMES.search(one.name)] or [
        one for one in lacking if any(map(_GROUND_NAMES.search, _part_names(one)))
    ]
    ground = next(iter(named), None) if not any(map(_is_ground, models)) else None
    if ground is not None:
        height = f"z = {ground.pose.position[2]:g} m"
        message = f"the model '{ground.name}' is taken for the ground: a plane at {height} replaces its mesh"
        warn(Code.NRP258, message, subject=ground.name)
    return tuple(
        replace(model, links=tuple(_static(model, link, models, model is ground) for link in model.links))
        if model in lacking
        else model
        for model in models
    )


# -- movable links


def _box_of(link: Link, joints: Sequence[Joint]) -> Measured:
    known = _around(link)
    if known is not None:
        return known
    if link.inertial is not None:
        box, pose = equivalent_box(link.inertial)
        if DENSITIES[0] <= link.inertial.mass / float(np.prod(box.size)) <= DENSITIES[1]:
            place = _place_of(link)
            return box, pose if place is None else Pose(place, pose.orientation)
    return _spanning(link, _ends(link, joints), _reach(link, joints))


def _place_of(link: Link) -> Vector | None:
    """Return where the file places a missing collision; None if that is the origin of the link."""
    places = (one.pose.position for one in link.collisions if isinstance(one.geometry, Missing))
    return next((place for place in places if dist(place, (0.0, 0.0, 0.0)) >= _NOTICEABLE_M), None)


def _lowest_known(links: Iterable[Link]) -> float:
    """Return the height of the lowest point of the known collisions in the frame of the model, m."""
    heights = (
        _lowest(one.geometry, link.pose @ one.pose)
        for link in links
        for one in link.collisions
        if not isinstance(one.geometry, Missing | Plane)
    )
    return min(heights, default=-inf)


def _lowest(geometry: Geometry, pose: Pose) -> float:
    return float(_placed(geometry, pose)[:, 2].min())


def _placed(geometry: Geometry, pose: Pose) -> FloatArray:
    """Return the corners of a shape at a pose, shape ``(n, 3)``, m."""
    return transform(triangles_of(geometry)[0], matrix_of(pose))


def _above(lowest: float, link: Link, geometry: Geometry, pose: Pose) -> Measured:
    """Return the part of a box above a height in the frame of the model, the whole if its centre is below."""
    placed = link.pose @ pose
    if not isinstance(geometry, Box) or placed.position[2] <= lowest or _lowest(geometry, placed) >= lowest:
        return geometry, pose
    part = part_above(lowest, geometry, placed)
    return (geometry, pose) if part is None else (part[0], link.pose.inverse() @ part[1])


def _around(link: Link) -> Measured | None:
    """Return the box around the known shapes of a link, except planes; None if it has none."""
    shapes: list[Measured] = [(each.geometry, each.pose) for each in link.collisions]
    shapes += [(each.geometry, each.pose) for each in link.visuals]
    points = [
        _placed(geometry, pose) for geometry, pose in shapes if not isinstance(geometry, Missing | Plane)
    ]
    if not points:
        return None
    corners = np.vstack(points)
    return _box(corners.min(axis=0), corners.max(axis=0), _SMALLEST_M)


def _ends(link: Link, joints: Iterable[Joint]) -> FloatArray:
    """Return the points that a link connects, in its frame: its joints, or one and the point opposite."""
    to_link = link.pose.inverse()
    points = {(to_link @ joint.pose).position for joint in joints if link.name in (joint.parent, joint.child)}
    ends = np.array(sorted(points)).reshape(-1, 3)
    if len(ends) == 1 and link.inertial is not None:
        ends = np.vstack([ends, 2 * np.array(link.inertial.pose.position) - ends[0]])
    return ends


def _reach(link: Link, joints: Iterable[Joint]) -> float:
    """Return the distance between the joint of a link and the joint of its parent, m: a limit of its size."""
    held = {joint.child: joint for joint in joints}
    own = held.get(link.name)
    above = held.get(own.parent) if own is not None else None
    if own is None or above is None:
        return LARGEST_BOX_M
    reach = dist(own.pose.position, above.pose.position)
    return reach if reach >= _NOTICEABLE_M else LARGEST_BOX_M


def _spanning(link: Link, ends: FloatArray, reach: float) -> Measured:
    """Return a box that spans points; its thickness gives the mass of the link at the density of water."""
    inertial = link.inertial
    volume = inertial.mass / WATER if inertial is not None else None
    length = float(np.ptp(ends, axis=0).max()) if len(ends) else 0.0
    if length < _NOTICEABLE_M:
        edge = min(volume ** (1 / 3) if volume is not None else MASSLESS_BOX_M, reach)
        centre = inertial.pose.position if inertial is not None else (0.0, 0.0, 0.0)
        return Box((edge, edge, edge)), Pose(centre)
    thickness = sqrt(volume / length) if volume is not None else 0.0
    thickness = min(max(thickness, _THIN * length), _THICK * length)
    return _box(ends.min(axis=0), ends.max(axis=0), thickness)


def _box(low: FloatArray, high: FloatArray, thickness: float) -> Measured:
    (x, y, z), (cx, cy, cz) = np.maximum(high - low, thickness).tolist(), ((low + high) / 2).tolist()
    return Box((x, y, z)), Pose((cx, cy, cz))


def _fill_missing(link: Link, geometry: Geometry, pose: Pose) -> Link:
    """Return a link with each missing shape replaced by a given one; the size of a box is an estimate."""
    is_estimate = isinstance(geometry, Box)
    visuals = (
        replace(each, geometry=geometry, pose=pose) if isinstance(each.geometry, Missing) else each
        for each in link.visuals
    )
    collisions = (
        replace(each, geometry=geometry, pose=pose, estimated=is_estimate)
        if isinstance(each.geometry, Missing)
        else each
        for each in link.collisions
    )
    return replace(link, visuals=tuple(visuals), collisions=tuple(collisions))


# -- static models


def _part_names(model: Model) -> Iterator[str]:
    """Yield the names of the links of a static model and of their shapes."""
    for link in model.links if model.static else ():
        yield link.name
        yield from (visual.name for visual in link.visuals)
        yield from (collision.name for collision in link.collisions)


def _is_ground(model: Model) -> bool:
    """Whether a model is ground: static, and wide enough to carry objects."""
    return model.static and any(_is_wide(each.geometry) for link in model.links for each in link.collisions)


def _is_wide(geometry: Geometry) -> bool:
    if isinstance(geometry, Missing):
        return False
    if isinstance(geometry, Plane):
        return True
    extent = np.ptp(triangles_of(geometry)[0], axis=0)
    return bool((extent[:2] >= _GROUND_M).all())


def _static(model: Model, link: Link, models: Sequence[Model], is_ground: bool) -> Link:
    if not lacks_shape(link):
        return link
    known = _around(link)
    if known is not None:
        return _fill_missing(link, *known)
    place = model.pose @ link.pose
    upright = place.inverse() @ Pose(place.position)
    if is_ground:
        return _fill_missing(link, Plane(), upright)
    edge = min([LARGEST_BOX_M, *(space / 2 for space in _spaces(model, models) if space >= _NOTICEABLE_M)])
    lift = edge / 2 if abs(place.position[2]) < edge / 2 else 0.0  # the box stands on the ground
    return _fill_missing(link, Box((edge, edge, edge)), upright @ Pose((0.0, 0.0, lift)))


def _spaces(model: Model, models: Iterable[Model]) -> Iterator[float]:
    """Yield the horizontal distances of a model from others, and from the origin, where robots start, m."""
    x, y, _ = model.pose.position
    yield dist((x, y), (0.0, 0.0))
    for other in models:
        if other is not model and not _is_ground(other):
            yield dist((x, y), other.pose.position[:2])
