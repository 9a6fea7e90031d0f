"""Impossible starts: robots inside the room or each other, high up, below the ground, or without ground.

Joints are at their initial positions. Static meshes count as ground, but models overlap only with height maps
and simple solids, because engines treat the inside of other meshes differently.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import replace
from itertools import chain, combinations, product
from math import inf
from typing import Final

import numpy as np

from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.findings import Code, Finding
from nrp_core.scene.model import Heightmap, Model, Plane, Scene
from nrp_core.scene.posture import at_start, moved_into_limits, start_positions
from nrp_core.scene.tessellation import box_around, shapes_of
from nrp_core.world.drives.flight import Flight
from nrp_core.world.raycast.solids import Solid, can_fall, room_of, solids_of

HIGHEST_START_M: Final = 3.0
"""Height of a start above the ground, m; a fall from there ends at 7.7 m/s."""
MIN_TOLERANCE_M: Final = 0.02
MAX_TOLERANCE_M: Final = 0.05
"""Limits of the tolerated overlap: engines correct it without throwing the model."""


@checks_experiment
def check_start_joints(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report the robots with joints that cannot start at 0, and for which the experiment gives no start."""
    for model in examined.robots:
        if moved := moved_into_limits(model):
            positions = start_positions(model)
            listed = ", ".join(f"'{joint.name}' at {positions[joint.name]:g}" for joint in moved)
            message = f"the limits of these joints exclude 0, so they start at the nearest limit: {listed}"
            yield examined.warning(Code.NRP264, message, "world", "robots", model.name)


@checks_experiment
def check_start_poses(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Check the start poses of robots and of the loose models of the room."""
    if examined.scene is None or not examined.bodies_fall:
        return
    scene = replace(examined.scene, models=tuple(map(at_start, examined.models)))
    robots = examined.experiment.world.robots
    found = chain(_buried(scene, robots), _falling_models(scene, robots), wrong_starts(scene, robots))
    for model, code, message in found:
        yield examined.warning(code, message, *examined.keys_of(model))


def wrong_starts(scene: Scene, robots: Container[str]) -> Iterator[tuple[str, Code, str]]:
    """Yield each robot with an impossible start pose, with the code and the message.

    Robots that are held, that fly or that have no collision shapes, and robots without gravity, may start
    anywhere.

    Args:
        scene: the scene with the robots at their start poses.
        robots: names of the robots.
    """
    loose = (model for model in scene.models if not model.static and model.name not in robots)
    room = [*room_of(scene), *(solid for model in loose for solid in solids_of(model))]
    models = [model for model in scene.models if model.name in robots]
    for other, model in combinations(models, 2):
        if overlap := _deepest_overlap(model, list(solids_of(other))):
            message = f"the robot '{model.name}' starts inside the robot '{other.name}': {overlap}"
            yield model.name, Code.NRP291, message
    for model in models:
        if not can_fall(model, scene):
            continue
        if overlap := _deepest_overlap(model, room):
            yield model.name, Code.NRP291, f"the robot '{model.name}' starts inside the room: {overlap}"
        elif not _flies(model):
            z_m, height_m = model.pose.position[2], _height_above_ground_m(model, scene)
            if height_m == inf:
                message = f"nothing is below the robot '{model.name}', which starts at z {z_m:g} m"
                yield model.name, Code.NRP292, message
            elif height_m > HIGHEST_START_M:
                message = (
                    f"the robot '{model.name}' starts at z {z_m:g} m and falls: it is {height_m:.3g} m above "
                    "everything below it"
                )
                yield model.name, Code.NRP306, message


def _falling_models(scene: Scene, robots: Container[str]) -> Iterator[tuple[str, Code, str]]:
    """Yield each model of a room without support: neither held nor above another model."""
    for model in scene.models:
        is_held = not all(link.gravity for link in model.links) or _flies(model)
        if model.name in robots or is_held or not can_fall(model, scene):
            continue
        if _height_above_ground_m(model, scene) == inf:
            message = (
                f"nothing is below the model '{model.name}' of the room: it falls, and what stands on it; is "
                "it meant to be <examined>?"
            )
            yield model.name, Code.NRP292, message


def _buried(scene: Scene, robots: Container[str]) -> Iterator[tuple[str, Code, str]]:
    """Yield each robot that cannot fall and is below a ground without end.

    Those that can fall start inside the ground, which :func:`wrong_starts` finds.
    """
    grounds = [solid for solid in room_of(scene) if solid.is_endless and solid.highest_m < inf]
    for model in scene.models if grounds else ():
        if model.name not in robots or can_fall(model, scene):
            continue
        ground = min(grounds, key=lambda solid: solid.highest_m)
        shapes = ((link, one) for link in model.links for one in shapes_of(link))
        box = box_around((model.pose @ link.pose @ one.pose, one.geometry) for link, one in shapes)
        if box is not None and box[1][2] < ground.highest_m - MAX_TOLERANCE_M:
            message = (
                f"the robot '{model.name}' reaches up to z {box[1][2]:.3g} m, which is below '{ground.name}'"
            )
            yield model.name, Code.NRP306, message


def _flies(model: Model) -> bool:
    return any(isinstance(drive, Flight) for drive in model.drives)


def _deepest_overlap(model: Model, room: Sequence[Solid]) -> str:
    """Return how deep a part of a model is inside a room at the start; empty if that is tolerated."""
    parts = list(solids_of(model))
    heights_m = [part.points[:, 2] for part in parts]
    low_m = 0.2 * float(np.ptp(np.concatenate(heights_m))) if parts else 0.0
    found = [(0.0, "")]
    for part, solid in product(parts, room):
        if _near(part, solid):
            # less is tolerated for low models and in thin solids
            tolerated_m = max(MIN_TOLERANCE_M, min(MAX_TOLERANCE_M, low_m, solid.half_thickness_m / 2))
            depth_m = solid.depth_of(part.points)
            if depth_m > tolerated_m:
                found.append((depth_m, f"'{part.name}' is {depth_m:.2f} m deep in '{solid.name}'"))
    return max(found, key=lambda overlap: overlap[0])[1]


def _height_above_ground_m(model: Model, scene: Scene) -> float:
    """Return the height of a model's lowest point above the shapes of others below it, m; infinite for none.

    A shape counts as its bounding box, so the result is never too large; above a slope it is 0.
    """
    points = np.vstack([solid.points for solid in solids_of(model)])
    others = (solid for other in scene.models if other.name != model.name for solid in solids_of(other))
    tops = [solid.highest_m for solid in others if solid.is_below(points)]
    return max(0.0, float(points[:, 2].min()) - max(tops)) if tops else inf


def _near(part: Solid, solid: Solid) -> bool:
    """Return whether the boxes around two shapes meet."""
    if isinstance(solid.geometry, Plane):
        return True
    (low, high), (room_low, room_high) = part.box, solid.box
    apart = (low > room_high) | (high < room_low)
    if isinstance(solid.geometry, Heightmap):
        apart[2] = low[2] > room_high[2]  # below its surface everything is inside
    return not bool(apart.any())
