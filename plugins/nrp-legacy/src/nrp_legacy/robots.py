"""Robots with special plugins: the iCub's, and drives without a known plugin.

A legged robot had its own walking controller, which was not in its file. Here its body slides as commanded,
without friction, and its legs keep their initial posture. The iCub has two plugins: one holds its joints in a
posture, one takes commands for them.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from typing import Literal

from nrp_core.brain import FloatArray
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.base import resolve_name
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.world import (
    Actuators,
    Joint,
    JointController,
    Link,
    Model,
    ModelParts,
    PairController,
    Pid,
    PlanarMove,
    Plane,
    Scene,
    at_start,
    box_around,
    driven_root,
)

Kind = Literal["position", "velocity"]

POSTURE = {
    f"{side}_{joint}": angle
    for side in "lr"
    for joint, angle in (
        ("shoulder_pitch", -0.52),
        ("shoulder_roll", 0.52),
        ("elbow", 0.785),
        ("wrist_yaw", 0.698),
    )
}
"""Where the robot holds its joints at first, rad; all others at 0."""
_LIMIT = 10.0  # limit of the integral part, N m
_TRUNK, _ARM, _HEAD = Pid(1000, 10, 10, _LIMIT), Pid(100, 10, 10, _LIMIT), Pid(50, 7, 0.1, _LIMIT)
_GAINS: dict[str, dict[Kind, Pid]] = {
    "torso": {"position": _TRUNK, "velocity": Pid(100, 50, 0, _LIMIT)},
    "hip knee ankle": {"position": _TRUNK, "velocity": Pid(500, 20, 0, _LIMIT)},
    "shoulder": {"position": _ARM, "velocity": Pid(500, 2, 0, _LIMIT)},
    "elbow wrist": {"position": _ARM, "velocity": Pid(300, 0.1, 0, _LIMIT)},
    "neck": {"position": _HEAD, "velocity": Pid(50, 50, 0, _LIMIT)},
    "eye": {"position": _HEAD, "velocity": Pid(2, 0.1, 0, _LIMIT)},
}
"""Gains of joints with one of these words in their names, N m for each rad, rad s and rad/s."""
_EYES = ("left_eye_pan", "right_eye_pan")
_PAIRS: tuple[tuple[str, Literal["mean", "difference"]], ...] = (
    ("eye_version", "mean"),
    ("eye_vergence", "difference"),
)
_KINDS: tuple[tuple[Kind, str], ...] = (("position", "pos"), ("velocity", "vel"))


def read_initialization(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read ``icub_initialization``: joints are held, at the positions of a posture or at velocity 0."""
    by_position = plugin.flag("control_method", True)
    kind, end = _KINDS[0 if by_position else 1]
    return Actuators(
        controllers=tuple(
            replace(_controller(joint, kind, end, reading), initial=_posture(joint) if by_position else 0.0)
            for joint in _led(model)
        )
    )


def read_controller(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read ``controller_ros_gazebo_icub``: each joint, and the eyes together, follow commands."""
    if plugin.flag("degree", False):
        message = "<degree> is not supported: joints of the iCub are commanded in radians"
        reading.notes.warn(plugin, Code.NRP383, message, subject="degree")
    controllers = [_controller(joint, kind, end, reading) for joint in _led(model) for kind, end in _KINDS]
    return Actuators(controllers=tuple(controllers), pair_controllers=tuple(_eyes(model, reading)))


def _eyes(model: ModelParts, reading: Reading) -> Iterator[PairController]:
    if not {joint.name for joint in _led(model)}.issuperset(_EYES):
        return
    for kind, end in _KINDS:
        for name, of in _PAIRS:
            yield PairController(name, of, _EYES, kind, _topic(name, end, reading), _gains(name, kind))


def _controller(joint: Joint, kind: Kind, end: str, reading: Reading) -> JointController:
    return JointController(joint.name, kind, _topic(joint.name, end, reading), _gains(joint.name, kind))


def _gains(joint: str, kind: Kind) -> Pid | None:
    """Return the gains of the plugin; None if it sets none, as for fingers."""
    known = (gains[kind] for words, gains in _GAINS.items() if any(word in joint for word in words.split()))
    return next(known, None)


def _led(model: ModelParts) -> Iterator[Joint]:
    """Yield the joints that can be controlled and do not follow another one."""
    return (joint for joint in model.joints if joint.takes_commands and joint.mimic is None)


def _posture(joint: Joint) -> float:
    """Return the initial position of a joint, within its limits."""
    return min(max(POSTURE.get(joint.name, 0.0), joint.lower), joint.upper)


def _topic(joint: str, end: str, reading: Reading) -> str:
    return resolve_name(f"{joint}/{end}", reading.robot)


_DEEP_M = 0.01
"""The depth in the floor from which a robot is lifted: engines push a body apart from it with force."""


def out_of_floor(model: Model, room: Scene) -> Model:
    """Return a robot at a height at which it is not in the floor: the highest surface below its origin."""
    box = _reach(at_start(model))
    if box is None or model.static or any(joint.parent == "world" for joint in model.joints):
        return model
    x, y, z = model.pose.position
    low = float(box[0][2])
    deep = max((top for top in _surfaces(room, x, y) if top <= z + _DEEP_M), default=low) - low
    if deep <= _DEEP_M:
        return model
    message = f"'{model.name}' stands {deep:.2g} m in the floor: it is lifted"
    lifted = Finding(Code.NRP204, message, Level.WARNING, subject=model.name)
    pose = replace(model.pose, position=(x, y, z + deep))
    return replace(model, pose=pose, warnings=(*model.warnings, lifted))


def _surfaces(room: Scene, x: float, y: float) -> Iterator[float]:
    """Yield the heights of the tops of all fixed shapes at a place, m."""
    for model in room.models:
        for link in model.links if model.static else ():
            for each in link.collisions:
                pose = model.pose @ link.pose @ each.pose
                if isinstance(each.geometry, Plane):
                    yield pose.position[2]
                elif (box := box_around([(pose, each.geometry)])) is not None:
                    (left, front, _), (right, back, top) = box
                    if left <= x <= right and front <= y <= back:
                        yield float(top)


def _reach(model: Model) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners of the box around the collisions of a model, m."""
    shapes = ((link.pose @ each.pose, each.geometry) for link in model.links for each in link.collisions)
    return box_around((model.pose @ pose, geometry) for pose, geometry in shapes)


_GRAVITY = 9.8
_COMMANDED = re.compile(
    r"""["']/?(?P<topic>(?:[\w-]+/)*cmd_vel)/?["']\s*,\s*(?:\w+\s*=\s*)?(?:\w+\.)*Twist\b"""
)
"""A topic of velocities with its type, as publishers are made."""


def with_sliding_base(model: Model, sources: Iterable[str], others: Collection[str] = ()) -> Model:
    """Return a robot with a sliding base if it has no drive and some code sends velocities to it.

    Args:
        model: the robot.
        sources: the code of the transfer functions and state machines.
        others: the names of other robots; a command is for the robot that its topic names first.
    """
    topic = _topic_for(model.name, sources, others)
    if topic is None or model.static or model.drives:
        return model
    drive = PlanarMove("sliding_base", topic)
    try:
        driven_root(model, drive, bodies_of(model))
    except SceneError:  # a robot fixed to the world stays there
        return model
    led = {controller.joint for controller in model.controllers}
    led |= {joint for leader in model.leaders for joint in leader.joints}
    gains = _holding_gains(model)
    held = [
        JointController(joint.name, "position", f"/{model.name}/{joint.name}/held_at", gains, _start(joint))
        for joint in model.joints
        if joint.takes_commands and joint.mimic is None and joint.name not in led
    ]
    message = (
        f"'{model.name}' has no drive for '{topic}': its body slides as commanded, and its legs do not walk"
    )
    slides = Finding(Code.NRP265, message, Level.WARNING, subject=model.name)
    return replace(
        model,
        drives=(drive,),
        links=tuple(map(_without_friction, model.links)),
        controllers=(*model.controllers, *held),
        warnings=(*model.warnings, slides),
    )


def _topic_for(name: str, sources: Iterable[str], others: Collection[str]) -> str | None:
    """Return the first topic of velocities for a robot, or None."""
    topics = [found["topic"] for source in sources for found in _COMMANDED.finditer(source)]
    meant = (topic for topic in topics if not others or topic.split("/")[0] == name)
    return next((f"/{topic}" for topic in meant), None)


def _holding_gains(model: Model) -> Pid:
    """Return gains with which the weight of a robot at 1 m from a joint turns that by 0.05 rad."""
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    stiffness = mass * _GRAVITY / 0.05
    return Pid(stiffness, 0.0, stiffness / 10)


def _start(joint: Joint) -> float:
    return min(max(0.0, joint.lower), joint.upper)


def _without_friction(link: Link) -> Link:
    return replace(link, collisions=tuple(replace(each, friction=0.0) for each in link.collisions))
