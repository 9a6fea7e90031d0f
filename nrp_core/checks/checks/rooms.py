"""Things of the room that are only seen or only felt, and meshes that are turned inside out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.words import first_of
from nrp_core.checks.checks.conditions import asked
from nrp_core.checks.checks.sensors import read_sensors
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.enclosing import CLOSED, corners_of, filled_share
from nrp_core.world.render.scene_mesh import MAX_EXTENT_M
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.implausible_shapes import box_around
from nrp_core.world.scene.model import Collision, Heightmap, Mesh, Model, Plane, Visual

_LEAST_M: Final = 0.05
"""Things that reach less than this above the feet of robots are marks on the ground."""
_MOST_NAMES: Final = 3


@checks_experiment(Code.NRP298)
def things_are_seen_and_felt(static: StaticExperiment) -> Iterator[Finding]:
    """Look for things that robots drive through, and for those that no image shows."""
    if static.scene is None:
        return
    names = static.experiment.world.robots
    robots = [model for model in static.scene.models if model.name in names]
    room = [model for model in static.scene.models if model.static and model.name not in names]
    place = static.experiment.place("world", "scene")
    with suppress(SceneError):  # a mesh cannot be read, which is reported where it is needed
        feet = [box for box in (_box(robot, Collision) for robot in robots if _drives(robot)) if box]
        if feet:
            low, high = min(box[0][2] for box in feet), max(box[1][2] for box in feet)
            goals = {near.other for _, near in asked(static.experiment, "near", "near")}
            only_seen = [
                one.name for one in room if one.name not in goals and _only_seen(one, low + _LEAST_M, high)
            ]
            if only_seen:
                message = f"robots pass through {_listed(only_seen)}: seen, and without collision shapes"
                yield place.finding(Code.NRP298, message, Level.NOTE)
    if any(sensor.views for _, sensor in read_sensors(static)):
        only_felt = [one.name for one in room if not _shown(one) and _is_felt(one)]
        if only_felt:
            message = f"no image shows {_listed(only_felt)}: touched, and without anything to see"
            yield place.finding(Code.NRP298, message, Level.NOTE)


@checks_experiment(Code.NRP298)
def things_stand_apart(static: StaticExperiment) -> Iterator[Finding]:
    """Look for two models of the room with the same shapes at the same place: one changes nothing."""
    if static.scene is None:
        return
    first: dict[tuple[object, ...], str] = {}
    for model in static.scene.models:
        if model.name in static.experiment.world.robots or not _is_felt(model):
            continue
        shapes = [(link.pose, one.pose, one.geometry) for link in model.links for one in link.collisions]
        other = first.setdefault((model.pose, *shapes), model.name)
        if other != model.name:
            message = (
                f"'{model.name}' is exactly where '{other}' is, and has the same collision shapes: is one of "
                "them meant to be elsewhere?"
            )
            yield static.experiment.place("world", "scene").finding(Code.NRP298, message, Level.WARNING)


@checks_experiment(Code.NRP298)
def meshes_face_outward(static: StaticExperiment) -> Iterator[Finding]:
    """Look for closed meshes that are turned inside out, so that no image shows them from outside."""
    if static.scene is None or not any(sensor.views for _, sensor in read_sensors(static)):
        return
    names = static.experiment.world.robots
    feet = np.array([model.pose.position for model in static.scene.models if model.name in names])
    for model in static.scene.models:
        keys = ("world", "robots", model.name) if model.name in names else ("world", "scene")
        with suppress(SceneError):
            for link, visual, corners in _meshes(model):
                low, high = corners.min((0, 1)), corners.max((0, 1))
                is_around = model.name not in names and ((low < feet) & (feet < high)).all(1).any()
                if not is_around and filled_share(corners - corners.mean((0, 1))) < -CLOSED:
                    message = (
                        f"the mesh of the visual '{visual}' of '{model.name}/{link}' faces inward, and "
                        "surfaces are drawn where they face: no image shows it from outside"
                    )
                    yield static.experiment.place(*keys).finding(Code.NRP298, message, Level.WARNING)


def _meshes(model: Model) -> Iterator[tuple[str, str, FloatArray]]:
    """Yield the link, the name and the triangles in the world of each visible mesh, shape ``(n, 3, 3)``."""
    for link in model.links:
        for one in link.visuals:
            shape = one.geometry
            if isinstance(shape, Mesh) and not isinstance(shape, Heightmap) and one.rgba[3] > 0:
                yield link.name, one.name, corners_of(shape, model.pose @ link.pose @ one.pose)


def _drives(robot: Model) -> bool:
    """Return whether a robot may get to other places."""
    return not robot.static and not any(joint.parent == WORLD for joint in robot.joints)


def _only_seen(model: Model, low_m: float, high_m: float) -> bool:
    """Return whether a thing has no collision shapes and stands where robots of these heights drive."""
    box = _box(model, Visual) if not any(link.collisions for link in model.links) else None
    if box is None or (box[1] - box[0]).max() >= MAX_EXTENT_M:
        return False
    return bool(box[0][2] < high_m and box[1][2] > low_m)


def _is_felt(model: Model) -> bool:
    """Return whether a thing has a collision shape that is no ground."""
    return any(not isinstance(one.geometry, Plane) for link in model.links for one in link.collisions)


def _shown(model: Model) -> list[Visual]:
    return [one for link in model.links for one in link.visuals if one.rgba[3] > 0]


def _box(model: Model, kind: type[Visual] | type[Collision]) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners of the box around the visible or the collision shapes of a model in the world, m."""
    return box_around(
        (model.pose @ link.pose @ one.pose, one.geometry)
        for link in model.links
        for one in (link.collisions if kind is Collision else link.visuals)
        if not isinstance(one, Visual) or one.rgba[3] > 0
    )


def _listed(names: list[str]) -> str:
    return first_of([f"'{name}'" for name in names], _MOST_NAMES)
