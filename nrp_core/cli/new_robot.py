"""The parts of an experiment with the user's robot: drive, wheels or joints, and its height at the start."""

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
from nrp_core.scene.sdf import read_model
from nrp_core.scene.tessellation import box_around

SPEED_M_S = 0.3
"""Speed of a wheel on the ground while its neuron fires at 50 Hz."""
_MAX_JOINTS, _SWING_RAD, _RADIUS_M, _SEPARATION_M = 12, 0.4, 0.1, 0.5
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
    read = partial(read_model, file, name="robot", lenient=True)
    model, _ = read_without(lambda without: read(without=without))
    if model.static:
        raise ExperimentError("a robot that moves is needed, and this one is static", path=file)
    links = {link.name: link for link in model.links}
    drive = next((one for one in model.drives if "linear.x" in getattr(one, "components", ())), None)
    moved = {joint for one in model.drives for joint in one.joints}
    joints = [one for one in model.joints if one.takes_commands and one.mimic is None]
    free = [joint for joint in joints if joint.name not in moved]
    carrying = {joint.parent for joint in free}
    wheels = [joint for joint in free if _is_wheel(joint) and joint.child not in carrying]
    wheels = wheels if len(wheels) > 1 and drive is None else []  # one alone may be the wrist of an arm
    is_wheeled = drive is not None or bool(wheels)
    swinging = [] if is_wheeled else free[:_MAX_JOINTS]
    driven = [*_wheels(wheels, links), *_swinging(swinging)]
    if not driven and drive is None:
        raise ExperimentError("this robot has no joint that takes commands", path=file)
    held = [joint.name for joint in free if is_wheeled and isfinite(joint.upper - joint.lower)]
    children = {joint.child for joint in model.joints}
    base = next((link for link in model.links if link.name not in children), model.links[0])
    for name in (base.name, *(joint.name for joint in driven), drive.command_topic if drive else "/"):
        if not _NAME.fullmatch(name):
            raise ExperimentError(
                f"the link, joint or topic {name!r} needs a name of letters, digits, spaces and '_.:/+-'",
                path=file,
            )
    low_m, high_m = _extent_m(model)
    return {
        "model": str(file.resolve()), "driven": driven, "mode": "velocity" if wheels else "position",
        "held": [name for name in held if _NAME.fullmatch(name)],
        "height": round(0.01 - low_m, 4), "base": base.name, "is_wheeled": is_wheeled,
        "lidar": round(high_m - base.pose.position[2] + 0.05, 4),
        "first": driven[0].name if driven else "",
        "unit": "m/s" if driven and free[0].kind == "prismatic" else "rad/s",
        "twist": drive.command_topic if drive else "", "speed": SPEED_M_S / 50.0,
        "turn": round(SPEED_M_S / 50.0 / getattr(drive, "separation", _SEPARATION_M), 5),
    }  # fmt: skip


def _is_wheel(joint: Joint) -> bool:
    """Return whether a joint turns without limits about a lateral axis."""
    endless = joint.kind == "continuous" or (joint.kind == "revolute" and not isfinite(joint.upper))
    return endless and abs(_axis(joint)[1]) > _LEVEL


def _axis(joint: Joint) -> FloatArray:
    """Return the axis of a joint in the frame of its robot."""
    return np.subtract((joint.pose @ Pose(joint.axis)).position, joint.pose.position)


def _wheels(wheels: list[Joint], links: Mapping[str, Link]) -> Iterator[Driven]:
    middle = sum(joint.pose.position[1] for joint in wheels) / max(len(wheels), 1)
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
