"""Repair values that occur in real files and that engines cannot use, with a warning."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from nrp_core.findings import Code
from nrp_core.scene.consistency import WORLD, rigid_groups
from nrp_core.scene.inertia import like_shape, repair_inertia
from nrp_core.scene.model import Inertial, Joint, Link
from nrp_core.scene.reading.context import Element, Notes

MAX_FRICTION = 10.0
DEFAULT_FRICTION = 1.0
LEAST_MASS = 1e-12
"""Minimum mass of a link, kg: engines cannot compute with smaller ones."""

NO_INERTIA = 1e-9
"""The ratio of inertia to mass, m^2, below which an inertia is none: of a mass within 0.03 mm.

Files that programs wrote have the rest of a difference, such as 2e-35, where they mean 0.
"""
SENSOR_SHARE = 1e-3
"""The share of a model's mass of a link without mass that a force sensor separates from the others."""
MASSLESS_SHARE = 1e-4
"""The share of a model's mass of a link that weighs nothing by its file and moves, so that it needs some."""
MASSLESS = "massless"
"""The attribute of a link whose mass is, by its file, that of the links fixed to it.

Also of a model in whose file a link without a mass weighs nothing, as in URDF.
"""

# a ball of 1 kg and 5 cm radius, for a link of which only the mass is known
_BALL = Inertial(1.0, inertia=(0.001, 0.001, 0.001, 0.0, 0.0, 0.0))


def usable_friction(mu: float, element: Element, notes: Notes) -> float:
    """Return a physically possible friction coefficient; 1e5 and -1 are ways to write "never slips"."""
    if 0 <= mu <= MAX_FRICTION:
        return mu
    notes.warn(
        element,
        Code.NRP384,
        f"a friction coefficient of {mu:g} means 'never slips': no material has it and contact solvers "
        f"lose accuracy with it, so the value used is {DEFAULT_FRICTION:g}",
    )
    return DEFAULT_FRICTION


def usable_inertial(
    given: Inertial | None, of_shapes: Inertial | None, link: str, element: Element, notes: Notes
) -> Inertial | None:
    """Return physically possible mass properties.

    Args:
        given: those in the file, or None.
        of_shapes: those of its collision shapes, None if none is solid.
        link: its name.
        element: the element for warnings.
        notes: receives the warning.

    Returns:
        The mass properties in the axes of the link; None without a source for them.

    Raises:
        SceneError: the mass is negative.
    """
    if of_shapes is not None and of_shapes.mass < LEAST_MASS:  # such as a cylinder of a micrometre
        of_shapes = None
    if given is None or given.mass == 0:
        if given:
            what = f": {of_shapes.mass:.3g} kg computed from its collision shapes" if of_shapes else ""
            message = f"the link '{link}' has a mass of 0 and could not move{what}"
            notes.warn(element, Code.NRP384, message, subject=link, alike="no mass")
        return repair_inertia(of_shapes)[0] if of_shapes else None
    if given.mass < 0:
        raise element.error(f"the mass of the link '{link}' is {given.mass:g} kg; it must be more than 0")
    if given.mass < LEAST_MASS:
        message = f"the mass of the link '{link}' is {given.mass:g} kg: {LEAST_MASS:g} kg is used"
        notes.warn(element, Code.NRP384, message, subject=link)
        given = replace(given, mass=LEAST_MASS)
    if max(map(abs, given.inertia)) < NO_INERTIA * given.mass:
        like = "its collision shapes" if of_shapes else "a ball of 5 cm radius"
        notes.warn(
            element,
            Code.NRP384,
            f"the link '{link}' has no inertia or one of about 0: the inertia of {like} is used",
            subject=link,
            alike="no inertia",
        )
        return repair_inertia(like_shape(of_shapes or _BALL, given))[0]
    inertial, wrong = repair_inertia(given)
    if wrong:
        now = ", ".join(f"{value:.3g}" for value in inertial.inertia[:3])
        notes.warn(
            element,
            Code.NRP384,
            f"the inertia of the link '{link}' is repaired to {now} kg m^2: {wrong}",
            subject=link,
            alike="repaired inertia",
        )
    return inertial


def report_without_inertial(elements: Sequence[Element], links: Sequence[Link], notes: Notes) -> None:
    """Report the links that have the mass of their collision shapes, and its sum, at the first of them."""
    bare = [
        (element, link.inertial.mass)
        for element, link in zip(elements, links, strict=True)
        if link.inertial is not None and element.find("inertial") is None
    ]
    if not bare:
        return
    first, whole = bare[0][0], sum(mass for _, mass in bare)
    name, of = first.attribute("name"), f"{whole:.3g} kg computed from"
    heavy = sum(link.inertial is not None for link in links)
    if len(bare) == 1:
        message = f"the link '{name}' has no <inertial>: {of} its collision shapes"
    elif len(bare) == heavy:
        message = f"none of the {heavy} links has an <inertial>: the robot has {of} its collision shapes"
    else:
        message = f"{len(bare)} links, as '{name}', have no <inertial>: {of} their collision shapes"
    notes.warn(first, Code.NRP384, message, subject=name)


def with_default_masses(
    links: Sequence[Link], joints: Iterable[Joint], element: Element, notes: Notes
) -> tuple[Link, ...]:
    """Return the links of a model, with a mass for movable links without one.

    It is SDF's default, 1 kg, or in URDF, in which such a link weighs nothing, a small share of the model's.
    A link that is fixed to one with a mass needs none of its own.
    """
    whole = sum(link.inertial.mass for link in links if link.inertial)
    light = whole * MASSLESS_SHARE if MASSLESS in element.attributes else 0.0
    measured = {joint for link in links for sensor in link.sensors for joint in sensor.measured_joints}
    fixed = [joint for joint in joints if joint.kind == "fixed"]
    names = [*(link.name for link in links), WORLD]
    held = rigid_groups(names, [(joint.parent, joint.child) for joint in fixed])
    rigid = rigid_groups(
        names, [(joint.parent, joint.child) for joint in fixed if joint.name not in measured]
    )
    settled = {WORLD, *(link.name for link in links if link.inertial)}
    result = []
    for link in links:
        if not rigid[link.name] & settled and held[link.name] & settled:
            mass = SENSOR_SHARE * (whole or 1.0)
            message = f"the link '{link.name}' moves beside a force sensor without mass: {mass:.2g} kg"
            notes.warn(element, Code.NRP384, message, subject=link.name)
            settled.add(link.name)
            result.append(replace(link, inertial=like_shape(_BALL, Inertial(mass))))
        elif not rigid[link.name] & settled:
            used = f"{light:.2g} kg" if light else "SDF's default, 1 kg, is used"
            message = f"the link '{link.name}' moves but has no mass: {used}"
            notes.warn(element, Code.NRP384, message, subject=link.name, alike="moves without mass")
            settled.add(link.name)
            inertial = like_shape(_BALL, Inertial(light)) if light else Inertial(1.0)
            result.append(replace(link, inertial=inertial))
        else:
            result.append(link)
    return tuple(result)
