"""Robots commanded by a velocity for which there is no known drive plugin.

A legged robot had its own walking controller, which was not in its file. Here its body slides as commanded,
without friction, and its legs keep their initial posture.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.drive import driven_root
from nrp_core.world.drives.mecanum import PlanarMove
from nrp_core.world.scene.devices import JointController, Pid
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Joint, Link, Model

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
        links=tuple(map(_slippery, model.links)),
        controllers=(*model.controllers, *held),
        warnings=(*model.warnings, slides),
    )


def _topic_for(name: str, sources: Iterable[str], others: Collection[str]) -> str | None:
    """Return the first topic of velocities for a robot; None if there is none."""
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


def _slippery(link: Link) -> Link:
    return replace(link, collisions=tuple(replace(each, friction=0.0) for each in link.collisions))
