"""Controllers that move joints along trajectories, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf

from nrp_core.findings import Code
from nrp_core.world.scene.acting import Pid, TrajectoryController
from nrp_core.world.scene.model import Joint
from nrp_core.world.scene.reading.actuators import Actuators
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import ros_topic
from nrp_core.world.scene.reading.registered import ModelParts, part_named
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import resolve_name


def read_joint_pose_trajectory(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read Gazebo's ``gazebo_ros_joint_pose_trajectory``."""
    topic = ros_topic(plugin, plugin.word("topicName", "set_joint_trajectory"), reading)
    return _alone(TrajectoryController(plugin.attribute("name"), topic, _led(model.joints)))


def read_trajectory_system(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read the ``JointTrajectoryController`` of gz-sim.

    Raises:
        SceneError: it names joints that the model does not have.
    """
    names = [each.text for each in plugin.all("joint_name")]
    chosen = led_joints(plugin, names, model.joints, reading) if names else _led(model.joints)
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
    )
    return _alone(controller)


def _alone(controller: TrajectoryController) -> Actuators:
    return Actuators(trajectory_controllers=(controller,))


def led_joints(
    place: Element, names: Sequence[str], joints: Sequence[Joint], reading: Reading
) -> tuple[str, ...]:
    """Return the named joints that can follow trajectories, with a warning for each of the others.

    Raises:
        SceneError: the model has no joint with a name.
    """
    led = _led(joints)
    for name in names:
        if part_named(place, name, joints, "joint").name not in led:
            reading.notes.warn(
                place,
                Code.NRP265,
                f"the joint '{name}' cannot be controlled: trajectories do not move it",
                subject=name,
            )
    return tuple(name for name in names if name in led)


def _led(joints: Iterable[Joint]) -> tuple[str, ...]:
    return tuple(joint.name for joint in joints if joint.takes_commands and joint.mimic is None)


def _gains(plugin: Element, joints: Sequence[str]) -> tuple[tuple[str, Pid], ...]:
    """Return the gains of gz-sim, whose tags come once for each joint, in the order of the joints.

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
