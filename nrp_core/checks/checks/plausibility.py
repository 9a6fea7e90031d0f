"""Implausible values of robots, rooms, drives, steps and mappings, and impossible starts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.clock import NS_PER_MS, milliseconds, seconds
from nrp_core.experiment.making.doubtful_mappings import doubtful_mappings
from nrp_core.experiment.making.prepare import place_of_step
from nrp_core.experiment.making.start_poses import falling, things_fall, wrong_starts
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.implausible import implausible_drives, weightless_wheels
from nrp_core.world.raycast.solids import below_ground, buried
from nrp_core.world.scene import implausible as scene_plausibility
from nrp_core.world.scene.model import Scene
from nrp_core.world.sensors.camera import Camera


@checks_experiment(Code.NRP291)
def robots_start_apart(static: StaticExperiment) -> Iterator[Finding]:
    """Look for robots that start inside each other."""
    if static.scene is None:
        return
    first: dict[tuple[float, ...], str] = {}
    for model in static.scene.models:
        if model.name not in static.experiment.world.robots:
            continue
        other = first.setdefault(tuple(model.pose.position), model.name)
        if other != model.name:
            place = static.experiment.place("world", "robots", model.name, "pose")
            message = f"'{model.name}' starts in the same place as '{other}'; give it a 'pose' of its own"
            yield place.finding(Code.NRP291, message, Level.WARNING)


_MAX_STEPS: Final = 1000
"""Steps of a physics engine in one of the loop; the smallest robots need a hundred."""
_LONGEST_NS: Final = 10 * NS_PER_MS
"""The longest step of Gymnasium's models that touch something; Gazebo takes 1 ms and MuJoCo 2 ms."""


@checks_experiment(Code.NRP298)
def check_steps(static: StaticExperiment) -> Iterator[Finding]:
    """Look for steps of the world that are most likely in another unit."""
    experiment, step_ns = static.experiment, static.world.capabilities.step_ns if static.world else None
    if not step_ns:
        return
    keys, message = place_of_step(experiment), ""
    if experiment.timestep > _MAX_STEPS * step_ns:
        message = (
            f"the world takes {experiment.timestep // step_ns} steps of {milliseconds(step_ns):g} ms in each "
            "step of the loop; is the unit of its step wrong?"
        )
    elif _falling_scene(static) is not None and keys[0] == "world" and step_ns > _LONGEST_NS:
        message = (
            f"the physics step is {milliseconds(step_ns):g} ms, and 1 to 5 ms are usual: contacts and "
            "controllers act late, so that robots move otherwise; is the step of the loop meant?"
        )
    if message:
        yield experiment.place(*keys).finding(Code.NRP298, message, Level.WARNING)


@checks_experiment(Code.NRP298)
def check_models(static: StaticExperiment) -> Iterator[Finding]:
    """Look for implausible robots, rooms and drives."""
    scene = _falling_scene(static)
    if scene is None:
        return
    robots, step_s = static.experiment.world.robots, seconds(static.experiment.timestep)
    for robot, message in scene_plausibility.implausible(scene, robots):
        yield _at(static, Code.NRP298, robot, message)
    for model in scene.models:
        if model.name in robots:
            for message in (*implausible_drives(model, step_s), *weightless_wheels(model, scene.gravity)):
                yield _at(static, Code.NRP298, model.name, message)


@checks_experiment(Code.NRP291, Code.NRP292, Code.NRP306, Code.NRP316)
def check_starts(static: StaticExperiment) -> Iterator[Finding]:
    """Look for models that start inside others, below the ground, high above it, or without ground."""
    scene = _falling_scene(static)
    if scene is None:
        return
    robots = static.experiment.world.robots
    for model, ground in below_ground(scene, robots):
        message = f"the model '{model}' lies below '{ground}', which the robots stand on"
        yield _at(static, Code.NRP316, None, message)
    for robot, top_m, ground in buried(scene, robots):
        message = f"the robot '{robot}' reaches up to z {top_m:.3g} m, which is below '{ground}'"
        yield _at(static, Code.NRP316, robot, message)
    for message in falling(scene, robots):
        yield _at(static, Code.NRP292, None, message)
    for name, code, message in wrong_starts(scene, robots):
        yield _at(static, code, name, message)


@checks_experiment(Code.NRP295)
def check_light(static: StaticExperiment) -> Iterator[Finding]:
    """Look for realistic images of a scene without light."""
    renderer = getattr(static.world.options, "renderer", None) if static.world else None
    if static.scene is None or static.scene.lights or renderer != "realistic":
        return
    if any(isinstance(sensor, Camera) for _, link in static.scene.links() for sensor in link.sensors):
        message = "the scene has no light: images of the realistic renderer are dark"
        yield _at(static, Code.NRP295, None, message)


@checks_experiment(Code.NRP297, Code.NRP308)
def check_network(static: StaticExperiment) -> Iterator[Finding]:
    """Report implausible values of the network, and remarks of whatever read it."""
    collector = Collector(static.experiment.source)
    collector.place(static.summary.findings, "brain", "model")
    yield from collector.findings


@checks_experiment(Code.NRP211, Code.NRP297, Code.NRP315)
def check_mappings(static: StaticExperiment) -> Iterator[Finding]:
    """Look for mappings of functions whose effect differs from their declaration."""
    if static.network is not None:
        for declared in static.declared:
            yield from doubtful_mappings(declared.function, static.network)


def _falling_scene(static: StaticExperiment) -> Scene | None:
    """Return the scene if its world lets bodies fall."""
    falls = static.world is not None and things_fall(static.world.capabilities)
    return static.scene if falls else None


def _at(static: StaticExperiment, code: Code, robot: str | None, message: str) -> Finding:
    """Return a warning at a robot of the experiment, or at its room."""
    keys: tuple[Key, ...] = ("world", "scene") if robot is None else ("world", "robots", robot)
    return static.experiment.place(*keys).finding(code, message, Level.WARNING)
