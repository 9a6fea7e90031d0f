"""The ``<surface>`` of a collision: its friction, and whether anything touches it."""

from __future__ import annotations

from typing import Final

from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.repairs import DEFAULT_FRICTION, usable_friction
from nrp_core.world.scene.reading.xml import Element

_ALL: Final = 0xFFFF
"""The bits of a collision that touches everything."""
_MASKS: Final = ("collide_bitmask", "category_bitmask")


def read_friction(collision: Element, reading: Reading) -> float:
    """Return the coefficient of friction, of ``<ode>`` or else of ``<bullet>``."""
    friction = collision.section("surface").section("friction")
    default = friction.section("bullet").number("friction", DEFAULT_FRICTION)
    ode = friction.section("ode")
    mu = usable_friction(ode.number("mu", default), friction, reading.notes)
    mu2 = usable_friction(ode.number("mu2", mu), friction, reading.notes)
    if mu != mu2:
        message = f"friction is the same in all directions: mu = {mu:g}, not mu2 = {mu2:g}"
        reading.notes.warn(friction, Code.NRP263, message)
    return mu


def touches(collision: Element, reading: Reading) -> bool:
    """Return whether anything touches a collision; other limits of its contacts cause a warning.

    Raises:
        SceneError: the bits are not a whole number.
    """
    surface = collision.section("surface")
    bounce = surface.section("bounce")
    if bounce.number("restitution_coefficient", 0.0) > 0:
        message = "the <restitution_coefficient> of a <bounce> is not simulated: nothing bounces"
        reading.notes.warn(bounce, Code.NRP263, message, subject="bounce")
    contact = surface.section("contact")
    if contact.flag("collide_without_contact", False):
        message = "<collide_without_contact> is not simulated: whatever touches the collision is stopped"
        reading.notes.warn(contact, Code.NRP263, message, subject="collide_without_contact")
    masks = {tag: _bits(contact, tag) for tag in _MASKS}
    if masks["collide_bitmask"] == 0:
        return False
    for tag, bits in masks.items():
        if bits & _ALL != _ALL:
            message = f"the <{tag}> {contact.word(tag)} is not simulated: everything touches the collision"
            reading.notes.warn(contact, Code.NRP263, message, subject=tag)
    return True


def _bits(contact: Element, tag: str) -> int:
    element = contact.find(tag)
    if element is None or not element.text:
        return _ALL
    try:
        return int(element.text, 0)
    except ValueError:
        message = f"<{tag}> must be a whole number, such as 1 or 0x01, not '{element.text}'"
        raise element.error(message) from None
