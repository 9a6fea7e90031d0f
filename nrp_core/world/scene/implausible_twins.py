"""Collision shapes and visuals of a link that are the same but for one slip in their numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from nrp_core.world.scene.model import Box, Capsule, Collision, Cylinder, Geometry, Model, Sphere, Visual

_UNITS: Final = (50.0, 200.0), (500.0, 2000.0)
"""How many times larger one number is than the other if they are in different units."""


def of_twins(model: Model) -> Iterator[str]:
    """Yield the collision shapes that differ from a visual in one unit, one sign or two exchanged numbers.

    What holds for all shapes of a link that moves is reported there.
    """
    for link in model.links:
        seen, felt = (
            [(one.pose, one.geometry) for one in parts] for parts in (link.visuals, link.collisions)
        )
        for solid in link.collisions:
            if (solid.pose, solid.geometry) in seen:
                continue
            others = [one for one in link.visuals if (one.pose, one.geometry) not in felt]
            slips = [slip for other in others if (slip := _slip(solid, other, model.static))]
            if len(slips) == 1:
                yield f"the collision '{solid.name}' of the link '{link.name}' of '{model.name}' {slips[0]}"


def _slip(solid: Collision, other: Visual, static: bool) -> str:
    """Return how two shapes differ if it is by a slip, else an empty text."""
    shape, kind = solid.geometry, type(solid.geometry).__name__.lower()
    if type(shape) is not type(other.geometry) or solid.pose.orientation != other.pose.orientation:
        return ""
    if solid.pose.position == other.pose.position:
        if not static and isinstance(shape, Cylinder | Sphere):
            return ""
        how = _difference(_sizes(shape), _sizes(other.geometry))
        return how and f"is the same {kind} as the visual '{other.name}' but for its size: {how}"
    if shape != other.geometry or not _sizes(shape):
        return ""
    how = _difference(solid.pose.position, other.pose.position, signed=True)
    return how and f"is the same {kind} as the visual '{other.name}' but for its place: {how}"


def _sizes(geometry: Geometry) -> tuple[float, ...]:
    match geometry:
        case Box(size):
            return size
        case Sphere(radius):
            return (radius,)
        case Cylinder(radius, length) | Capsule(radius, length):
            return radius, length
        case _:
            return ()


def _difference(these: Sequence[float], others: Sequence[float], *, signed: bool = False) -> str:
    pairs = [(one, other) for one, other in zip(these, others, strict=True) if one != other]
    if len(pairs) == 2 and pairs[0] == pairs[1][::-1]:
        return f"{_listed(these)} and {_listed(others)} m, two of which are exchanged"
    if len(pairs) != 1:
        return ""
    ((one, other),) = pairs
    if signed and one == -other:
        return f"{_listed(these)} and {_listed(others)} m, which differ in a sign"
    times = max(abs(one), abs(other)) / (min(abs(one), abs(other)) or 1.0)
    if one * other > 0 and any(low < times < high for low, high in _UNITS):
        return f"{_listed(these)} and {_listed(others)} m; is one of them in another unit?"
    return ""


def _listed(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:g}" for number in numbers)
