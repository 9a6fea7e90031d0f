"""Links put together from what a file gives, also where its meshes cannot be had.

Real files arrive without their meshes. A visual then takes the shape of the link's first simple collision,
or of the box that has the link's inertia; a collision takes that box where the link has no simple one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from nrp_core.world.scene.inertia import equivalent_box
from nrp_core.world.scene.model import Collision, Geometry, Inertial, Link, Mesh, Rgba, Sensor, Visual
from nrp_core.world.scene.pose import Pose

Shape = tuple[Geometry, Pose]
"""A geometry and where it is in the frame of its link."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A visual as its file gives it; ``shape`` is None where it cannot be had."""

    name: str
    shape: Shape | None
    rgba: Rgba


@dataclass(frozen=True, slots=True)
class Touched:
    """A collision as its file gives it; ``shape`` is None where it cannot be had."""

    name: str
    shape: Shape | None
    friction: float

    @property
    def collision(self) -> Collision | None:
        """The collision, if its shape can be had."""
        return Collision(self.name, *self.shape, friction=self.friction) if self.shape else None


def build_link(
    name: str,
    pose: Pose,
    inertial: Inertial | None,
    shown: Iterable[Shown],
    touched: Sequence[Touched],
    sensors: Iterable[Sensor],
) -> Link:
    """Return a link whose missing shapes are filled in, or left out where nothing can stand in for them."""
    collisions = [part.collision for part in touched if part.collision]
    substitute = _substitute(collisions, inertial)
    if touched and not collisions and substitute:
        collisions = [Collision(touched[0].name, *substitute, friction=touched[0].friction)]
    shapes = [(part, part.shape or substitute) for part in shown]
    visuals = [Visual(part.name, *shape, rgba=part.rgba) for part, shape in shapes if shape]
    return Link(name, pose, inertial, tuple(visuals), tuple(collisions), tuple(sensors))


def _substitute(collisions: Iterable[Collision], inertial: Inertial | None) -> Shape | None:
    for collision in collisions:
        if not isinstance(collision.geometry, Mesh):
            return collision.geometry, collision.pose
    return equivalent_box(inertial) if inertial else None
