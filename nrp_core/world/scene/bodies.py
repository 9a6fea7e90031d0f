"""Links put together from what a file gives, also where its meshes cannot be had.

Real files arrive without their meshes. A visual then takes the shape of one of the link's collisions, a
simple one if there is one, or of the box that has the link's inertia; collisions take that box where there
is none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.inertia import equivalent_box
from nrp_core.world.scene.model import (
    DEFAULT_RGBA,
    Collision,
    Finish,
    Geometry,
    Inertial,
    Link,
    Mesh,
    Rgba,
    Visual,
)
from nrp_core.world.scene.sensing import MountedSensor


@dataclass(frozen=True, slots=True)
class Shape:
    """A geometry, where it is in the frame of its link, and the colour that its own file gives it."""

    geometry: Geometry
    pose: Pose
    rgba: Rgba | None = None


@dataclass(frozen=True, slots=True)
class Look:
    """What a file says of the look of a visual.

    Args:
        rgba: its colour, None where it does not say: then that of the shape's own file.
        opacity: 0 for invisible to 1.
        glows: whether the colour is the same in any light.
        finish: how it shines, None where it is matt.
    """

    rgba: Rgba | None = None
    opacity: float = 1.0
    glows: bool = False
    finish: Finish | None = None

    def of(self, shape: Shape) -> Rgba:
        """Return the colour of a shape."""
        r, g, b, alpha = self.rgba or shape.rgba or DEFAULT_RGBA
        return r, g, b, alpha * self.opacity


@dataclass(frozen=True, slots=True)
class Shown:
    """A visual as its file gives it; a mesh may have several shapes, and none where it cannot be had."""

    name: str
    shapes: Sequence[Shape]
    look: Look


@dataclass(frozen=True, slots=True)
class Touched:
    """A collision as its file gives it; a mesh may have several shapes, and none where it cannot be had."""

    name: str
    shapes: Sequence[Shape]
    friction: float

    def collisions(self) -> Iterator[Collision]:
        """Yield a collision for each shape, all of one name."""
        return (Collision(self.name, shape.geometry, shape.pose, self.friction) for shape in self.shapes)


def build_link(
    name: str,
    pose: Pose,
    inertial: Inertial | None,
    shown: Sequence[Shown],
    touched: Sequence[Touched],
    sensors: Iterable[MountedSensor],
) -> Link:
    """Return a link whose missing shapes are filled in, or left out where nothing can stand in for them."""
    substitute = _substitute(touched, inertial)
    spare = [substitute] if substitute else []
    if not any(part.shapes for part in touched):
        touched = [replace(part, shapes=spare) for part in touched[:1]]
    seen, felt = {part.name for part in shown}, {part.name for part in touched}
    visuals = [
        Visual(unique, shape.geometry, shape.pose, part.look.of(shape), part.look.glows, part.look.finish)
        for part in shown
        for unique, shape in _numbered(part.name, part.shapes or spare, seen)
    ]
    collisions = [
        Collision(unique, shape.geometry, shape.pose, part.friction)
        for part in touched
        for unique, shape in _numbered(part.name, part.shapes, felt)
    ]
    return Link(name, pose, inertial, tuple(visuals), tuple(collisions), tuple(sensors))


def free_name(name: str, taken: Collection[str]) -> str:
    """Return a name, or where it is taken, the name with the first number from 2 that makes it free."""
    others = (f"{name}_{number}" for number in count(2))
    return next(free for free in chain([name], others) if free not in taken)


def _numbered(name: str, shapes: Sequence[Shape], taken: set[str]) -> Iterator[tuple[str, Shape]]:
    """Yield the shapes of one part: the first under its name, the others numbered."""
    for number, shape in enumerate(shapes):
        unique = free_name(name, taken) if number else name
        taken.add(unique)
        yield unique, shape


def _substitute(touched: Iterable[Touched], inertial: Inertial | None) -> Shape | None:
    shapes = [shape for part in touched for shape in part.shapes]
    simple = [shape for shape in shapes if not isinstance(shape.geometry, Mesh)]
    if simple or shapes:
        return (simple or shapes)[0]
    return Shape(*equivalent_box(inertial)) if inertial else None
