"""Links of SDF: inertials, visuals, collisions and sensors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import log1p
from typing import Final

from nrp_core.findings import Code
from nrp_core.scene.bodies import ROLLING, Shape, Touched, VisualInFile, build_link, free_name
from nrp_core.scene.devices import ANY_CAMERA
from nrp_core.scene.inertia import WATER, collision_inertia
from nrp_core.scene.meshes.convert import Form
from nrp_core.scene.model import ALL_BITS, TORSION_BY_RADIUS, Inertial, Link
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.geometry import is_empty, is_point, read_geometry
from nrp_core.scene.reading.plugins import label_of
from nrp_core.scene.reading.repairs import (
    DEFAULT_FRICTION,
    MASSLESS,
    MAX_FRICTION,
    usable_friction,
    usable_inertial,
)
from nrp_core.scene.reading.sensors import Mount, bit_mask, link_sensors
from nrp_core.scene.sdf.appearance import read_appearance
from nrp_core.scene.sdf.frames import Frames

_MOST_BITS: Final = 0x7FFFFFFF
"""Of a positive number that engines hold."""


def read_friction(collision: Element, reading: Reading, *, static: bool = False) -> float:
    """Return the coefficient of friction, of ``<ode>`` or else of ``<bullet>``.

    In a contact the smaller coefficient counts, so a very large one of a ``static`` model needs no warning.
    """
    friction = collision.section("surface").section("friction")
    default = friction.section("bullet").number("friction", DEFAULT_FRICTION)
    ode = friction.section("ode")
    mu, mu2 = ode.number("mu", default), ode.number("mu2", ode.number("mu", default))
    if static and min(mu, mu2) > MAX_FRICTION:
        return MAX_FRICTION
    mu, mu2 = (usable_friction(each, friction, reading.notes) for each in (mu, mu2))
    if mu != mu2:
        message = f"friction is the same in all directions: mu = {mu:g}, not mu2 = {mu2:g}"
        reading.notes.warn(friction, Code.NRP264, message)
    return mu


def read_torsion(collision: Element) -> float:
    """Return the maximum friction torque about the normal of a contact, divided by the normal force, m.

    It is Gazebo's (ODE) for a patch of radius ``a``: ``3 pi / 16`` times the coefficient and ``a``. A patch
    that grows with the depth of the contact, by ``<surface_radius>``, is not simulated.
    """
    torsional = collision.section("surface").section("friction").section("torsional")
    if not torsional.flag("use_patch_radius", True):
        torsional.pass_over("patch_radius")
        return 0.0
    torsional.pass_over("surface_radius")
    coefficient = min(1.0, torsional.number("coefficient", 1.0))  # the other surface usually has 1
    return max(0.0, TORSION_BY_RADIUS * coefficient * torsional.number("patch_radius", 0.0))


def read_bits(collision: Element, reading: Reading) -> tuple[int, int]:
    """Return the category of a collision, and those that it touches; other limits cause a warning.

    The rule is that of sdformat: a missing ``<category_bitmask>`` is the ``<collide_bitmask>``.

    Raises:
        SceneError: the bits are not a whole number.
    """
    surface = collision.section("surface")
    bounce = surface.section("bounce")
    if bounce.number("restitution_coefficient", 0.0) > 0:
        message = "the <restitution_coefficient> of a <bounce> is not simulated: nothing bounces"
        reading.notes.warn(bounce, Code.NRP383, message, subject="bounce")
    contact = surface.section("contact")
    if contact.flag("collide_without_contact", False):
        message = "<collide_without_contact> is not simulated: whatever touches the collision is stopped"
        reading.notes.warn(contact, Code.NRP383, message, subject="collide_without_contact")
    touched = bit_mask(contact, "collide_bitmask", ALL_BITS) & _MOST_BITS
    return bit_mask(contact, "category_bitmask", touched) & _MOST_BITS, touched


_STEP_S = 0.001  # of Gazebo


def read_link(link: Element, frames: Frames, reading: Reading, *, static: bool, alone: bool) -> Link:
    """Read a ``<link>``.

    Args:
        link: the element.
        frames: the frames of its model.
        reading: the context of the reading.
        static: whether it never moves, so that its mass is not needed.
        alone: whether it is the only link of its model.
    """
    name = link.attribute("name")
    place = partial(frames.place_in, frame=name)
    given = link.find("inertial")
    weighed = given is not None and given.find("inertia") is not None and not given.is_set("auto")

    def shapes(element: Element, form: Form) -> list[Shape]:
        at, geometry = place(element), element.require("geometry")
        found = read_geometry(geometry, form, reading, static=static, alone=alone, weighed=weighed)
        return [replace(shape, pose=at @ shape.pose) for shape in found]

    shown = []
    for unique, visual in _with_unique_names(link, "visual", reading):
        flags = bit_mask(visual, "visibility_flags", ANY_CAMERA)
        look = replace(read_appearance(visual, reading), label=label_of(visual), flags=flags)
        seen = shapes(visual, "colored") if look.tints or not look.rgba else []
        if look.rgba and not any(shape.texture for shape in seen):
            seen = shapes(visual, "whole")
        shown.append(VisualInFile(unique, seen, look))
    solid = [
        (
            Touched(
                unique,
                shapes(collision, "convex"),
                read_friction(collision, reading, static=static),
                place(collision),
                read_bits(collision, reading),
                read_torsion(collision),
                float(collision.section("surface").section("friction").attributes.get(ROLLING, 0.0)),
            ),
            collision,
        )
        for unique, collision in _with_unique_names(link, "collision", reading)
    ]
    inertial = None if static else _inertial(link, frames, solid, reading)
    if static:
        for part in (link, *(collision for _, collision in solid)):
            part.pass_over("inertial", "density", "auto_inertia_params", "velocity_decay")
    sensors = link_sensors(link.all("sensor"), Mount(name, place), reading)
    pose = frames.pose(name, link)
    touched = [part for part, _ in solid if any(part.bits)]
    result = build_link(name, pose, inertial, shown, touched, sensors)
    return replace(result, gravity=link.flag("gravity", True), decay=_decay(link, reading))


def _decay(link: Element, reading: Reading) -> tuple[float, float]:
    """Return the rates of a ``<velocity_decay>``, 1/s.

    Gazebo Classic (ODE) multiplies a velocity by ``1 - decay`` in each of its steps, by default of 1 ms, so
    links with 1 hardly move. Files with 1 or more are for engines that ignore the element: DART and
    Bullet in Gazebo.
    """
    section = link.section("velocity_decay")
    shares = [section.number(tag, 0.0) for tag in ("linear", "angular")]
    if not all(0.0 <= share < 1.0 for share in shares):
        reason = "is ignored, as in Gazebo Sim: the fraction per millisecond must be at least 0 and below 1"
        message = f"<velocity_decay> {max(shares, key=abs):g} {reason}"
        reading.notes.warn(section, Code.NRP383, message, subject="velocity_decay", alike="velocity_decay")
        return 0.0, 0.0
    linear, angular = (-log1p(-share) / _STEP_S for share in shares)
    return linear, angular


def _with_unique_names(link: Element, tag: str, reading: Reading) -> Iterator[tuple[str, Element]]:
    """Yield the visuals or collisions with a shape, each with a unique name; others cause a warning."""
    seen: set[str] = set()
    for element in link.all(tag):
        name = element.attribute("name")
        unique = free_name(name, seen)
        if unique != name:
            owner = link.attribute("name")
            message = f"the link '{owner}' has two {tag}s named '{name}': this one is renamed '{unique}'"
            reading.notes.warn(element, Code.NRP266, message, subject=name)
        seen.add(unique)
        geometry = element.find("geometry")
        if geometry is None:
            message = f"the {tag} '{name}' has no <geometry>: left out"
            reading.notes.warn(element, Code.NRP260, message, subject=name)
        elif not geometry.children:
            message = f"the <geometry> of the {tag} '{name}' has no shape: left out"
            reading.notes.warn(geometry, Code.NRP260, message, subject=name)
        elif is_point(geometry):
            message = f"the {tag} '{name}' is a shape without a size: left out"
            reading.notes.warn(element, Code.NRP260, message, subject=name, alike=f"{tag} without size")
        elif not is_empty(geometry):
            yield unique, element
            continue
        element.passed_over = True


def _inertial(
    link: Element, frames: Frames, touched: list[tuple[Touched, Element]], reading: Reading
) -> Inertial | None:
    name, element = link.attribute("name"), link.find("inertial")
    density = link.section("inertial").positive("density", WATER)
    of_shapes = collision_inertia(
        (shape, collision.positive("density", density))
        for part, collision in touched
        for shape in part.collisions()
    )
    if MASSLESS in link.attributes:
        link.pass_over("inertial")
        return None
    if element is None:
        return usable_inertial(None, of_shapes, name, link, reading.notes)
    if element.is_set("auto"):
        element.pass_over("inertia", "pose")
        return _scaled(of_shapes, element) if of_shapes else None
    given = Inertial(element.number("mass", 1.0), frames.place_in(element, name), _inertia(element))
    return usable_inertial(given, of_shapes, name, element, reading.notes)


def _scaled(of_shapes: Inertial, element: Element) -> Inertial:
    """Return the mass and inertia of shapes, in proportion to the mass that an ``<inertial>`` states."""
    mass = element.positive("mass", of_shapes.mass)
    xx, yy, zz, xy, xz, yz = (mass / of_shapes.mass * each for each in of_shapes.inertia)
    return replace(of_shapes, mass=mass, inertia=(xx, yy, zz, xy, xz, yz))


def _inertia(inertial: Element) -> tuple[float, float, float, float, float, float]:
    inertia = inertial.section("inertia")
    xx, yy, zz = (inertia.number(f"i{axis}", 1.0) for axis in ("xx", "yy", "zz"))
    xy, xz, yz = (inertia.number(f"i{axis}", 0.0) for axis in ("xy", "xz", "yz"))
    return xx, yy, zz, xy, xz, yz
