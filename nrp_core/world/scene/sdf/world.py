"""Worlds of SDF."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Model, Scene, Tie
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import warn_of_plugin
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.frames import Frames
from nrp_core.world.scene.sdf.lights import read_light
from nrp_core.world.scene.sdf.model import Parts, build_model, read_parts
from nrp_core.world.scene.sdf.placed import Placed, read_placed
from nrp_core.world.scene.sdf.source import Source
from nrp_core.world.scene.sdf.states import State
from nrp_core.world.scene.sdf.surroundings import read_surroundings
from nrp_core.world.scene.sdf.world_joints import add_joint_frames, in_model, read_world_joints, tie_of
from nrp_core.world.scene.stand_in import with_static_shapes

_GRAVITY: Vector = (0.0, 0.0, -9.8)


def read_world(world: Element, source: Source, reading: Reading) -> Scene:
    """Read a ``<world>``, or the models and lights of an ``<sdf>`` without one.

    Raises:
        SceneError: an element of it cannot be used.
    """
    for plugin in world.all("plugin"):
        warn_of_plugin(plugin, reading)
    state = State.read(world.all("state"), reading.notes)
    placed = [
        thing
        for part in (world, *state.inserted)
        for thing in read_placed(part, source, reading, "model", "light")
        if thing.name not in state.deleted
    ]
    state.warn_of_misspelt([thing.name for thing in placed], reading.notes)
    things = [thing for thing in placed if thing.element.tag == "model"]
    read, ties = _models(world, things, source.version, reading)
    models = [state.of(model) for model in read]
    lights = [
        read_light(light.element, light.name, pose, reading)
        for light in placed
        if light.element.tag == "light"
        for pose in [state.poses.get(("light", light.name), light.pose(WORLD)[0])]
    ]
    shaped = with_static_shapes(models, partial(reading.notes.warn, world))
    earth = read_surroundings(world, reading.notes)
    step_s, findings = _step_s(world), reading.notes.findings
    return Scene(shaped, tuple(lights), _gravity(world), findings, step_s, earth, ties)


def _models(
    world: Element, placed: Iterable[Placed], version: tuple[int, int], reading: Reading
) -> tuple[list[Model], tuple[Tie, ...]]:
    """Return the models of a world, whose poses may be relative to each other's frames, and their ties."""
    frames = Frames(world, WORLD, WORLD)
    for frame in world.all("frame"):
        attached_to = frame.attributes.get("attached_to") or WORLD
        frames.add(frame, attached_to, attached_to=attached_to)
    read: list[tuple[Placed, Parts, Reading]] = []
    for model in placed:
        if world.tag == "world" and not model.element.all("link", "model", "include"):
            if not model.static:  # libsdformat accepts static models without links, and nothing is lost
                message = f"the model '{model.name}' has no <link>: left out"
                reading.notes.warn(model.user, Code.NRP260, message, subject=model.name)
            continue
        own = replace(reading, robot=model.name)
        parts = read_parts(model, own, static=model.static)
        frames.add_model(model.name, model.pose(WORLD, parts.frames), parts.frames, model.user)
        read.append((model, parts, own))
    add_joint_frames(world, frames)
    for frame in world.all("frame"):
        frames.require(frame)
    poses = {model.name: frames.pose(model.name, model.user) for model, _, _ in read}
    kinds = {joint.attribute("name"): joint.attribute("type") for joint in world.all("joint")}
    rows_read = read_world_joints(world, frames, version, reading)
    held = [(name, row, tie_of(row, poses, kinds)) for name, row in rows_read]
    models = []
    for model, parts, own in read:
        pose = poses[model.name]
        inner = [row for name, row, tie in held if name == model.name and tie is None]
        rows = tuple(in_model(row, model.name, pose) for row in inner)
        models.append(build_model(model, replace(parts, rows=parts.rows + rows), model.name, pose, own))
    return models, tuple(tie for _, _, tie in held if tie is not None)


def _step_s(world: Element) -> float | None:
    """Return the time step that the ``<physics>`` of a world asks for, s."""
    step = world.find("physics", "max_step_size")
    return None if step is None else step.numbers(1)[0]


def _gravity(world: Element) -> Vector:
    """Return the gravity of a world; up to SDF 1.5 it is in ``<physics>``."""
    gravity = world.find("gravity") or world.find("physics", "gravity")
    if gravity is None:
        return _GRAVITY
    x, y, z = gravity.numbers(3)
    return x, y, z
