"""The places and sizes of wheels, for plugins that take them from the model and not from parameters."""

from __future__ import annotations

from math import dist

from nrp_core.world.scene.model import Cylinder, Sphere
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.xml import Element


def separation_of(plugin: Element, left: str, right: str, model: ModelParts) -> float:
    """Return the distance of the joints of two wheels, m, as Gazebo's own plugins take it."""
    places = [model.joint(plugin, name).pose.position for name in (left, right)]
    apart = dist(*places)
    if not apart:
        raise plugin.error(f"the wheels of the joints '{left}' and '{right}' are at the same place")
    return apart


def wheel_diameter_of(plugin: Element, joint: str, model: ModelParts) -> float:
    """Return the diameter of the wheel on a joint, m, from its collision shape."""
    wheel = model.joint(plugin, joint).child
    shapes = [each.geometry for link in model.links if link.name == wheel for each in link.collisions]
    round_ones = [2 * shape.radius for shape in shapes if isinstance(shape, Cylinder | Sphere)]
    if not round_ones:
        raise plugin.error(
            f"this plugin takes the size of the wheel '{wheel}' from its collision, which must be a cylinder "
            f"or a sphere"
        )
    return max(round_ones)
