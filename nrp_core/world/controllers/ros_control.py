"""The controllers of ros_control and ros2_control, from the YAML file that the plugin of a robot names.

ROS 2 names it by ``<parameters>``. In ROS 1 the robot does not name it; here its plugin may name it in the
same way. See https://control.ros.org/rolling/doc/ros2_controllers/doc/controllers_index.html.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import dist, inf
from pathlib import Path
from posixpath import join
from typing import Any, get_args

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.world.controllers.plugins import led_joints
from nrp_core.world.drives.drive import Drive
from nrp_core.world.drives.mecanum import MecanumDrive
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.scene.devices import (
    ControllerKind,
    GroupController,
    JointController,
    Pid,
    TrajectoryController,
)
from nrp_core.world.scene.model import Joint
from nrp_core.world.scene.reading.context import Element, Reading
from nrp_core.world.scene.reading.plugins import Actuators, ModelParts, remapped_topic, ros_namespace
from nrp_core.world.topics import resolve_name

_LEVELS = ("ros__parameters", "controller_manager", "/**")
"""Levels of a file that do not belong to a controller's name."""
_TELLING = ("JointStateController", "JointStateBroadcaster")
_KINDS: dict[str, ControllerKind] = {
    "JointPositionController": "position",
    "JointVelocityController": "velocity",
    "JointEffortController": "effort",
}
_GROUPS: dict[str, ControllerKind] = {
    "JointGroupPositionController": "position",
    "JointGroupVelocityController": "velocity",
    "JointGroupEffortController": "effort",
}
_FORWARD = "ForwardCommandController"
_INTERFACES: dict[str, ControllerKind] = {kind: kind for kind in get_args(ControllerKind)}
Entries = dict[tuple[str, ...], dict[str, Any]]
"""The parameters of a file by the names of their levels."""


def read_ros_control(plugin: Element, model: ModelParts, reading: Reading) -> Actuators | None:
    """Read the controllers of the file that a plugin names: of wheels, joints, groups and trajectories.

    Returns:
        None where the plugin names no file.

    Raises:
        SceneError: the file is not YAML, or names joints that the model does not have.
    """
    place = plugin.find("parameters")
    if place is None or not place.text:
        return None
    path = reading.resources.find(place)
    if path is None:
        reading.notes.warn(
            place,
            Code.NRP265,
            f"the file '{place.text}' does not exist: its controllers are left out",
            subject=place.text,
        )
        return Actuators()
    file = _File(plugin, path, model.joints, reading)
    drives: list[Drive] = []
    single: list[JointController] = []
    several: list[TrajectoryController] = []
    groups: list[GroupController] = []
    for name, entry in file.entries.items():
        kind = str(entry.get("type", "")).rpartition("/")[2]
        if kind == "JointTrajectoryController":
            several.append(file.follower(name))
        elif kind == "DiffDriveController":
            drives.append(file.drive(name))
        elif kind == "MecanumDriveController":
            drives.append(file.mecanum(name))
        elif kind in _KINDS:
            single += file.controller(name, _KINDS[kind])
        elif kind == _FORWARD or kind in _GROUPS:
            groups += file.group(name, _GROUPS.get(kind))
        elif kind and kind not in _TELLING:
            reading.notes.warn(
                place,
                Code.NRP265,
                f"controllers of type '{entry['type']}' are not supported",
                subject=entry["type"],
            )
    return Actuators(tuple(drives), tuple(single), tuple(several), (), tuple(groups))


class _File:
    """A file of controllers.

    Args:
        plugin: the plugin that names the file.
        path: of the file.
        joints: the joints of the model.
        reading: the context of the reading.
    """

    def __init__(self, plugin: Element, path: Path, joints: Sequence[Joint], reading: Reading) -> None:
        self._place = Element("parameters", {}, path, 1, kind=plugin.kind)  # the place for errors
        self._plugin, self._joints, self._reading = plugin, joints, reading
        self._namespace = ros_namespace(plugin).strip("/")  # below the robot
        self.entries: Entries = {}
        self._is_ros2 = False
        self._collect(_read_yaml(path), ())

    def follower(self, name: tuple[str, ...]) -> TrajectoryController:
        """Return the trajectory controller with a name."""
        entry = self.entries[name]
        joints = self._led_joints(entry.get("joints"))
        if not joints:
            raise self._place.error(f"the controller '{'/'.join(name)}' names no joint that it can control")
        gains = tuple((joint, pid) for joint in joints if (pid := self._gains((*name, "gains", joint))))
        command, state = ("joint_trajectory", "controller_state") if self._is_ros2 else ("command", "state")
        (rate_hz,) = self._numbers(name, state_publish_rate=0.0)
        topics = self._topic(name, command), self._topic(name, state)
        return TrajectoryController(name[-1], topics[0], joints, gains, (), topics[1], rate_hz or 50.0)

    def controller(self, name: tuple[str, ...], kind: ControllerKind) -> Iterator[JointController]:
        """Yield the controllers of the single joints of a controller with a name."""
        for joint in self._led_joints([self.entries[name].get("joint")]):
            yield JointController(joint, kind, self._topic(name, "command"), self._gains((*name, "pid")))

    def group(self, name: tuple[str, ...], kind: ControllerKind | None) -> Iterator[GroupController]:
        """Yield the controller of a group of joints with a name, unless it is incomplete.

        Args:
            name: its name.
            kind: what it commands; None: its ``interface_name`` says so.
        """
        entry = self.entries[name]
        kind = kind or _INTERFACES.get(str(entry.get("interface_name")))
        named = [str(joint) for joint in entry.get("joints") or ()]
        joints = self._led_joints(named)
        if kind is None or not joints or list(joints) != named:
            self._leave_out(name, entry, [joint for joint in named if joint not in joints])
            return
        gains = tuple((joint, pid) for joint in joints if (pid := self._gains((*name, joint, "pid"))))
        topic = self._topic(name, "commands" if self._is_ros2 else "command")
        yield GroupController(name[-1], joints, kind, topic, gains)

    def _leave_out(self, name: tuple[str, ...], entry: dict[str, Any], deaf: Sequence[str]) -> None:
        """Warn of a group whose numbers have no place."""
        if deaf:
            why = f"its joints {', '.join(deaf)} take no commands"
        elif not entry.get("joints"):
            why = "it names no joints"
        else:
            given = entry.get("interface_name")
            why = f"its interface_name is {given!r} and not one of {', '.join(_INTERFACES)}"
        message = f"the controller '{'/'.join(name)}' is left out: {why}"
        self._reading.notes.warn(self._place, Code.NRP265, message, subject=name[-1])

    def drive(self, name: tuple[str, ...]) -> WheelDrive:
        """Return the differential drive with a name; ROS 1 has one or more wheel names a side."""
        entry = self.entries[name]
        sides = [entry.get(f"{side}_wheel_names", entry.get(f"{side}_wheel")) for side in ("left", "right")]
        left, right = (self._led_joints([side] if isinstance(side, str) else side) for side in sides)
        if not left or not right:
            raise self._place.error(f"the drive '{'/'.join(name)}' needs wheels on both sides")
        width, radius, wider, larger, timeout, rate_hz = self._numbers(
            name,
            wheel_separation=self._wheel_separation(left[0], right[0]),
            wheel_radius=0.0,
            wheel_separation_multiplier=1.0,
            wheel_radius_multiplier=1.0,
            cmd_vel_timeout=0.5,
            publish_rate=50.0,
        )
        size, separation = 2 * radius * larger, width * wider
        if not size or not separation:
            raise self._place.error(
                f"the drive '{'/'.join(name)}' needs a wheel_separation and a wheel_radius"
            )
        command = self._topic(name, "cmd_vel_unstamped" if self._is_ros2 else "cmd_vel")
        return WheelDrive(
            name[-1], command, left, right, separation, size,
            timeout=timeout or inf, rate_hz=rate_hz or 50.0, odometry_topic=self._topic(name, "odom"),
        )  # fmt: skip

    def mecanum(self, name: tuple[str, ...]) -> MecanumDrive:
        """Return the drive on mecanum wheels with a name."""
        entry = self.entries[name]
        corners = [
            self._led_joints([entry.get(f"{end}_{side}_wheel_command_joint_name")])
            for side in ("left", "right")
            for end in ("rear", "front")
        ]
        sizes = (*name, "kinematics")
        if sizes not in self.entries or not all(corners):
            raise self._place.error(f"the drive '{'/'.join(name)}' needs four wheels and its kinematics")
        radius, reach = self._numbers(
            sizes, wheels_radius=0.0, sum_of_robot_center_projection_on_X_Y_axis=0.0
        )
        if not radius or not reach:
            raise self._place.error(f"the kinematics of '{'/'.join(name)}' need sizes above 0")
        (timeout,) = self._numbers(name, reference_timeout=0.0)
        rear_left, front_left, rear_right, front_right = (corner[0] for corner in corners)
        return MecanumDrive(
            name[-1],
            self._topic(name, "reference_unstamped"),
            (rear_left, front_left),
            (rear_right, front_right),
            2 * reach,
            2 * radius,
            timeout=timeout or inf,
            odometry_topic=self._topic(name, "odometry"),
        )

    def _wheel_separation(self, left: str, right: str) -> float:
        places = {joint.name: joint.pose.position for joint in self._joints}
        return dist(places[left], places[right])

    def _collect(self, level: Mapping[str, Any], name: tuple[str, ...]) -> None:
        """Collect the parameters of a level and its sublevels."""
        entry = self.entries.setdefault(name, {})
        for key, value in level.items():
            self._is_ros2 |= key == "ros__parameters"
            if isinstance(value, dict):
                self._collect(value, name if key in _LEVELS else (*name, str(key)))
            else:
                entry[str(key)] = value

    def _topic(self, name: tuple[str, ...], end: str) -> str:
        """Return the topic of a controller; the file may have the robot's namespace as a level."""
        space, robot = self._namespace, self._reading.robot
        inner = name[1:] if name[0] in (space, robot) and name[1:] else name
        return resolve_name(join(space, remapped_topic(self._plugin, "/".join((*inner, end)))), robot)

    def _gains(self, name: tuple[str, ...]) -> Pid | None:
        if name not in self.entries:
            return None
        p, i, d, limit = self._numbers(name, p=0.0, i=0.0, d=0.0, i_clamp=inf)
        return Pid(p, i, d, limit if limit > 0 else inf)

    def _numbers(self, name: tuple[str, ...], **defaults: float) -> Iterator[float]:
        """Yield parameters that must be numbers of at least 0."""
        for key, default in defaults.items():
            value = self.entries[name].get(key, default)
            if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
                raise self._place.error(
                    f"{key} of '{'/'.join(name)}' must be a number of at least 0, not {value!r}"
                )
            yield float(value)

    def _led_joints(self, names: Any) -> tuple[str, ...]:
        listed = names if isinstance(names, list) else []
        return led_joints(self._place, list(map(str, listed)), self._joints, self._reading)


def _read_yaml(path: Path) -> dict[str, Any]:
    from ruamel.yaml import YAML  # few robots have such a file
    from ruamel.yaml.error import YAMLError

    try:
        tree = YAML(typ="safe").load(path)
    except (YAMLError, UnicodeDecodeError) as error:
        raise SceneError(f"not valid YAML: {' '.join(str(error).split())}", path=path) from None
    if not isinstance(tree, dict):
        raise SceneError("a controller file must be a mapping from names to parameters", path=path)
    return tree
