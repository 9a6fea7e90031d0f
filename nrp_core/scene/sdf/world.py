"""Worlds of SDF: their surroundings, their joints, and the states of saved worlds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import atan2, hypot, pi, radians, remainder
from typing import Final

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import (
    Box,
    Capsule,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Joint,
    Mesh,
    Model,
    Scene,
    Sphere,
    Tie,
)
from nrp_core.scene.reading.context import Element, Notes, Reading
from nrp_core.scene.reading.plugins import read_world_drives
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.sdf.appearance import read_light
from nrp_core.scene.sdf.frames import Frames, Placed, read_placed, read_pose
from nrp_core.scene.sdf.joints import add_joint_frames, in_model, read_world_joints, tie_of
from nrp_core.scene.sdf.model import SdfParts, build_model, read_parts
from nrp_core.scene.sdf.source import SdfFile
from nrp_core.scene.stand_in import with_static_shapes
from nrp_core.scene.surroundings import Surroundings

_STRONGEST_T: Final = 1e-3
"""More than ten times the field at the magnetic poles of the Earth (World Magnetic Model)."""
_ORIENTATION, _SURFACE = "ENU", "EARTH_WGS84"


def read_surroundings(world: Element, notes: Notes) -> Surroundings:
    """Read the surroundings of a ``<world>``; other planets and axes cause a warning."""
    usual = Surroundings()
    field, air, earth = (
        world.section(tag) for tag in ("magnetic_field", "atmosphere", "spherical_coordinates")
    )
    x, y, z = field.numbers(3) if field.text else usual.magnetic_field
    for tag, supported in (("world_frame_orientation", _ORIENTATION), ("surface_model", _SURFACE)):
        if earth.word(tag, supported) != supported:
            message = f"the <{tag}> {earth.word(tag)} is not simulated: {supported} is used"
            notes.warn(earth, Code.NRP264, message, subject=tag)
    if hypot(x, y, z) > _STRONGEST_T:
        message = (
            f"the <magnetic_field> has {hypot(x, y, z):g} T, and that of the Earth at most 7e-05 T; "
            "is it meant in uT?"
        )
        notes.warn(field, Code.NRP264, message)
    for tag, most in (("latitude_deg", 90.0), ("longitude_deg", 360.0)):
        if abs(given := earth.number(tag, 0.0)) > most:
            raise earth.require(tag).error(f"<{tag}> must be from {-most:g} to {most:g}, not {given:g}")
    gradient = air.number("temperature_gradient", usual.temperature_gradient)
    if not gradient:
        raise air.error("the <temperature_gradient> must not be 0")
    return Surroundings(
        (x, y, z),
        air.positive("temperature", usual.temperature),
        gradient,
        air.positive("pressure", usual.pressure),
        earth.number("latitude_deg", 0.0),
        earth.number("longitude_deg", 0.0),
        earth.number("elevation", 0.0),
        earth.number("heading_deg", 0.0),
    )


_ROUNDING = 1e-4
"""The largest position (rad, m) of a joint that the rounding of poses in a file explains."""
_AXES = {"axis_state": "", "axis2_state": "_axis2"}
"""The states of the axes of a joint from SDF 1.12, and what follows the name of the joint of each."""


@dataclass(slots=True)
class StateChanges:
    """The changes in the states of a world: poses, positions, and added and removed elements.

    Args:
        poses: the poses of models and lights, by kind and name.
        links: the poses of links in the world, by model and link.
        joints: the positions of joints (rad, m), by model and joint.
        inserted: elements whose children are added.
        deleted: the names of the removed objects.
        named: the models and lights that have a state.
        scales: the factors of the shapes of models.
    """

    poses: dict[tuple[str, str], Pose] = field(default_factory=dict)
    links: dict[str, dict[str, Pose]] = field(default_factory=dict)
    joints: dict[str, dict[str, float]] = field(default_factory=dict)
    inserted: list[Element] = field(default_factory=list)
    deleted: set[str] = field(default_factory=set)
    named: dict[str, Element] = field(default_factory=dict)
    scales: dict[str, Vector] = field(default_factory=dict)

    @classmethod
    def read(cls, states: Iterable[Element], notes: Notes) -> StateChanges:
        """Read the states of a world; SDF 1.12 has ``<model_state>`` where earlier versions have ``<model>``.

        Raises:
            SceneError: a pose or a position is not one.
        """
        result = cls()
        for state in states:
            for thing in _of(state, "model", "light"):
                kind, name = thing.tag.removesuffix("_state"), thing.attribute("name")
                if thing.find("pose") is not None:
                    result.poses[kind, name] = read_pose(thing, WORLD)[0]
                result.named[name] = thing
                if kind == "model" and (scale := thing.section("scale")).text:
                    result.scales[name] = _factors(scale, notes)
                result.links[name] = dict(_links(thing, ""))
                result.joints[name] = dict(_joints(thing, ""))
            result.inserted += state.all("insertions")
            result.deleted |= {
                name.text for deletions in state.all("deletions") for name in deletions.all("name")
            }
        return result

    def warn_of_misspelt(self, names: Iterable[str], notes: Notes) -> None:
        """Report each state of an unknown model whose name is close to that of a model without a state."""
        others = [name for name in names if name not in self.named]
        for name in self.named.keys() - set(names) - self.deleted:
            hint = did_you_mean(name, others)
            if hint.instead is not None:
                message = f"the <state> of '{name}' has no effect: the world has no such model or light{hint}"
                notes.warn(self.named[name], Code.NRP383, message, subject=name)

    def of(self, model: Model) -> Model:
        """Return a model with its last pose, scale and joint positions."""
        scale = self.scales.get(model.name, _UNIT)
        model = model if scale == _UNIT else _scaled(model, scale)
        placed = replace(model, pose=self.poses.get(("model", model.name), model.pose))
        links, positions = self.links.get(model.name, {}), self.joints.get(model.name, {})
        starts = dict(placed.starts)
        for joint in placed.joints:
            if not joint.takes_commands or joint.mimic is not None:
                continue
            position = positions.get(joint.name)
            if position is None:
                position = _between(placed, joint, links)
            if position is not None:
                starts[joint.name] = min(max(position, joint.lower), joint.upper)
        return replace(placed, starts=tuple(starts.items()))


def _of(parent: Element, *kinds: str) -> Iterable[Element]:
    return parent.all(*kinds, *(f"{kind}_state" for kind in kinds))


_UNIT: Vector = (1.0, 1.0, 1.0)


def _factors(scale: Element, notes: Notes) -> Vector:
    x, y, z = scale.numbers(3)
    if min(x, y, z) > 0:
        return x, y, z
    notes.warn(scale, Code.NRP264, f"the <scale> '{scale.text}' is not used: all factors must be above 0")
    return _UNIT


def _scaled(model: Model, scale: Vector) -> Model:
    """Return a model with scaled shapes at unscaled poses, as in Gazebo Classic."""
    links = tuple(
        replace(
            link,
            visuals=tuple(replace(each, geometry=_larger(each.geometry, *scale)) for each in link.visuals),
            collisions=tuple(
                replace(each, geometry=_larger(each.geometry, *scale)) for each in link.collisions
            ),
        )
        for link in model.links
    )
    return replace(model, links=links)


def _larger(geometry: Geometry, x: float, y: float, z: float) -> Geometry:
    """Return a scaled shape; round shapes stay round and planes infinite."""
    match geometry:
        case Box((a, b, c)):
            return Box((a * x, b * y, c * z))
        case Sphere(radius):
            return Sphere(radius * max(x, y, z))
        case Cylinder(radius, length) | Capsule(radius, length):
            return replace(geometry, radius=radius * max(x, y), length=length * z)
        case Mesh(_, (a, b, c)):
            larger = replace(geometry, scale=(a * x, b * y, c * z))
            if isinstance(larger, ConcaveMesh):
                return replace(larger, depth=larger.depth * min(x, y, z))
            return larger
    return geometry


def _links(model: Element, prefix: str) -> Iterator[tuple[str, Pose]]:
    for link in _of(model, "link"):
        if link.find("pose") is not None:
            yield prefix + link.attribute("name"), read_pose(link, WORLD)[0]
    for inner in _of(model, "model"):
        yield from _links(inner, f"{prefix}{inner.attribute('name')}::")


def _joints(model: Element, prefix: str) -> Iterator[tuple[str, float]]:
    for joint in _of(model, "joint"):
        name = prefix + joint.attribute("name")
        for angle in joint.all("angle"):
            suffix = "_axis2" if angle.attributes.get("axis", "0") == "1" else ""
            yield name + suffix, angle.numbers(1)[0]
        for tag, suffix in _AXES.items():
            position = joint.find(tag, "position")
            if position is not None:
                (value,) = position.numbers(1)
                yield name + suffix, radians(value) if position.is_set("degrees") else value
    for inner in _of(model, "model"):
        yield from _joints(inner, f"{prefix}{inner.attribute('name')}::")


def _between(model: Model, joint: Joint, links: Mapping[str, Pose]) -> float | None:
    """Return the position of a joint that is between the poses of two links, None if it cannot be known."""
    at_0 = {link.name: link.pose for link in model.links}
    here, child = model.pose if joint.parent == WORLD else links.get(joint.parent), links.get(joint.child)
    if here is None or child is None:
        return None
    holder = here @ at_0.get(joint.parent, Pose()).inverse() @ joint.pose
    moved = holder.inverse() @ child @ at_0[joint.child].inverse() @ joint.pose
    if joint.kind == "prismatic":
        position = _along(moved.position, joint.axis)
    else:
        *turn, w = moved.orientation
        position = remainder(2 * atan2(_along(turn, joint.axis), w), 2 * pi)
    return position if abs(position) > _ROUNDING else 0.0


def _along(vector: Iterable[float], axis: Vector) -> float:
    return sum(part * share for part, share in zip(vector, axis, strict=True))


_GRAVITY: Vector = (0.0, 0.0, -9.8)


def read_world(world: Element, source: SdfFile, reading: Reading) -> Scene:
    """Read a ``<world>``, or the models and lights of an ``<sdf>`` without one.

    Raises:
        SceneError: an element of it cannot be used.
    """
    drives = read_world_drives(world.all("plugin"), reading)
    state = StateChanges.read(world.all("state"), reading.notes)
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
    return Scene(shaped, tuple(lights), _gravity(world), (), _step_s(world), earth, ties, drives=drives)


_OF_MODELS: Final = (
    "allow_auto_disable", "enable_wind", "frame", "gripper", "joint", "plugin", "pose", "self_collide",
)  # fmt: skip
"""The elements of a <model> beside links and models, which do nothing without these."""


def _models(
    world: Element, placed: Iterable[Placed], version: tuple[int, int], reading: Reading
) -> tuple[list[Model], tuple[Tie, ...]]:
    """Return the models of a world, whose poses may be relative to each other's frames, and their ties."""
    frames = Frames(world, WORLD, WORLD)
    for frame in world.all("frame"):
        attached_to = frame.attributes.get("attached_to") or WORLD
        frames.add(frame, attached_to, attached_to=attached_to)
    read: list[tuple[Placed, SdfParts, Reading]] = []
    for model in placed:
        if world.tag == "world" and not model.element.all("link", "model", "include"):
            if model.static:  # libsdformat accepts it, and nothing is lost if no element is misspelt
                model.element.pass_over(*_OF_MODELS)
            else:
                message = f"the model '{model.name}' has no <link>: left out"
                reading.notes.warn(model.user, Code.NRP260, message, subject=model.name)
                model.element.passed_over = True
            continue
        if reading.lenient and (gone := _missing(model.element, reading)):
            message = f"there is no '{gone}', of which the model '{model.name}' consists: left out"
            reading.notes.warn(model.user, Code.NRP260, message, subject=gone)
            model.element.passed_over = True
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


def _missing(model: Element, reading: Reading) -> str:
    """Return the first include of a model that consists only of missing includes; empty for others."""
    uris = [include.section("uri") for include in model.all("include")]
    if model.all("link", "model") or any(reading.resources.locate(uri) for uri in uris):
        return ""
    return uris[0].text if uris else ""


_OF_SOLVERS: Final = (
    "real_time_factor", "real_time_update_rate", "max_contacts", "magnetic_field", "ode", "bullet", "simbody",
    "dart",
)  # fmt: skip
"""What Gazebo sets for the speed and the solver of its own physics, which nearly all rooms have."""


def _step_s(world: Element) -> float | None:
    """Return the time step that the ``<physics>`` of a world asks for, s."""
    step = _physics(world).find("max_step_size")
    return None if step is None else step.numbers(1)[0]


def _physics(world: Element) -> Element:
    """Return the ``<physics>`` of a world: the first that is the default, or else the first."""
    every = world.all("physics") or [world.section("physics")]
    chosen = next((each for each in every if each.is_set("default")), every[0])
    for physics in every:
        physics.passed_over = physics is not chosen
    chosen.pass_over(*_OF_SOLVERS)
    return chosen


def _gravity(world: Element) -> Vector:
    """Return the gravity of a world; up to SDF 1.5 it is in ``<physics>``."""
    gravity = world.find("gravity") or _physics(world).find("gravity")
    if gravity is None:
        return _GRAVITY
    x, y, z = gravity.numbers(3)
    return x, y, z
