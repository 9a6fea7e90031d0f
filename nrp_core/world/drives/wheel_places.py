"""The places and sizes of wheels, for plugins that take them from the model and not from parameters."""

from __future__ import annotations

from math import dist
from typing import TypeAlias

from nrp_core.findings import Code
from nrp_core.world.scene.model import Cylinder, Sphere
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.xml import Element

Sides: TypeAlias = tuple[str, ...]
"""Names of the wheel joints on one side, back to front."""


def separation_of(plugin: Element, left: str, right: str, model: ModelParts) -> float:
    """Return the distance of the joints of two wheels, m, as Gazebo's own plugins take it."""
    places = [model.joint(plugin, name).pose.position for name in (left, right)]
    apart = dist(*places)
    if not apart:
        raise plugin.error(f"the wheels of the joints '{left}' and '{right}' are at the same place")
    return apart


def sides_of(
    plugin: Element, left: Sides, right: Sides, model: ModelParts, reading: Reading
) -> tuple[Sides, Sides]:
    """Return the joints on the left and on the right of a drive that Gazebo's plugin for ROS 1 moves.

    The plugin takes its left joint for the right one unless ``legacyMode`` is false, which makes up for files
    that name them the other way round; that was a mistake in its first versions.
    """
    if not plugin.flag("legacyMode", True):
        return left, right
    aside = [model.joint(plugin, side[-1]).pose.position[1] for side in (left, right)]
    if aside[0] < aside[1]:
        return right, left
    if aside[0] > aside[1]:
        message = (
            "Gazebo exchanges the sides of this drive unless <legacyMode> is false, so there the robot turns "
            "against its commands; here it turns as they say"
        )
        reading.notes.warn(plugin, Code.NRP264, message)
    return left, right


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
