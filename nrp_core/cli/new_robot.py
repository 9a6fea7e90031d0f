"""The parts of an experiment with the user's robot: wheels or joints, and the height above the ground."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import ExperimentError
from nrp_core.scene.model import Cylinder, Joint, Link, Model, Sphere
from nrp_core.scene.reading.context import read_without
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_scene
from nrp_core.scene.tessellation import box_around

SPEED_M_S = 0.3
"""Speed of a wheel on the ground while its neuron fires at 50 Hz."""
_MAX_JOINTS, _SWING_RAD, _RADIUS_M = 12, 0.4, 0.1
_LEVEL = 0.7
"""Minimum share of the axis of a wheel that points along y, to the side."""
_NAME = re.compile(r"[\w .:/+-]+")
"""The names that templates may write into code."""


@dataclass(frozen=True, slots=True)
class Driven:
    """A joint that the brain drives.

    Args:
        name: its name.
        side: ``left`` or ``right``: the population that drives it.
        centre: the command at rest, rad or m.
        gain: the change of the command per spike a second.
    """

    name: str
    side: str
    centre: float
    gain: float


def robot_values(file: Path) -> Mapping[str, Any]:
    """Return the variables of the templates for a robot.

    Raises:
        ExperimentError: the file has no robot that moves, one without joints to command, or a name that
            cannot stand in code.
    """
    read = partial(read_scene, file, lenient=True)
    scene, _ = read_without(lambda without: read(without=without))
    moving = [model for model in scene.models if not model.static]
    if len(moving) != 1:
        raise ExperimentError(f"a file with one robot is needed, and this one has {len(moving)}", path=file)
    (model,) = moving
    links = {link.name: link for link in model.links}
    free = [joint for joint in model.joints if joint.takes_commands and joint.mimic is None]
    carrying = {joint.parent for joint in free}
    wheels = [joint for joint in free if _is_wheel(joint) and joint.child not in carrying]
    wheels = wheels if len(wheels) > 1 else []  # one alone may be the wrist of an arm
    driven = list(_wheels(wheels, links) if wheels else _swinging(free[:_MAX_JOINTS]))
    if not driven:
        raise ExperimentError("this robot has no joint that takes commands", path=file)
    children = {joint.child for joint in model.joints}
    base = next((link for link in model.links if link.name not in children), model.links[0])
    for name in (base.name, *(joint.name for joint in driven)):
        if not _NAME.fullmatch(name):
            raise ExperimentError(
                f"the link or joint {name!r} needs a name of letters, digits, spaces and '_.:/+-' alone",
                path=file,
            )
    low_m, high_m = _extent_m(model)
    return {
        "model": str(file.resolve()), "driven": driven, "mode": "velocity" if wheels else "position",
        "height": round(0.01 - low_m, 4), "base": base.name,
        "lidar": round(high_m - base.pose.position[2] + 0.05, 4), "is_wheeled": bool(wheels),
        "first": driven[0].name, "unit": "m/s" if free[0].kind == "prismatic" else "rad/s",
    }  # fmt: skip


def _is_wheel(joint: Joint) -> bool:
    """Return whether a joint turns without limits about a lateral axis."""
    endless = joint.kind == "continuous" or (joint.kind == "revolute" and not isfinite(joint.upper))
    return endless and abs(_axis(joint)[1]) > _LEVEL


def _axis(joint: Joint) -> FloatArray:
    """Return the axis of a joint in the frame of its robot."""
    return np.subtract((joint.pose @ Pose(joint.axis)).position, joint.pose.position)


def _wheels(wheels: list[Joint], links: Mapping[str, Link]) -> Iterator[Driven]:
    middle = float(np.mean([joint.pose.position[1] for joint in wheels]))
    for joint in wheels:
        shapes = [one.geometry for one in links[joint.child].collisions]
        radii = [shape.radius for shape in shapes if isinstance(shape, Cylinder | Sphere)]
        gain = SPEED_M_S / max(radii, default=_RADIUS_M) / 50.0
        side = "left" if joint.pose.position[1] >= middle else "right"
        yield Driven(joint.name, side, 0.0, round(gain if _axis(joint)[1] > 0 else -gain, 5))


def _swinging(joints: list[Joint]) -> Iterator[Driven]:
    for number, joint in enumerate(joints):
        near = min(max(0.0, joint.lower), joint.upper)
        low, high = max(joint.lower, near - 1.0), min(joint.upper, near + 1.0)
        centre, swing = (low + high) / 2, min(_SWING_RAD, (high - low) / 3)
        yield Driven(joint.name, "right" if number % 2 else "left", round(centre, 5), round(swing / 50.0, 6))


def _extent_m(model: Model) -> tuple[float, float]:
    """Return the heights of the lowest and the highest shape of a robot."""
    solid = [(link.pose @ one.pose, one.geometry) for link in model.links for one in link.collisions]
    shown = [(link.pose @ one.pose, one.geometry) for link in model.links for one in link.visuals]
    box = box_around(solid + shown)
    return (0.0, 0.0) if box is None else (float(box[0][2]), float(box[1][2]))
