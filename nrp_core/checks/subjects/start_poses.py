"""Impossible starts: robots inside the room or each other, high up, below the ground, or without ground.

Joints are where they start. Static meshes count as ground, but models overlap only with height maps and
simple solids, because engines treat the inside of other meshes differently.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import inf
from typing import Final

import numpy as np

from nrp_core.checks.check import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.experiment.running.observation import bodies_fall
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.flight import Flight
from nrp_core.world.raycast.solids import Solid, can_fall, room_of, solids_of
from nrp_core.world.scene.model import Heightmap, Model, Plane, Scene
from nrp_core.world.scene.posture import at_start, moved_into_limits, start_positions
from nrp_core.world.scene.tessellation import box_around, shapes_of

HIGHEST_START_M: Final = 3.0
"""Height of a start above the ground, m; a fall from there ends at 7.7 m/s."""
MIN_TOLERANCE_M: Final = 0.02
MAX_TOLERANCE_M: Final = 0.05
"""Limits of the tolerated overlap: engines correct it without throwing the model."""


@checks_experiment
def check_start_joints(static: StaticExperiment) -> Iterator[Finding]:
    """Report the robots with joints that cannot start at 0, and for which the experiment gives no start."""
    for model in static.scene.models if static.scene is not None else ():
        if model.name not in static.experiment.world.robots:
            continue
        if moved := moved_into_limits(model):
            positions = start_positions(model)
            listed = ", ".join(f"'{joint.name}' at {positions[joint.name]:g}" for joint in moved)
            message = f"the limits of these joints exclude 0, so they start at the nearest limit: {listed}"
            place = static.experiment.place("world", "robots", model.name)
            yield place.finding(Code.NRP264, message, Level.WARNING)


@checks_experiment
def check_start_poses(static: StaticExperiment) -> Iterator[Finding]:
    """Check the start poses of robots and of the loose models of the room."""
    if static.scene is None or static.world is None or not bodies_fall(static.world.capabilities):
        return
    scene = replace(static.scene, models=tuple(map(at_start, static.scene.models)))
    robots = static.experiment.world.robots
    room = static.experiment.place("world", "scene")
    for robot, top_m, ground in buried(scene, robots):
        message = f"the robot '{robot}' reaches up to z {top_m:.3g} m, which is below '{ground}'"
        yield static.experiment.place("world", "robots", robot).finding(Code.NRP306, message, Level.WARNING)
    for message in falling_models(scene, robots):
        yield room.finding(Code.NRP292, message, Level.WARNING)
    for robot, code, message in wrong_starts(scene, robots):
        yield static.experiment.place("world", "robots", robot).finding(code, message, Level.WARNING)


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


def falling_models(scene: Scene, robots: Iterable[str]) -> Iterator[str]:
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
    """Yield each robot that starts inside another one."""
    for other, model in combinations(models, 2):
        if overlap := deepest_overlap(model, list(solids_of(other))):
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
    if height_m > HIGHEST_START_M:
        message = (
            f"the robot '{model.name}' starts at z {z_m:g} m and falls: it is {height_m:.3g} m above "
            f"everything below it"
        )
        yield model.name, Code.NRP306, message


@dataclass(frozen=True, slots=True)
class Overlap:
    """A collision shape of a model inside one of the room, both as ``model/link/collision``."""

    part: str
    room: str
    depth_m: float
    tolerated_m: float


def deepest_overlap(model: Model, room: Sequence[Solid]) -> Overlap | None:
    """Return the deepest overlap of a model with a room at the start, if it is more than is tolerated."""
    parts = list(solids_of(model))
    if not parts:
        return None
    points = np.vstack([part.points for part in parts])
    height_m = float(np.ptp(points[:, 2]))
    overlaps = [
        Overlap(part.name, solid.name, solid.depth_of(part.points), _tolerated_m(height_m, solid))
        for part in parts
        for solid in room
        if _near(part, solid)
    ]
    too_deep = (overlap for overlap in overlaps if overlap.depth_m > overlap.tolerated_m)
    return max(too_deep, key=lambda overlap: overlap.depth_m, default=None)


def _tolerated_m(height_m: float, solid: Solid) -> float:
    """Return the tolerated overlap; it is smaller for low models and in thin solids."""
    return max(MIN_TOLERANCE_M, min(MAX_TOLERANCE_M, 0.2 * height_m, solid.half_thickness_m / 2))


def has_ground(model: Model, scene: Scene) -> bool:
    """Return whether some shape of another model is below a model at the start."""
    points = np.vstack([solid.points for solid in solids_of(model)])
    others = (solid for other in scene.models if other.name != model.name for solid in solids_of(other))
    return any(solid.is_below(points) for solid in others)


def height_above_ground_m(model: Model, scene: Scene) -> float:
    """Return the height of the lowest point of a model above the shapes of other models below it, m.

    A shape counts as its bounding box, so the result is never too large; above a slope it is 0.
    """
    points = np.vstack([solid.points for solid in solids_of(model)])
    others = (solid for other in scene.models if other.name != model.name for solid in solids_of(other))
    tops = [solid.highest_m for solid in others if solid.is_below(points)]
    return max(0.0, float(points[:, 2].min()) - max(tops)) if tops else 0.0


def buried(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str, float, str]]:
    """Yield each robot that cannot fall and is below a ground without end, its top (m), and the ground.

    Those that can fall start inside the ground, which :func:`deepest_overlap` finds.
    """
    names = set(robots)
    grounds = [solid for solid in room_of(scene) if solid.is_endless and solid.highest_m < inf]
    lowest = min(grounds, key=lambda solid: solid.highest_m, default=None)
    for model in scene.models if lowest else ():
        if model.name not in names or can_fall(model, scene):
            continue
        shapes = ((link, one) for link in model.links for one in shapes_of(link))
        box = box_around((model.pose @ link.pose @ one.pose, one.geometry) for link, one in shapes)
        if lowest is not None and box is not None and box[1][2] < lowest.highest_m - MAX_TOLERANCE_M:
            yield model.name, float(box[1][2]), lowest.name


def _near(part: Solid, solid: Solid) -> bool:
    """Return whether the boxes around two shapes meet."""
    if isinstance(solid.geometry, Plane):
        return True
    (low, high), (room_low, room_high) = part.box, solid.box
    apart = (low > room_high) | (high < room_low)
    if isinstance(solid.geometry, Heightmap):
        apart[2] = low[2] > room_high[2]  # below its surface everything is inside
    return not bool(apart.any())
