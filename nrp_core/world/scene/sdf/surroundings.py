"""The surroundings of an SDF world: ``<magnetic_field>``, ``<atmosphere>``, ``<spherical_coordinates>``."""

from __future__ import annotations

from math import hypot
from typing import Final

from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.surroundings import Surroundings

_STRONGEST_T: Final = 1e-3
"""More than ten times the field at the magnetic poles of the Earth (World Magnetic Model)."""
_ORIENTATION, _SURFACE = "ENU", "EARTH_WGS84"


def read_surroundings(world: Element, notes: Notes) -> Surroundings:
    """Read the surroundings of a ``<world>``; other planets and axes cause a warning."""
    usual = Surroundings()
    field, air, earth = (
        world.section(tag) for tag in ("magnetic_field", "atmosphere", "spherical_coordinates")
    )
    x, y, z = field.numbers(3) if field.text else usual.magnetic_field
    for tag, supported in (("world_frame_orientation", _ORIENTATION), ("surface_model", _SURFACE)):
        if earth.word(tag, supported) != supported:
            message = f"the <{tag}> {earth.word(tag)} is not simulated: {supported} is used"
            notes.warn(earth, Code.NRP263, message, subject=tag)
    if hypot(x, y, z) > _STRONGEST_T:
        message = (
            f"the <magnetic_field> has {hypot(x, y, z):g} T, and that of the Earth at most 7e-05 T; "
            "is it meant in uT?"
        )
        notes.warn(field, Code.NRP264, message)
    for tag, most in (("latitude_deg", 90.0), ("longitude_deg", 360.0)):
        if abs(given := earth.number(tag, 0.0)) > most:
            raise earth.require(tag).error(f"<{tag}> must be from {-most:g} to {most:g}, not {given:g}")
    gradient = air.number("temperature_gradient", usual.temperature_gradient)
    if not gradient:
        raise air.error("the <temperature_gradient> must not be 0")
    return Surroundings(
        (x, y, z),
        air.positive("temperature", usual.temperature),
        gradient,
        air.positive("pressure", usual.pressure),
        earth.number("latitude_deg", 0.0),
        earth.number("longitude_deg", 0.0),
        earth.number("elevation", 0.0),
        earth.number("heading_deg", 0.0),
    )
