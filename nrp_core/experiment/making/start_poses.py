"""Robots that start where no robot can: inside the room, or with nothing below them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from nrp_core.findings import Code
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.drives.flight import Flight
from nrp_core.world.raycast.footing import can_fall, deepest_overlap, has_ground
from nrp_core.world.raycast.solids import room_of
from nrp_core.world.scene.model import Scene


def things_fall(capabilities: WorldCapabilities) -> bool:
    """Return whether a world lets the bodies of its scene fall."""
    return capabilities.dynamics and not capabilities.own_scene


def wrong_starts(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str, Code, str]]:
    """Yield each robot that starts in a wrong place, with the code and the message.

    Robots that are held, that fly or that have no collision shapes, and robots without gravity, may start
    anywhere.

    Args:
        scene: with the robots at their start poses.
        robots: their names.
    """
    room, names = room_of(scene), set(robots)
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
        elif not any(isinstance(drive, Flight) for drive in model.drives) and not has_ground(model, scene):
            z_m = model.pose.position[2]
            yield (
                model.name,
                Code.NRP292,
                f"nothing is below the robot '{model.name}', which starts at z {z_m:g} m",
            )
