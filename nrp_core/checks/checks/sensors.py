"""Sensors that are read and that cannot see, are too fast for physics, or make images of a pixel or two."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from math import inf
from typing import Final

from nrp_core.checks.checks.time_conditions import read_topics
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.flight import Flight
from nrp_core.world.enclosing import Enclosure
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.raycast.solids import size_m
from nrp_core.world.render.scene_mesh import MAX_EXTENT_M
from nrp_core.world.scene.devices import MountedSensor
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.sight import Sight, enclosed, sights

_COVERED: Final = 2 / 3
"""Share of its own robot in what a sensor sees; cameras above a hood or a gripper see up to a half."""
_NOTED: Final = 1 / 2
_ALL: Final = 0.95
_SKY: Final = 0.6
_UPWARD: Final = 0.5
"""Mean vertical part of the rays of a sensor that looks up: 0.64 for a fan of half a turn, 1 for a camera."""
_NEAR: Final = 0.1
"""Distance of a camera's own housing, of the horizontal size of its robot; hoods and wheels are farther."""
_HOUSING: Final = 0.1
"""How far a camera stands inside its housing, of the same size; in public robots at most 0.03."""


@checks_experiment(Code.NRP298)
def sensors_see_the_room(static: StaticExperiment) -> Iterator[Finding]:
    """Look for scanners and cameras that see little but their own robot, or nothing at any heading."""
    scene, read = static.scene, _read(static)
    for model in _robots(static):
        assert scene is not None
        with suppress(SceneError):  # a mesh cannot be read, which is reported where it is needed
            inside = {(link, one.name): _inside(shape, model) for link, one, shape in enclosed(scene, model)}
            for sight in sights(scene, model):
                is_read = _is_read(sight.sensor, model, static, read)
                behind = inside.get((sight.link, sight.sensor.name), "") if is_read else ""
                message, level = (behind, Level.WARNING) if behind else _doubt(sight, scene, model)
                if message and (is_read or sight.own >= _ALL):
                    place = static.experiment.place("world", "robots", model.name)
                    who = f"the {_kind(sight.sensor)} '{sight.sensor.name}' on '{model.name}/{sight.link}'"
                    yield place.finding(Code.NRP298, f"{who} {message}", level if is_read else Level.NOTE)


def _inside(shape: Enclosure, model: Model) -> str:
    """Return how far inside a shape a camera stands; empty for a housing as cameras have."""
    # a model without joints and drives is a camera, whose only body is its housing
    housing_m = _HOUSING * (size_m(model) or inf) if model.joints or model.drives else inf
    if (shape.model == model.name and shape.through_m < housing_m) or shape.extent_m >= MAX_EXTENT_M:
        return ""
    return (
        f"stands inside '{shape.model}/{shape.link}', {shape.through_m:.2g} m behind its surface, which its "
        "images do not show: a body is drawn from outside only"
    )


def _doubt(sight: Sight, scene: Scene, model: Model) -> tuple[str, Level]:
    """Return why a sensor sees little of the room, and the level of that; empty if it sees enough."""
    if sight.own >= _NOTED:
        message = (
            f"sees its own robot with {sight.own:.0%} of its {_rays(sight.sensor)}, mostly the link "
            f"'{sight.most}', from {sight.nearest_m:.2g} m"
        )
        return message, Level.WARNING if sight.own >= _COVERED else Level.NOTE
    if sight.middle >= _NOTED and sight.middle_m <= _NEAR * (size_m(model) or 0.0):
        message = (
            f"sees its own housing in the middle of its images, from {sight.middle_m:.2g} m: "
            f"it covers {sight.middle:.0%} of the half of their width and height around it"
        )
        return message, Level.WARNING
    later = sight.turns or any(isinstance(drive, Flight) for drive in model.drives)
    later |= any(not one.static for one in scene.models if one is not model)
    level = Level.NOTE if later else Level.WARNING
    if sight.empty >= _ALL:
        return f"sees nothing at the start, whatever the heading of '{model.name}'", level
    if sight.empty >= _SKY and sight.up >= _UPWARD:
        message = f"looks up: {sight.empty:.0%} of its {_rays(sight.sensor)} reach nothing at any heading"
        return message, level
    return "", level


def _robots(static: StaticExperiment) -> list[Model]:
    names = static.experiment.world.robots
    return [model for model in static.scene.models if model.name in names] if static.scene else []


def read_sensors(static: StaticExperiment) -> Iterator[tuple[Model, MountedSensor]]:
    """Yield the scanners and cameras of robots that something reads."""
    read = _read(static)
    for model in _robots(static):
        for sensor in (sensor for link in model.links for sensor in link.sensors):
            sees = sensor.views or isinstance(getattr(sensor, "beams", None), Beams)
            if sees and _is_read(sensor, model, static, read):
                yield model, sensor


def _read(static: StaticExperiment) -> set[str]:
    """Return the topics that functions, events and criteria read."""
    aliases = static.experiment.aliases
    return {aliases.get(name, name) for name in read_topics(static)}


def _is_read(sensor: MountedSensor, model: Model, static: StaticExperiment, read: set[str]) -> bool:
    """Return whether one of these topics is a sensor's, or the experiment itself adds it."""
    return not read.isdisjoint(sensor.topics) or _is_added(static, model, sensor)


def _is_added(static: StaticExperiment, model: Model, sensor: MountedSensor) -> bool:
    """Return whether the experiment itself adds a sensor: it is for a recording if nothing else reads it."""
    added = static.experiment.world.robots[model.name].add_sensors
    return any((one.name or one.type) == sensor.name for one in added)


def _kind(sensor: MountedSensor) -> str:
    return "camera" if sensor.views else "scanner"


def _rays(sensor: MountedSensor) -> str:
    return "pixels" if sensor.views else "beams"
