"""Lights of SDF."""

from __future__ import annotations

from math import inf, pi

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.model import Light
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.appearance import read_color

_KINDS = ("directional", "point", "spot")
_DOWN: Vector = (0.0, 0.0, -1.0)
_WHITE = (1.0, 1.0, 1.0, 1.0)


def read_light(element: Element, name: str, pose: Pose, reading: Reading) -> Light:
    """Return a ``<light>`` at a pose in the world.

    By default, directional lights cast shadows (as Gazebo's sun) and others do not.
    """
    kind = element.attributes.get("type", "point")
    if kind not in _KINDS:
        raise element.error(f"unknown light type '{kind}'{did_you_mean(kind, _KINDS)}")
    red, green, blue, alpha = read_color(element, "diffuse", reading) or _WHITE
    attenuation = _attenuation(element.find("attenuation"))
    if kind != "directional" and not sum(attenuation[1:]) > 0:
        message = (
            f"the factors of the <attenuation> of the light '{name}' are 0, so it is infinitely bright; "
            "1, 0 and 0 do not weaken it"
        )
        reading.notes.warn(element, Code.NRP264, message, subject=name)
    strength = element.number("intensity", 1.0) if element.flag("light_on", True) else 0.0
    if strength < 0:
        raise element.require("intensity").error(f"the <intensity> of a light must not be {strength:g}")
    return Light(
        name,
        kind,
        pose,
        pose.rotate(element.direction("direction", _DOWN)),
        (strength * red, strength * green, strength * blue, alpha),
        element.flag("cast_shadows", kind == "directional"),
        attenuation,
        _cone(element.find("spot"), reading),
    )


def _attenuation(element: Element | None) -> tuple[float, float, float, float]:
    """Return range and factors, by default SDF's."""
    if element is None:
        return inf, 1.0, 0.0, 0.0
    constant, linear, quadratic = (
        element.number(tag, default)
        for tag, default in (("constant", 1.0), ("linear", 1.0), ("quadratic", 0.0))
    )
    return element.positive("range", 10.0), constant, linear, quadratic


def _cone(element: Element | None, reading: Reading) -> tuple[float, float]:
    if element is None:
        return pi / 4, pi / 2
    outer = element.positive("outer_angle", pi / 2)
    if outer > 2 * pi:
        message = f"the <outer_angle> of a spot is {outer:g} rad, more than a turn; is it meant in degrees?"
        reading.notes.warn(element, Code.NRP264, message)
    outer = min(outer, 0.99 * pi)
    inner = element.number("inner_angle", outer / 2)
    if inner > outer:
        message = f"the <inner_angle> of a spot, {inner:g} rad, is above its <outer_angle>, which is used"
        reading.notes.warn(element, Code.NRP264, message)
    return min(inner, outer), outer
