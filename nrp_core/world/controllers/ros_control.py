"""The controllers of ros_control and ros2_control, from the YAML file that the plugin of a robot names.

ROS 2 names it by ``<parameters>``. In ROS 1 the robot does not name it; here its plugin may name it in the
same way. See https://control.ros.org/rolling/doc/ros2_controllers/doc/controllers_index.html.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import dist, inf, isfinite
from pathlib import Path
from posixpath import join
from typing import Any, get_args

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.scene.devices import (
    ControllerKind,
    GroupController,
    JointController,
    Pid,
    TrajectoryController,
)
from nrp_core.scene.model import Joint
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import Actuators, ModelParts, remapped_topic, ros_namespace
from nrp_core.world.controllers.plugins import led_joints
from nrp_core.world.drives.mecanum import MecanumDrive
from nrp_core.world.drives.wheels import SpeedLimits, WheelDrive

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

    A fault in the file costs the controllers that it concerns, with a warning.
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
    try:
        file = _File(plugin, path, model.joints, reading)
    except SceneError as error:
        _warn_of_loss(path, error, f"the controllers of '{path.name}' are", path.name, reading)
        return Actuators()
    found = Actuators()
    for name in list(file.entries):
        try:
            found = found.with_others(file.read(name))
        except SceneError as error:
            _warn_of_loss(path, error, f"the controller '{'/'.join(name)}' is", name[-1], reading)
    return found


def _warn_of_loss(path: Path, error: SceneError, lost: str, subject: str, reading: Reading) -> None:
    """Warn that a fault in a file of controllers costs these alone, and not the robot."""
    place = Element("parameters", {}, path, error.line or 1)
    reading.notes.warn(place, Code.NRP265, f"{error.message}: {lost} left out", subject=subject)


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
        self._lines: dict[tuple[str, ...], int] = {}
        self._is_ros2 = False
        self._yaml, tree = _read_yaml(path)
        self._collect(tree, ())

    def read(self, name: tuple[str, ...]) -> Actuators:
        """Read the controller with a name.

        Raises:
            SceneError: it is incomplete, or names joints that the model does not have.
        """
        self._place = replace(self._place, line=self._lines.get(name, 1))
        given = self.entries[name].get("type", "")
        kind = str(given).rpartition("/")[2]
        if kind == "JointTrajectoryController":
            return Actuators(trajectory_controllers=(self.follower(name),))
        if kind in ("DiffDriveController", "MecanumDriveController"):
            return Actuators((self.drive(name) if kind[0] == "D" else self.mecanum(name),))
        if kind in _KINDS:
            return Actuators(controllers=tuple(self.controller(name, _KINDS[kind])))
        if kind == "GripperActionController":
            return Actuators(controllers=tuple(self.controller(name, "position", "gripper_cmd")))
        if kind == _FORWARD or kind in _GROUPS:
            return Actuators(group_controllers=tuple(self.group(name, _GROUPS.get(kind))))
        if kind and kind not in _TELLING:
            message = f"controllers of type '{given}' are not supported"
            self._reading.notes.warn(self._place, Code.NRP265, message, subject=given)
        return Actuators()

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
        return TrajectoryController(
            name[-1], topics[0], joints, gains, (), topics[1], rate_hz or 50.0, holds=True
        )

    def controller(
        self, name: tuple[str, ...], kind: ControllerKind, end: str = "command"
    ) -> Iterator[JointController]:
        """Yield the controllers of single joints of a controller; ``end`` is that of their topic."""
        for joint in self._led_joints([self.entries[name].get("joint")]):
            topic, gains = self._topic(name, end), self._gains((*name, "pid"))
            yield JointController(joint, kind, topic, gains, holds=kind == "position")

    def group(self, name: tuple[str, ...], kind: ControllerKind | None) -> Iterator[GroupController]:
        """Yield the controller of a group of joints with a name, unless it is incomplete.

        Args:
            name: its name.
            kind: the quantity that it commands; None: that of its ``interface_name``.
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
            linear=self._limits(name, "linear", "x"), angular=self._limits(name, "angular", "z"),
            pose_variances=self._diagonal(name, "pose"), twist_variances=self._diagonal(name, "twist"),
        )  # fmt: skip

    def _limits(self, name: tuple[str, ...], *direction: str) -> SpeedLimits:
        """Return the limits of a drive in one direction, unless the file switches them off.

        A lower limit that is missing is the upper one with the other sign.
        """
        level = {
            **self.entries.get((*name, *direction), {}),
            **{
                key.rpartition(".")[2]: value
                for key, value in self.entries[name].items()
                if key.startswith(".".join(direction) + ".")
            },
        }
        if (
            any(level.get(f"{end}_jerk") for end in ("min", "max"))
            and level.get("has_jerk_limits") is not False
        ):
            message = f"the limits of jerk of '{'/'.join(name)}' have no effect"
            self._reading.notes.warn(self._place, Code.NRP383, message, subject=name[-1])
        found: list[float] = []
        for quantity in ("velocity", "acceleration"):
            ends = [level.get(f"{end}_{quantity}") for end in ("min", "max")]
            low, high = (
                float(each) if isinstance(each, int | float) and isfinite(each) else None for each in ends
            )
            if level.get(f"has_{quantity}_limits") is False or high is None:
                high = inf
            found += [-high if low is None or high == inf else low, high]
        return SpeedLimits(*found)

    def _diagonal(self, name: tuple[str, ...], what: str) -> tuple[float, ...]:
        """Return the diagonal of a covariance; none if the file has none."""
        given = self.entries[name].get(f"{what}_covariance_diagonal") or ()
        if given and (len(given) != 6 or not all(isinstance(each, int | float) for each in given)):
            raise self._place.error(f"{what}_covariance_diagonal of '{'/'.join(name)}' must be 6 numbers")
        return tuple(map(float, given))

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

    def _collect(self, level: Any, name: tuple[str, ...]) -> None:
        """Collect the parameters of a level and its sublevels; as in ROS, a level may be there twice."""
        entry = self.entries.setdefault(name, {})
        for key_node, value in level.value:
            key, line = str(key_node.value), key_node.start_mark.line + 1
            self._is_ros2 |= key == "ros__parameters"
            if isinstance(value.value, list) and value.id == "mapping":
                inner = name if key in _LEVELS else (*name, key)
                self._lines.setdefault(inner, line)
                self._collect(value, inner)
            else:
                given = self._yaml.constructor.construct_object(value, deep=True)
                if entry.setdefault(key, given) != given:
                    place, message = replace(self._place, line=line), f"a second '{key}' replaces the first"
                    self._reading.notes.warn(place, Code.NRP264, message, subject=key)
                entry[key] = given

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


def _read_yaml(path: Path) -> tuple[Any, Any]:
    """Return a reader of YAML, and the root node of a file.

    Raises:
        SceneError: it is not YAML, or not a mapping.
    """
    from ruamel.yaml import YAML  # few robots have such a file
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    reader = YAML(typ="safe", pure=True)
    try:
        tree = reader.compose(path)
    except (YAMLError, UnicodeDecodeError) as error:
        mark = error.problem_mark if isinstance(error, MarkedYAMLError) else None
        reason = f"not valid YAML: {(isinstance(error, MarkedYAMLError) and error.problem) or error}"
        raise SceneError(" ".join(reason.split()), path=path, line=mark.line + 1 if mark else 1) from None
    if tree is None or tree.id != "mapping":
        raise SceneError("a controller file must be a mapping from names to parameters", path=path, line=1)
    return reader, tree
