"""Lights as SDF, for Gazebo's renderer, and what makes it start."""

from __future__ import annotations

from math import hypot, isfinite

from nrp_core.world import Light, Vector
from nrp_world_gazebo.elements import Xml, element, numbers, pose_element

NO_END_M = 1e4
"""The range of a light without one."""
_FALLOFF = 1.0
_TILT = 1e-3


def light_element(light: Light) -> Xml:
    """Return a light."""
    _, *factors = light.attenuation
    names = ("constant", "linear", "quadratic")
    made = element(
        "light",
        pose_element(light.pose),
        numbers("diffuse", *light.diffuse),
        element("cast_shadows", text=str(int(light.casts_shadows))),
        element(
            "attenuation",
            numbers("range", range_of(light)),
            *(numbers(name, factor) for name, factor in zip(names, factors, strict=True)),
        ),
        numbers("direction", *light.pose.inverse().rotate(direction_of(light))),
        name=light.name,
        type=light.kind,
    )
    if light.kind == "spot":
        inner, outer = light.cone
        angles = [numbers("inner_angle", inner), numbers("outer_angle", outer), numbers("falloff", _FALLOFF)]
        made.append(element("spot", *angles))
    return made


def direction_of(light: Light) -> Vector:
    """Return the direction of a light, never quite up or down: shadows of such a light end Gazebo."""
    x, y, z = light.direction
    return (x + _TILT * abs(z), y, z) if hypot(x, y) < _TILT * abs(z) else light.direction


def range_of(light: Light) -> float:
    """Return the range of a light as Gazebo takes it."""
    return light.attenuation[0] if isfinite(light.attenuation[0]) else NO_END_M


def waking_camera() -> Xml:
    """Return a model with a camera that draws nothing: Gazebo's renderer runs only if a sensor needs it."""
    size = [element(side, text="1") for side in ("width", "height")]
    camera = element("camera", element("image", *size))
    sensor = element("sensor", camera, numbers("update_rate", 1.0), name="camera", type="camera")
    link = element("link", sensor, name="link")
    return element("model", element("static", text="1"), link, name="nrp_renderer")
