"""What real files hold and no engine can use, repaired with a warning that says what and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.inertia import like_shape, repaired
from nrp_core.world.scene.model import Inertial, Joint, Link
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element

MAX_FRICTION = 10.0
DEFAULT_FRICTION = 1.0
LEAST_MASS = 1e-12
"""Of a link, kg: what is less is a slip, and no engine can compute with it."""

# a ball of 1 kg and 5 cm radius: what a link is like of which nothing but the mass is known
_BALL = Inertial(1.0, inertia=(0.001, 0.001, 0.001, 0.0, 0.0, 0.0))


def usable_friction(mu: float, element: Element, notes: Notes) -> float:
    """Return a friction coefficient that a material can have; 1e5 and -1 are ways to write "never slips"."""
    if 0 <= mu <= MAX_FRICTION:
        return mu
    notes.warn(
        element,
        f"a friction coefficient of {mu:g} means 'never slips': no material has it and contact solvers "
        f"lose accuracy with it, so the value used is {DEFAULT_FRICTION:g}",
    )
    return DEFAULT_FRICTION


def usable_inertial(
    given: Inertial | None, of_shapes: Inertial | None, link: str, element: Element, notes: Notes
) -> Inertial | None:
    """Return mass properties that a body can have.

    Args:
        given: what the file says, None for nothing.
        of_shapes: what its collision shapes would weigh, None where it has no solid ones.
        link: its name.
        element: where the file says so.
        notes: takes the warning.

    Returns:
        The mass properties in the axes of the link; None where there is nothing to take them from.

    Raises:
        SceneError: the mass is negative, or next to nothing.
    """
    if given is None or given.mass == 0:
        what = "no <inertial>" if given is None else "a mass of 0 and could not move"
        if of_shapes:
            what += f": {of_shapes.mass:.3g} kg computed from its collision shapes"
        if of_shapes or given:
            notes.warn(element, f"the link '{link}' has {what}")
        return of_shapes
    if given.mass < LEAST_MASS:
        least = f"0 (and at least {LEAST_MASS:g})" if given.mass > 0 else "0"
        raise element.error(
            f"the mass of the link '{link}' is {given.mass:g} kg; it must be more than {least}"
        )
    if not any(given.inertia):
        like = "its collision shapes" if of_shapes else "a ball of 5 cm radius"
        notes.warn(element, f"the link '{link}' has an inertia of 0: the inertia of {like} is used")
        return like_shape(of_shapes or _BALL, given)
    inertial, wrong = repaired(given)
    if wrong:
        now = ", ".join(f"{value:.3g}" for value in inertial.inertia[:3])
        notes.warn(element, f"the inertia of the link '{link}' is repaired to {now} kg m^2: {wrong}")
    return inertial


def with_default_masses(
    links: Sequence[Link], joints: Iterable[Joint], element: Element, notes: Notes
) -> tuple[Link, ...]:
    """Return the links of a model, so that all that moves has a mass: SDF's default, 1 kg, where it has none.

    A link that is fixed to one with a mass needs none of its own.
    """
    rigid = {name: {name} for name in (*(link.name for link in links), WORLD)}
    for joint in joints:
        if joint.kind == "fixed":
            joined = rigid[joint.parent] | rigid[joint.child]
            rigid |= dict.fromkeys(joined, joined)
    settled = {WORLD, *(link.name for link in links if link.inertial)}
    result = []
    for link in links:
        if not rigid[link.name] & settled:
            notes.warn(element, f"the link '{link.name}' moves but has no mass: SDF's default, 1 kg, is used")
            settled.add(link.name)
            result.append(replace(link, inertial=Inertial(1.0)))
        else:
            result.append(link)
    return tuple(result)
