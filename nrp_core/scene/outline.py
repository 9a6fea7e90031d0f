"""An outline of a scene: its tree of links and joints, sensors, drives and controllers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from itertools import groupby
from math import degrees, isfinite

from nrp_core.scene.consistency import WORLD
from nrp_core.scene.devices import MountedDrive
from nrp_core.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Joint,
    Link,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
)
from nrp_core.scene.rigid import Pose

_SECTIONS = ("actuator", "contact", "equality", "tendon")
"""Elements for an engine that only hold others."""
_TOLD = 3
"""Maximum number of different shapes listed for a link; the others are counted."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A line of an outline with the lines below it."""

    text: str
    entries: tuple[Entry, ...] = ()

    def lines(self) -> Iterator[str]:
        """Yield the lines, with the branches of the tree drawn before them."""
        yield self.text
        for entry in self.entries:
            last = entry is self.entries[-1]
            first, *others = entry.lines()
            yield f"{'└─' if last else '├─'} {first}"
            yield from (f"{'  ' if last else '│ '} {line}" for line in others)


@dataclass(frozen=True, slots=True)
class SceneTopic:
    """A topic that a file declares.

    Args:
        name: absolute.
        commands: whether the model subscribes to it; it publishes on the others.
        of: the sensor, drive or joint that it belongs to.
    """

    name: str
    commands: bool
    of: str


def topics_of(model: Model) -> list[SceneTopic]:
    """Return the topics that a model publishes on and subscribes to, in the order of its file."""
    topics = [
        topic for link in model.links for sensor in link.sensors for topic in _topics(sensor, sensor.name)
    ]
    topics += [topic for drive in model.drives for topic in _topics(drive, drive.name)]
    topics += [SceneTopic(each.topic, True, each.joint) for each in model.controllers]
    topics += [SceneTopic(each.topic, True, each.name) for each in model.pair_controllers]
    topics += [SceneTopic(each.topic, True, each.name) for each in model.group_controllers]
    topics += [topic for each in model.trajectory_controllers for topic in _topics(each, each.name)]
    if model.joint_states_topic is not None:
        topics.append(SceneTopic(model.joint_states_topic, False, "joint states"))
    return topics


def outline(scene: Scene, title: str) -> Entry:
    """Return the outline of a scene."""
    moving = [model for model in scene.models if not model.static]
    static = [model for model in scene.models if model.static]
    lights = [Entry(f"light '{light.name}', {light.kind}") for light in scene.lights]
    x, y, z = scene.gravity
    counts = [_count(len(moving), "model that moves", "models that move")] if moving else []
    counts += [_count(len(static), "model that stands still", "models that stand still")] if static else []
    head = f"{title}: {', '.join(counts) or 'empty'}; gravity {x:g} {y:g} {z:g} m/s²"
    ties = [
        Entry(f"joint {tie.name}, {tie.kind}, holds {'/'.join(tie.child)} to {'/'.join(tie.parent)}")
        for tie in scene.ties
    ]
    entries = [*map(_moving, moving), *map(_static, static), *ties, *lights]
    return Entry(head, tuple(entries))


def _moving(model: Model) -> Entry:
    mass = sum(link.inertial.mass for link in model.links if link.inertial)
    counts = f"{_count(len(model.links), 'link')}, {_count(len(model.joints), 'joint')}"
    held: dict[str, list[Joint]] = {}
    for joint in model.joints:
        held.setdefault(joint.parent, []).append(joint)
    children = {joint.child for joint in model.joints}
    links = {link.name: link for link in model.links}
    roots = [_link(link, held, links) for link in model.links if link.name not in children]
    roots += [_joint(joint, held, links) for joint in held.get(WORLD, ())]
    roots += [
        Entry(f"joint {loop.name}, {loop.kind}, closes a loop of {loop.parent} and {loop.child}")
        for loop in model.loops
    ]
    drives = [_drive(drive, model) for drive in model.drives]
    topics = [
        Entry(f"{'◀' if topic.commands else '▶'} {topic.name} ({topic.of})") for topic in topics_of(model)
    ]
    drives += _for_engines(model)
    below = (*roots, *drives, *([Entry("topics (◀ listens, ▶ serves)", tuple(topics))] if topics else []))
    return Entry(f"{model.name} at {_pose(model.pose)}: {mass:.4g} kg, {counts}", below)


def _drive(drive: MountedDrive, model: Model) -> Entry:
    described = drive.describe(model)
    return Entry(described or f"{_kind(drive)} drive '{drive.name}'")


def _for_engines(model: Model) -> list[Entry]:
    """Return an entry for each engine with elements in the model's file."""
    counts: dict[str, Counter[str]] = {}
    for native in model.native:
        inner = [each.tag for each in native.children] if native.tag in _SECTIONS else [native.tag]
        counts.setdefault(native.namespace, Counter()).update(inner)
    return [
        Entry(f"for {engine}: {', '.join(_count(n, f'<{tag}>', f'<{tag}>') for tag, n in tags.items())}")
        for engine, tags in counts.items()
    ]


def _static(model: Model) -> Entry:
    shapes = [visual.geometry for link in model.links for visual in link.visuals]
    solid = sum(len(link.collisions) for link in model.links)
    shown = _shapes(shapes) or "nothing to see"
    touched = _count(solid, "collision shape") if solid else "nothing to touch"
    return Entry(f"{model.name} at {_pose(model.pose)}: {shown}; {touched}")


def _link(link: Link, held: dict[str, list[Joint]], links: dict[str, Link]) -> Entry:
    mass = f"{link.inertial.mass:.4g} kg" if link.inertial else "no mass"
    shown = _shapes(visual.geometry for visual in link.visuals)
    touched = _shapes(collision.geometry for collision in link.collisions)
    parts = [mass, f"shows {shown}" if shown else "", f"touches with {touched}" if touched else ""]
    sensors = [Entry(f"{_kind(each)} '{each.name}', {each.rate_hz:g} Hz") for each in link.sensors]
    joints = [_joint(joint, held, links) for joint in held.get(link.name, ())]
    return Entry(f"{link.name}: {', '.join(filter(None, parts))}", (*sensors, *joints))


def _joint(joint: Joint, held: dict[str, list[Joint]], links: dict[str, Link]) -> Entry:
    text = f"joint {joint.name}, {joint.kind}"
    if joint.kind not in ("fixed", "ball"):
        text += " about" if joint.kind != "prismatic" else " along"
        text += "".join(f" {round(part, 3) + 0.0:g}" for part in joint.axis)  # -0 is 0
    if isfinite(joint.lower) or isfinite(joint.upper):
        unit = "m" if joint.kind == "prismatic" else "rad"
        text += f", {joint.lower:.3g} to {joint.upper:.3g} {unit}"
    if joint.mimic is not None:
        times = f"{joint.mimic.multiplier:.4g} x " if joint.mimic.multiplier != 1 else ""
        text += f", mimics {times}{joint.mimic.leader}"
    return Entry(text, (_link(links[joint.child], held, links),))


def _topics(owner: object, name: str) -> Iterator[SceneTopic]:
    """Yield the names in the fields of a sensor, drive or controller."""
    for field in fields(owner):  # type: ignore[arg-type]
        value = getattr(owner, field.name)
        if field.name.endswith("topic") and value:
            yield SceneTopic(value, field.name == "command_topic", name)


def _kind(part: object) -> str:
    """Return the kind of a sensor or drive in words: ``ForceTorque`` is a force torque."""
    name = type(part).__name__.removesuffix("Drive").removesuffix("Sensor")
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name).strip()


def _pose(pose: Pose) -> str:
    position = " ".join(f"{part:.3g}" for part in pose.position)
    angles = [round(degrees(angle)) % 360 for angle in pose.rpy]
    if not any(angles):
        return position
    named = zip(("roll", "pitch", "yaw"), angles, strict=True)
    return f"{position} {' '.join(f'{name} {angle}°' for name, angle in named if angle)}"


def _shapes(geometries: Iterable[Geometry]) -> str:
    """Return a text that lists shapes and counts equal ones."""
    words = sorted(map(_shape, geometries))
    counted = [(word, len(list(alike))) for word, alike in groupby(words)]
    listed = [word if count == 1 else f"{count} x {word}" for word, count in counted[:_TOLD]]
    rest = sum(count for _, count in counted[_TOLD:])
    return ", ".join([*listed, f"{rest} more"] if rest else listed)


def _shape(geometry: Geometry) -> str:
    match geometry:
        case Box((x, y, z)):
            return f"box {x:.3g} x {y:.3g} x {z:.3g}"
        case Sphere(radius):
            return f"sphere r {radius:.3g}"
        case Cylinder(radius, length):
            return f"cylinder r {radius:.3g} l {length:.3g}"
        case Capsule(radius, length):
            return f"capsule r {radius:.3g} l {length:.3g}"
        case Plane():
            return "plane"
        case Mesh():
            return "mesh"


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or f'{one}s'}"
