"""Joint controllers, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from math import inf
from typing import Literal

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.acting import JointController, Pid
from nrp_core.world.scene.checks import SECOND_AXIS
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import resolve_name

Kind = Literal["position", "velocity", "effort"]

TOPICS: dict[Kind, str] = {"position": "cmd_pos", "velocity": "cmd_vel", "effort": "cmd_effort"}
"""What is appended to ``/<model>/<joint>`` for the topic of a controller."""

_SYSTEMS: dict[str, tuple[Kind, str]] = {
    "JointPositionController": ("position", "{index}/cmd_pos"),
    "JointController": ("velocity", "cmd_vel"),
    "ApplyJointForce": ("effort", "cmd_force"),
}


def read_controllers(
    plugin: Element, joints: Collection[str], reading: Reading
) -> list[JointController] | None:
    """Read the controllers that a ``<plugin>`` of a model stands for; None if it is of another kind.

    Raises:
        SceneError: it names joints that the model does not have.
    """
    name = plugin_name(plugin)
    if name == "generic_controller_plugin":
        return list(_generic(plugin, joints, reading))
    if name in _SYSTEMS:
        return [_system(plugin, *_SYSTEMS[name], joints, reading)]
    return None


def _generic(plugin: Element, joints: Collection[str], reading: Reading) -> Iterator[JointController]:
    """Read that of the Neurorobotics Platform: ``<controller joint_name=""><type/><pid/></controller>``."""
    for each in plugin.all("controller"):
        joint = _joint(each, each.attribute("joint_name"), joints)
        kind = _kind(each, each.word("type", "position"))
        gains = each.find("pid")
        pid = Pid(*gains.numbers(3)) if gains else None
        topic = each.word("topic", reading.topic_of(joint, TOPICS[kind]))
        yield JointController(joint, kind, resolve_name(topic, reading.robot), pid)


def _system(
    plugin: Element, kind: Kind, topic: str, joints: Collection[str], reading: Reading
) -> JointController:
    named = plugin.require("joint_name")
    index = int(plugin.number("joint_index", 0))
    joint = _joint(named, named.text + (SECOND_AXIS if index == 1 else ""), joints)
    gains: Pid | None = Pid()
    if kind == "position":
        limit = plugin.number("i_max", 1.0)
        p, i, d = (
            plugin.number(f"{gain}_gain", value) for gain, value in (("p", 1.0), ("i", 0.1), ("d", 0.01))
        )
        gains = Pid(p, i, d, limit if limit >= 0 else inf)
    elif kind == "velocity":
        gains = Pid(plugin.number("p_gain", 1.0), plugin.number("i_gain", 0.0)) if _forces(plugin) else None
    name = plugin.word("topic", f"/model/{reading.robot}/joint/{named.text}/{topic.format(index=index)}")
    initial = plugin.find("initial_position") or plugin.find("initial_velocity")
    start = initial.numbers(1)[0] if initial else (0.0 if kind == "position" else None)
    return JointController(joint, kind, resolve_name(name, reading.robot), gains, start)


def _forces(plugin: Element) -> bool:
    return plugin.flag("use_force_commands", False)


def _joint(element: Element, name: str, joints: Collection[str]) -> str:
    if name not in joints:
        raise element.error(f"the model has no joint '{name}'{did_you_mean(name, joints)}")
    return name


def _kind(element: Element, kind: str) -> Kind:
    for known in TOPICS:
        if kind.lower() == known:
            return known
    raise element.error(f"a controller is of type {', '.join(TOPICS)}, not '{kind}'")
