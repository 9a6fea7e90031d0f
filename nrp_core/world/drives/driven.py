"""Find the body of a model that a drive moves, and the mass that moves with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nrp_core.errors import SceneError
from nrp_core.world.drives.ackermann import Ackermann
from nrp_core.world.scene.acting import MountedDrive
from nrp_core.world.scene.merged_bodies import Body, body_of, tree_of
from nrp_core.world.scene.model import Inertial, Model


def driven_root(
    model: Model, drive: MountedDrive, bodies: Sequence[Body], wheels: Sequence[Body] = ()
) -> int:
    """Return the root that holds all wheels; for a drive without wheels, the base of its model.

    Raises:
        SceneError: the wheels are not held by one freely floating body.
    """
    base: int | None
    if wheels:
        # the front wheels of a car are held by its steering links
        steers = isinstance(drive, Ackermann)
        roots = {_root(bodies.index(wheel), bodies) if steers else wheel.parent for wheel in wheels}
        if len(roots) != 1:
            raise SceneError(
                f"the wheels of the drive '{drive.name}' of '{model.name}' are not held by one body"
            )
        (base,) = roots
    else:
        base = _root(body_of(bodies, model.links[0].name), bodies)
    if base is None or not bodies[base].floats:
        raise SceneError(
            f"the drive '{drive.name}' cannot move '{model.name}', whose base does not float freely"
        )
    return base


def _root(index: int, bodies: Sequence[Body]) -> int:
    parent = bodies[index].parent
    return index if parent is None else _root(parent, bodies)


def masses_in(root: int, bodies: Sequence[Body]) -> list[Inertial]:
    """Return the inertials of a root and its descendants, in its frame, which is the model's."""
    tree = tree_of(root, bodies)
    parts = [(bodies[index].in_model, bodies[index].inertial) for index in tree]
    return [replace(mass, pose=place @ mass.pose) for place, mass in parts if mass is not None]
