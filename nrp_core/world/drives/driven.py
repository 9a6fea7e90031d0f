"""Find the body of a model that a drive moves, and the mass that moves with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from nrp_core.errors import SceneError
from nrp_core.world.scene.acting import MountedDrive
from nrp_core.world.scene.merged_bodies import Body, body_of, tree_of
from nrp_core.world.scene.model import Inertial, Model


def driven_root(
    model: Model, drive: MountedDrive, bodies: Sequence[Body], wheels: Sequence[Body] = ()
) -> int:
    """Return the root that holds all wheels; for a drive without wheels, the base of its model.

    Links that move may be between: those that steer, rockers, and suspensions.

    Raises:
        SceneError: the wheels are not held by one freely floating body.
    """
    names = [wheel.name for wheel in wheels] or [model.links[0].name]
    chains = [list(_chain(body_of(bodies, name), bodies)) for name in names]
    held_by_wheels = {bodies[above].name for chain in chains for above in chain[1:]} & set(names)
    if len({chain[-1] for chain in chains}) != 1 or held_by_wheels:
        raise SceneError(f"the wheels of the drive '{drive.name}' of '{model.name}' are not held by one body")
    base = chains[0][-1]
    if not bodies[base].floats:
        raise SceneError(
            f"the drive '{drive.name}' cannot move '{model.name}', whose base does not float freely"
        )
    return base


def _chain(index: int, bodies: Sequence[Body]) -> Iterator[int]:
    """Yield a body and those that hold it, up to the root."""
    above: int | None = index
    while above is not None:
        yield above
        above = bodies[above].parent


def masses_in(root: int, bodies: Sequence[Body]) -> list[Inertial]:
    """Return the inertials of a root and its descendants, in its frame, which is the model's."""
    tree = tree_of(root, bodies)
    parts = [(bodies[index].in_model, bodies[index].inertial) for index in tree]
    return [replace(mass, pose=place @ mass.pose) for place, mass in parts if mass is not None]
