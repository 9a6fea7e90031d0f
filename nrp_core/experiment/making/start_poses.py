"""Robots at impossible start poses: inside the room or each other, high up, or with nothing below them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import Final

from nrp_core.findings import Code
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.drives.flight import Flight
from nrp_core.world.raycast.solids import (
    can_fall,
    deepest_overlap,
    has_ground,
    height_above_ground_m,
    room_of,
    solids_of,
)
from nrp_core.world.scene.model import Model, Scene

_HIGH_M: Final = 3.0
"""Maximum height of a start above the ground, m; a fall from there ends at 7.7 m/s."""


def things_fall(capabilities: WorldCapabilities) -> bool:
    """Return whether a world lets the bodies of its scene fall."""
    return capabilities.dynamics and not capabilities.own_scene


def wrong_starts(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str, Code, str]]:
    """Yield each robot with an impossible start pose, with the code and the message.

    Robots that are held, that fly or that have no collision shapes, and robots without gravity, may start
    anywhere.

    Args:
        scene: the scene with the robots at their start poses.
        robots: names of the robots.
    """
    names = set(robots)
    loose = (model for model in scene.models if not model.static and model.name not in names)
    room = [*room_of(scene), *(solid for model in loose for solid in solids_of(model))]
    yield from _inside_each_other([model for model in scene.models if model.name in names])
    for model in scene.models:
        if model.name not in names or not can_fall(model, scene):
            continue
        overlap = deepest_overlap(model, room)
        if overlap is not None:
            message = (
                f"the robot '{model.name}' starts inside the room: '{overlap.part}' is "
                f"{overlap.depth_m:.2f} m deep in '{overlap.room}'"
            )
            yield model.name, Code.NRP291, message
        elif not any(isinstance(drive, Flight) for drive in model.drives):
            yield from _wrong_heights(model, scene)


def falling(scene: Scene, robots: Iterable[str]) -> Iterator[str]:
    """Yield a sentence for each model of a room that nothing holds, and with nothing below it.

    Args:
        scene: the scene at its start.
        robots: names of the robots, which :func:`wrong_starts` examines.
    """
    names = set(robots)
    for model in scene.models:
        is_held = not all(link.gravity for link in model.links) or any(
            isinstance(drive, Flight) for drive in model.drives
        )
        if (
            model.name not in names
            and not is_held
            and can_fall(model, scene)
            and not has_ground(model, scene)
        ):
            yield (
                f"nothing is below the model '{model.name}' of the room: it falls, and what stands on it; is "
                "it meant to be <static>?"
            )


def _inside_each_other(models: list[Model]) -> Iterator[tuple[str, Code, str]]:
    """Yield each robot that starts inside another one, but not at its origin: every check reports that."""
    for other, model in combinations(models, 2):
        overlap = None
        if other.pose.position != model.pose.position:
            overlap = deepest_overlap(model, list(solids_of(other)))
        if overlap is not None:
            message = (
                f"the robot '{model.name}' starts inside the robot '{other.name}': '{overlap.part}' is "
                f"{overlap.depth_m:.2f} m deep in '{overlap.room}'"
            )
            yield model.name, Code.NRP291, message


def _wrong_heights(model: Model, scene: Scene) -> Iterator[tuple[str, Code, str]]:
    z_m = model.pose.position[2]
    if not has_ground(model, scene):
        message = f"nothing is below the robot '{model.name}', which starts at z {z_m:g} m"
        yield model.name, Code.NRP292, message
        return
    height_m = height_above_ground_m(model, scene)
    if height_m > _HIGH_M:
        message = (
            f"the robot '{model.name}' starts at z {z_m:g} m and falls: it is {height_m:.3g} m above "
            f"everything below it"
        )
        yield model.name, Code.NRP306, message
