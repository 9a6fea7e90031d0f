"""Build links from the data of a file, also if its meshes are missing.

Many files come without their meshes. A visual then takes the shape of one of the link's collisions,
preferably a simple one. If the link has no known shape, :mod:`.stand_in` replaces it when the
whole model is read.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count

from nrp_core.scene.devices import ANY_CAMERA, MountedSensor
from nrp_core.scene.model import (
    ALL_BITS,
    DEFAULT_RGBA,
    Collision,
    Finish,
    Geometry,
    Inertial,
    Link,
    Mesh,
    Rgba,
    Texture,
    Visual,
)
from nrp_core.scene.rigid import Pose
from nrp_core.scene.stand_in import Missing


@dataclass(frozen=True, slots=True)
class Shape:
    """A geometry, its pose in the frame of its link, and its colour and texture in the mesh file."""

    geometry: Geometry
    pose: Pose
    rgba: Rgba | None = None
    texture: Texture | None = None


PRESERVED = "preserved"
"""Attribute of a fixed joint that keeps its links two bodies."""
ROLLING = "rolling"
"""The attribute of a friction in a converted file: the maximum rolling torque per normal force, m."""
TINTS = "tints"
"""The attribute of a material whose colour tints an image in the mesh file instead of replacing it."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """The look of a visual in a file.

    Args:
        rgba: its colour; None: the colour in the mesh file.
        opacity: 0 for invisible to 1.
        glows: whether the colour is the same in any light.
        finish: its finish, None if it is matt.
        texture: the image that has the colour, if one has it.
        label: its class for segmentation cameras, 0 for none.
        flags: bits for the masks of cameras.
        tints: whether the colour tints an image in the mesh file instead of replacing it.
    """

    rgba: Rgba | None = None
    opacity: float = 1.0
    glows: bool = False
    finish: Finish | None = None
    texture: Texture | None = None
    label: int = 0
    flags: int = ANY_CAMERA
    tints: bool = False

    def of(self, name: str, shape: Shape) -> Visual:
        """Return the visual with a name and a shape."""
        r, g, b, alpha = self.rgba or shape.rgba or DEFAULT_RGBA
        texture = self.texture if self.rgba else shape.texture
        if self.rgba and self.tints and shape.rgba and shape.texture and not texture:
            texture = replace(shape.texture, tint=(r, g, b))
            red, green, blue, _ = shape.rgba
            r, g, b = r * red, g * green, b * blue
        rgba = r, g, b, alpha * self.opacity
        look = self.glows, self.finish, texture, self.label, self.flags
        return Visual(name, shape.geometry, shape.pose, rgba, *look)


@dataclass(frozen=True, slots=True)
class VisualInFile:
    """A visual in a file; a mesh may have several shapes, and none if it is missing."""

    name: str
    shapes: Sequence[Shape]
    look: Appearance


@dataclass(frozen=True, slots=True)
class Touched:
    """A collision at a place in its link; a mesh may have several shapes, and none if it is missing."""

    name: str
    shapes: Sequence[Shape]
    friction: float
    place: Pose = Pose()
    bits: tuple[int, int] = (ALL_BITS, ALL_BITS)
    torsion: float = 0.0
    rolling: float = 0.0

    def collisions(self) -> Iterator[Collision]:
        """Yield a collision for each shape, all with the same name."""
        return (self.collision(self.name, shape) for shape in self.shapes)

    def collision(self, name: str, shape: Shape) -> Collision:
        """Return one of its shapes with a name."""
        category, touched = self.bits
        made = Collision(name, shape.geometry, shape.pose, self.friction, torsion=self.torsion)
        return replace(made, category=category, touched=touched, rolling=self.rolling)


def build_link(
    name: str,
    pose: Pose,
    inertial: Inertial | None,
    shown: Sequence[VisualInFile],
    touched: Sequence[Touched],
    sensors: Iterable[MountedSensor],
) -> Link:
    """Return a link with missing shapes replaced by its others, or marked as missing if it has none."""
    spare = [_substitute(touched)]
    if not any(part.shapes for part in touched):
        touched = [replace(part, shapes=[Shape(Missing(), part.place)]) for part in touched[:1]]
    seen, felt = {part.name for part in shown}, {part.name for part in touched}
    visuals = [
        part.look.of(unique, shape)
        for part in shown
        for unique, shape in _number_shapes(part.name, part.shapes or spare, seen)
    ]
    collisions = [
        part.collision(unique, shape)
        for part in touched
        for unique, shape in _number_shapes(part.name, part.shapes, felt)
    ]
    return Link(name, pose, inertial, tuple(visuals), tuple(collisions), tuple(sensors))


def free_name(name: str, taken: Collection[str]) -> str:
    """Return a name; if it is taken, with the first free number from 2 appended."""
    others = (f"{name}_{number}" for number in count(2))
    return next(free for free in chain([name], others) if free not in taken)


def _number_shapes(name: str, shapes: Sequence[Shape], taken: set[str]) -> Iterator[tuple[str, Shape]]:
    """Yield the shapes of one part: the first with its name, the others numbered."""
    for number, shape in enumerate(shapes):
        unique = free_name(name, taken) if number else name
        taken.add(unique)
        yield unique, shape


def _substitute(touched: Iterable[Touched]) -> Shape:
    shapes = [shape for part in touched for shape in part.shapes]
    simple = [shape for shape in shapes if not isinstance(shape.geometry, Mesh)]
    return [*simple, *shapes, Shape(Missing(), Pose())][0]
