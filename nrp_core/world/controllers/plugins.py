"""Controllers of joints and trajectories, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf

from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.scene.consistency import SECOND_AXIS
from nrp_core.scene.devices import ControllerKind, JointController, Pid, TrajectoryController
from nrp_core.scene.model import Joint
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import (
    Actuators,
    ModelParts,
    name_of_file,
    part_named,
    plugin_name,
    ros_topic,
)


def read_joint_pose_trajectory(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read Gazebo's ``gazebo_ros_joint_pose_trajectory``."""
    topic = ros_topic(plugin, plugin.word("topicName", "set_joint_trajectory"), reading)
    controller = TrajectoryController(plugin.attribute("name"), topic, _led_joints(model.joints))
    return Actuators(trajectory_controllers=(controller,))


def read_trajectory_system(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read the ``JointTrajectoryController`` of gz-sim.

    Raises:
        SceneError: it names joints that the model does not have.
    """
    names = [each.text for each in plugin.all("joint_name")]
    chosen = led_joints(plugin, names, model.joints, reading) if names else _led_joints(model.joints)
    command, state = (
        plugin.word("topic", f"/model/{reading.robot}/joint_trajectory"),
        plugin.word("state_topic"),
    )
    controller = TrajectoryController(
        plugin.attribute("name"),
        resolve_name(command, reading.robot),
        chosen,
        _gains(plugin, chosen),
        tuple(zip(chosen, _values(plugin, "initial_position"), strict=False)),
        resolve_name(state, reading.robot) if state else None,
        holds=True,
    )
    return Actuators(trajectory_controllers=(controller,))


def led_joints(
    place: Element, names: Sequence[str], joints: Sequence[Joint], reading: Reading
) -> tuple[str, ...]:
    """Return the named joints that can follow trajectories, with a warning for each of the others.

    Raises:
        SceneError: the model has no joint with a name.
    """
    led = _led_joints(joints)
    for name in names:
        if part_named(place, name, joints, "joint").name not in led:
            reading.notes.warn(
                place,
                Code.NRP265,
                f"the joint '{name}' cannot be controlled: trajectories do not move it",
                subject=name,
                alike="no trajectory",
            )
    return tuple(name for name in names if name in led)


def _led_joints(joints: Iterable[Joint]) -> tuple[str, ...]:
    return tuple(joint.name for joint in joints if joint.takes_commands and joint.mimic is None)


def _gains(plugin: Element, joints: Sequence[str]) -> tuple[tuple[str, Pid], ...]:
    """Return the gains of gz-sim, whose tags are repeated for each joint, in the order of the joints.

    It has a controller of the position and one of the velocity. The integral part of the velocity controller
    is the proportional part of the position controller, so both are one controller.
    """
    tags = ("position_p", "position_i", "position_d", "velocity_p", "velocity_i")
    columns = [_values(plugin, f"{tag}_gain") for tag in tags] + [_values(plugin, "position_i_max")]
    if not any(columns):
        return ()
    padded = [[*column, *[0.0] * len(joints)][: len(joints)] for column in columns]
    return tuple(
        (joint, Pid(p + vi, i, d + vp, limit if limit > 0 else inf))
        for joint, p, i, d, vp, vi, limit in zip(joints, *padded, strict=True)
    )


def _values(plugin: Element, tag: str) -> list[float]:
    return [each.numbers(1)[0] for each in plugin.all(tag)]


TOPICS: dict[ControllerKind, str] = {"position": "cmd_pos", "velocity": "cmd_vel", "effort": "cmd_effort"}
"""Suffixes of ``/<model>/<joint>`` for the topics of controllers."""

_GAINS = "p_gain", "i_gain", "d_gain"

_DEFAULT_OUTPUT = 1000.0
"""Limit of the output of a controller of gz-sim without one of its own, N or N m."""

RANGE = "command_range"
"""The element with the minimum and maximum of commands of MJCF, also beyond the limits of joints."""

_SYSTEMS: dict[str, tuple[ControllerKind, str]] = {
    "JointPositionController": ("position", "{index}/cmd_pos"),
    "JointController": ("velocity", "cmd_vel"),
    "ApplyJointForce": ("effort", "cmd_force"),
}


def read_generic(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read ``generic_controller_plugin`` of the Neurorobotics Platform.

    It has ``<controller joint_name=""><type/><pid/></controller>`` for each controller.

    Raises:
        SceneError: it names joints that the model does not have.
    """
    controllers = []
    for each in plugin.all("controller"):
        joint = model.joint(each, each.attribute("joint_name")).name
        kind = _kind(each, each.word("type", "position"))
        gains = each.find("pid")
        pid = Pid(*gains.numbers(3)) if gains else None
        topic = each.word("topic", reading.topic_of(joint, TOPICS[kind]))
        controllers.append(JointController(joint, kind, resolve_name(topic, reading.robot), pid))
    return Actuators(controllers=tuple(controllers))


def read_system(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read one of the systems of gz-sim.

    Raises:
        SceneError: it names a joint that the model does not have.
    """
    kind, topic = _SYSTEMS[plugin_name(plugin)]
    named = plugin.require("joint_name")
    other = name_of_file(plugin)
    if other in _SYSTEMS and _SYSTEMS[other][0] != kind:
        message = f"a plugin of the file of {other} has the name of {plugin_name(plugin)}, which is used"
        reading.notes.warn(plugin, Code.NRP265, message, subject=named.text)
    index = int(plugin.number("joint_index", 0))
    joint = model.joint(named, named.text + (SECOND_AXIS if index == 1 else "")).name
    _warn_of_gains(plugin, joint, reading)
    gains: Pid | None = Pid()
    if kind == "position":
        limit = plugin.number("i_max", 1.0)
        p, i, d = (
            plugin.number(f"{gain}_gain", value) for gain, value in (("p", 1.0), ("i", 0.1), ("d", 0.01))
        )
        gains = Pid(p, i, d, limit if limit >= 0 else inf)
    elif kind == "velocity":
        forces = plugin.flag("use_force_commands", False)
        gains = Pid(plugin.number("p_gain", 1.0), plugin.number("i_gain", 0.0)) if forces else None
    if kind != "effort" and gains is not None:
        _warn_of_output(plugin, model.joint(named, joint), reading)
    name = _topic(plugin, named.text, topic.format(index=index), reading)
    initial = plugin.find("initial_position") or plugin.find("initial_velocity")
    start = initial.numbers(1)[0] if initial else (0.0 if kind == "position" else None)
    limits = plugin.find(RANGE)
    lower, upper = limits.numbers(2, finite=False) if limits else (-inf, inf)
    topic = resolve_name(name, reading.robot)
    beyond = kind == "position" and limits is not None
    controller = JointController(joint, kind, topic, gains, start, range=(lower, upper), beyond=beyond)
    return Actuators(controllers=(controller,))


def _topic(plugin: Element, joint: str, name: str, reading: Reading) -> str:
    """Return the topic of a system of gz-sim.

    One with the numbers of several actuators, which Gazebo has for autopilots, is not one of numbers.
    """
    space = f"/model/{reading.robot}"
    own, below = f"{space}/joint/{joint}/{name}", plugin.word("sub_topic")
    found = plugin.word("topic", f"{space}/{below}" if below else own)
    if plugin.flag("use_actuator_msg", False):
        message = (
            f"messages for several actuators are not supported: the joint '{joint}' takes numbers on {own}"
        )
        reading.notes.warn(plugin, Code.NRP265, message, subject=joint)
        return own
    return found


def _warn_of_gains(plugin: Element, joint: str, reading: Reading) -> None:
    """Warn of gains that push a joint away from its target."""
    for gain in plugin.all(*_GAINS):
        if gain.numbers(1)[0] < 0:
            message = f"the <{gain.tag}> of '{joint}' is negative: it drives the joint away from its target"
            reading.notes.warn(gain, Code.NRP265, message, subject=joint)


def _warn_of_output(plugin: Element, joint: Joint, reading: Reading) -> None:
    """Warn of limits of a controller's output; only the effort of its joint limits it."""
    low, high = plugin.number("cmd_min", -inf), plugin.number("cmd_max", inf)
    if low > high:
        shown = f"the <cmd_min> of '{joint.name}', {low:g}, is above its <cmd_max>, {high:g}"
    elif min(-low, high) < min(joint.effort, _DEFAULT_OUTPUT):
        shown = f"the controller of '{joint.name}' is not limited to <cmd_min> {low:g} and <cmd_max> {high:g}"
    else:
        return
    message = f"{shown}: only the effort of the joint, {joint.effort:g}, limits it"
    reading.notes.warn(plugin, Code.NRP383, message, subject=joint.name)


def _kind(element: Element, kind: str) -> ControllerKind:
    for known in TOPICS:
        if kind.lower() == known:
            return known
    raise element.error(f"a controller is of type {', '.join(TOPICS)}, not '{kind}'")
