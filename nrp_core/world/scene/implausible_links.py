"""Implausible values of links: mass, inertia and shapes that do not belong to one body."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, sqrt
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.implausible_shapes import box_around, solid_or_seen
from nrp_core.world.scene.inertia import turned
from nrp_core.world.scene.model import UNIT_INERTIA, Inertial, Model

_DENSEST: Final = 1e5
"""Four times the density of osmium, kg/m^3: many links are too heavy for a simplified shape."""
_TIMES_LARGER: Final = 12.0
"""How much larger than its shapes a link may be by its inertia. Many are by 10; with moments in g m^2 it is
32 times too large, and twice the radius of gyration of a body is at least half of its size."""
_TIMES_SMALLER: Final = 30.0
"""How much smaller it may be."""
_SLENDER: Final = 3.0
"""How much longer than wide a link is that turns easily about its length."""
_OUTSIDE: Final = 0.25
"""How far outside its shapes the mass of a link may be centred, in sizes of the link."""
_TINY: Final = 0.01
"""The size of the smallest shape, in sizes of the largest, if it is smaller than this as well:"""
_TINY_M: Final = 1e-3
_FAR: Final = 100.0
"""How far two jointed links may be apart, in sizes of the largest link."""


def has_dense_link(model: Model) -> bool:
    """Return whether a link is denser than any body.

    Raises:
        SceneError: a mesh cannot be read.
    """
    for link in model.links:
        box = box_around((one.pose, one.geometry) for one in solid_or_seen(link))
        if box is not None and link.inertial is not None and _is_dense(link.inertial.mass, *box):
            return True
    return False


def _is_dense(mass: float, low: FloatArray, high: FloatArray) -> bool:
    volume = float((high - low).prod())
    return volume > 0 and mass / volume > _DENSEST


def of_links(model: Model) -> Iterator[str]:
    """Yield each implausible value of the links of a model that moves as a sentence.

    Raises:
        SceneError: a mesh cannot be read.
    """
    boxes: dict[str, tuple[FloatArray, FloatArray]] = {}
    for link in model.links:
        box = box_around((one.pose, one.geometry) for one in solid_or_seen(link))
        if box is None:
            continue
        boxes[link.name] = box
        if link.inertial is not None:
            yield from _of_mass(f"the link '{link.name}' of '{model.name}'", link.inertial, *box)
    yield from _of_tiny_shapes(model)
    yield from _of_distances(model, [high - low for low, high in boxes.values()])
    yield from _of_nothing_solid(model)


def _of_mass(owner: str, inertial: Inertial, low: FloatArray, high: FloatArray) -> Iterator[str]:
    mass, sides = inertial.mass, high - low
    size_m = float(np.linalg.norm(sides))
    if _is_dense(mass, low, high):
        yield (
            f"{owner} weighs {mass:.3g} kg in a box of {' x '.join(f'{one:.2g}' for one in sides)} m: "
            f"{mass / sides.prod():.2g} kg/m^3, more than osmium; is its mass meant in g?"
        )
        return
    largest = max(inertial.inertia[:3])
    if mass > 0 and largest > 0 and inertial.inertia != UNIT_INERTIA:  # SDF's default, which is reported
        gyration_m = sqrt(largest / mass)
        if not 1 / _TIMES_SMALLER <= 2 * gyration_m / size_m <= _TIMES_LARGER:
            yield (
                f"{owner} has an inertia of {largest:.3g} kg m^2, that of {mass:.3g} kg in a ball of "
                f"{3.16 * gyration_m:.2g} m, and its shapes are {size_m:.2g} m large; is it in kg m^2?"
            )
        elif _fits_about_other_axes(inertial, sides):
            yield (
                f"{owner} has its largest moment of inertia about the axis along which its shapes are "
                "longest; are the axes exchanged?"
            )
    centre = np.array(inertial.pose.position)
    outside_m = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - centre, centre - high))))
    if outside_m > _OUTSIDE * size_m:
        yield (
            f"the centre of mass of {owner} is {outside_m:.2g} m outside of its shapes, which are "
            f"{size_m:.2g} m large"
        )


def _fits_about_other_axes(inertial: Inertial, sides: FloatArray) -> bool:
    """Return whether a slender link turns harder about its length than all its mass at its sides would."""
    along, moments = int(np.argmax(sides)), turned(inertial).diagonal()
    across_m = np.delete(sides, along)
    is_slender = sides[along] > _SLENDER * across_m.max()
    largest = inertial.mass * float((across_m**2).sum())  # twice as far as any of its shapes is from the axis
    return bool(is_slender and moments[along] > max(largest, _SLENDER * moments.min()))


def _of_tiny_shapes(model: Model) -> Iterator[str]:
    shapes = [
        (link, one, box_around([(Pose(), one.geometry)])) for link in model.links for one in link.collisions
    ]
    sizes = [(link, one, float((box[1] - box[0]).max())) for link, one, box in shapes if box is not None]
    largest_m = max((size for _, _, size in sizes), default=0.0)
    for link, one, size_m in sizes:
        if size_m < min(_TINY_M, _TINY * largest_m):
            yield (
                f"the collision '{one.name}' of the link '{link.name}' of '{model.name}' is {size_m:.2g} m "
                f"large, and the largest one {largest_m:.2g} m; is it meant in mm?"
            )


def _of_distances(model: Model, boxes: list[FloatArray]) -> Iterator[str]:
    largest_m = max((float(np.linalg.norm(sides)) for sides in boxes), default=0.0)
    places = {link.name: link.pose.position for link in model.links}
    for joint in model.joints:
        if joint.parent == WORLD or joint.parent not in places or joint.child not in places:
            continue
        away_m = dist(places[joint.parent], places[joint.child])
        if 0 < _FAR * largest_m < away_m:
            yield (
                f"the joint '{joint.name}' of '{model.name}' joins links {away_m:.3g} m apart, and the "
                f"largest link is {largest_m:.2g} m; is a pose meant in mm?"
            )


def _of_nothing_solid(model: Model) -> Iterator[str]:
    """Yield that a model with weight and looks has no collision shape, unless something holds it."""
    is_held = any(WORLD in (joint.parent, joint.child) for joint in model.joints)
    has_weight = any(link.gravity and link.inertial is not None for link in model.links)
    is_shown = any(link.visuals for link in model.links)
    if not is_held and has_weight and is_shown and not any(link.collisions for link in model.links):
        yield f"'{model.name}' has no collision shape: it falls through the ground"
