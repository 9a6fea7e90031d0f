"""Wheel drives: differential and skid-steer, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import dist, inf
from typing import ClassVar, Protocol, TypeAlias

from nrp_core.findings import Code
from nrp_core.world.drives.drive import Drive, DrivePart, GroundDrive
from nrp_core.world.engine import Engine
from nrp_core.world.messages.gazebo_msgs import WheelSpeeds
from nrp_core.world.scene.devices import Rename
from nrp_core.world.scene.model import Cylinder, Model, Sphere
from nrp_core.world.scene.reading.context import Element, Reading
from nrp_core.world.scene.reading.plugins import ModelParts, plugin_name, ros_topic

Sides: TypeAlias = tuple[str, ...]
"""Names of the wheel joints on one side, back to front."""


def separation_of(plugin: Element, left: str, right: str, model: ModelParts) -> float:
    """Return the distance of the joints of two wheels, m, as Gazebo's own plugins take it."""
    places = [model.joint(plugin, name).pose.position for name in (left, right)]
    apart = dist(*places)
    if not apart:
        raise plugin.error(f"the wheels of the joints '{left}' and '{right}' are at the same place")
    return apart


def sides_of(
    plugin: Element, left: Sides, right: Sides, model: ModelParts, reading: Reading
) -> tuple[Sides, Sides]:
    """Return the joints on the left and on the right of a drive that Gazebo's plugin for ROS 1 moves.

    The plugin takes its left joint for the right one unless ``legacyMode`` is false, which makes up for files
    that name them the other way round; that was a mistake in its first versions.
    """
    if not plugin.flag("legacyMode", True):
        return left, right
    aside = [model.joint(plugin, side[-1]).pose.position[1] for side in (left, right)]
    if aside[0] < aside[1]:
        return right, left
    if aside[0] > aside[1]:
        message = (
            "Gazebo exchanges the sides of this drive unless <legacyMode> is false, so there the robot turns "
            "against its commands; here it turns as they say"
        )
        reading.notes.warn(plugin, Code.NRP264, message)
    return left, right


def wheel_diameter_of(plugin: Element, joint: str, model: ModelParts) -> float:
    """Return the diameter of the wheel on a joint, m, from its collision shape."""
    wheel = model.joint(plugin, joint).child
    shapes = [each.geometry for link in model.links if link.name == wheel for each in link.collisions]
    round_ones = [2 * shape.radius for shape in shapes if isinstance(shape, Cylinder | Sphere)]
    if not round_ones:
        raise plugin.error(
            f"this plugin takes the size of the wheel '{wheel}' from its collision, which must be a cylinder "
            f"or a sphere"
        )
    return max(round_ones)


Number = tuple[str, float]
"""A parameter and its default."""
Text = tuple[str, str]


@dataclass(frozen=True, slots=True)
class _Dialect:
    """The names of a plugin's parameters, and their defaults.

    Args:
        left, right: the tags that name wheel joints, back to front; a tag may occur several times.
        separation: the parameter; None if the plugin takes it from the places of the joints.
        wheel: of the diameter, or with ``is_radius`` of the radius; None if it is that of a wheel's shape.
        torque: the parameter of a wheel's torque limit; None if the plugin has none.
        command, odometry, wheel_speeds: topics; ``{robot}`` stands for the name of the robot.
        timeout: ``commandTimeout`` is read for every plugin, though none of Gazebo's has it.
        has_legacy_mode: whether ``legacyMode`` says which joints are on the left.
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: Number | None
    wheel: Number | None
    torque: Number | None
    command: Text
    odometry: Text | None
    rate: Number
    timeout: float = inf
    wheel_speeds: Text | None = None
    is_radius: bool = False
    has_legacy_mode: bool = False


_HUSKY = _Dialect(
    left=("backLeftJoint", "frontLeftJoint"),
    right=("backRightJoint", "frontRightJoint"),
    separation=("wheelSeparation", 0.55),
    wheel=("wheelDiameter", 0.30),
    torque=("torque", 15.0),
    command=("commandTopic", "husky/cmd_vel"),
    odometry=("odometryTopic", "odom"),
    rate=("updateRate", 100.0),
    timeout=0.1,
    wheel_speeds=("wheelSpeedsTopic", "husky/wheel_speeds"),
)
_ROS1 = _Dialect(
    left=("leftJoint",),
    right=("rightJoint",),
    separation=("wheelSeparation", 0.34),
    wheel=("wheelDiameter", 0.15),
    torque=("wheelTorque", 5.0),
    command=("commandTopic", "cmd_vel"),
    odometry=("odometryTopic", "odom"),
    rate=("updateRate", 100.0),
    has_legacy_mode=True,
)
_ROS1_SKID_STEER = _Dialect(
    left=("leftRearJoint", "leftFrontJoint"),
    right=("rightRearJoint", "rightFrontJoint"),
    separation=("wheelSeparation", 0.40),
    wheel=("wheelDiameter", 0.15),
    torque=("torque", 5.0),
    command=("commandTopic", "cmd_vel"),
    odometry=("odometryTopic", "odom"),
    rate=("updateRate", 100.0),
)
_ROS2 = _Dialect(
    left=("left_joint",),
    right=("right_joint",),
    separation=("wheel_separation", 0.34),
    wheel=("wheel_diameter", 0.15),
    torque=("max_wheel_torque", 5.0),
    command=("command_topic", "cmd_vel"),
    odometry=("odometry_topic", "odom"),
    rate=("update_rate", 100.0),
)
_GZ_SIM = _Dialect(
    left=("left_joint",),
    right=("right_joint",),
    separation=("wheel_separation", 1.0),
    wheel=("wheel_radius", 0.2),
    torque=None,
    command=("topic", "/model/{robot}/cmd_vel"),
    odometry=("odom_topic", "/model/{robot}/odometry"),
    rate=("odom_publish_frequency", 50.0),
    is_radius=True,
)
_GAZEBO = _Dialect(
    left=("left_joint",),
    right=("right_joint",),
    separation=None,
    wheel=None,
    torque=("torque", 5.0),
    command=("topic", "vel_cmd"),
    odometry=None,
    rate=("updateRate", 100.0),
)

_DIALECTS = {
    "DiffDrivePlugin": (_GAZEBO,),
    "husky_gazebo_plugins": (_HUSKY,),
    "gazebo_ros_diff_drive": (_ROS1, _ROS2),
    "gazebo_ros_skid_steer_drive": (_ROS1_SKID_STEER,),
    "DiffDrive": (_GZ_SIM,),
}


@dataclass(frozen=True, slots=True)
class WheelDrive(Drive):
    """A differential or skid-steer drive, commanded by a body velocity as a Twist.

    Args:
        name: the name of the plugin.
        command_topic, odometry_topic, wheel_speeds_topic: absolute; None where there is none.
        left, right: names of the wheel joints, back to front.
        separation: effective distance of left and right wheels, m.
        wheel_diameter: diameter of the wheels, m.
        torque: limit of each wheel, N m.
        timeout: seconds without a command after which the drive stops; ``inf`` for never.
        rate_hz: rate of odometry and wheel speeds, Hz.
    """

    tag: ClassVar[str] = "wheels"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "angular.z")

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    wheel_diameter: float
    torque: float = inf
    timeout: float = 0.1
    rate_hz: float = 100.0
    odometry_topic: str | None = None
    wheel_speeds_topic: str | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves."""
        return (*self.left, *self.right)

    def renamed(self, named: Rename) -> WheelDrive:
        """Return the same drive for a model whose parts are renamed."""
        left, right = tuple(map(named, self.left)), tuple(map(named, self.right))
        return replace(self, name=named(self.name), left=left, right=right)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> WheelDrive:
        dialects = _DIALECTS[plugin_name(plugin)]
        known = [dialect for dialect in dialects if plugin.all(*dialect.left)]
        if not known:
            raise plugin.error(f"a drive needs wheels; name their joints in <{dialects[0].left[0]}> ...")
        dialect = known[0]
        left, right = wheels_in(plugin, dialect.left, model), wheels_in(plugin, dialect.right, model)
        if dialect.has_legacy_mode:
            left, right = sides_of(plugin, left, right, model, reading)
        size = (
            plugin.positive(*dialect.wheel) if dialect.wheel else wheel_diameter_of(plugin, left[-1], model)
        )

        def topic(parameter: Text) -> str:
            tag, default = parameter
            return ros_topic(plugin, plugin.word(tag, default.format(robot=reading.robot)), reading)

        return cls(
            name=plugin.attribute("name"),
            command_topic=topic(dialect.command),
            left=left,
            right=right,
            separation=plugin.positive(*dialect.separation)
            if dialect.separation
            else separation_of(plugin, left[-1], right[-1], model),
            wheel_diameter=2 * size if dialect.is_radius else size,
            torque=plugin.positive(*dialect.torque) if dialect.torque else inf,
            timeout=plugin.positive("commandTimeout", dialect.timeout),
            rate_hz=plugin.positive(*dialect.rate),
            odometry_topic=topic(dialect.odometry) if dialect.odometry else None,
            wheel_speeds_topic=topic(dialect.wheel_speeds) if dialect.wheel_speeds else None,
        )

    def part(self, model: Model, engine: Engine) -> WheelDrivePart:
        return WheelDrivePart(self, model, engine)


class Wheeled(GroundDrive, Protocol):
    """The fields of drives with wheels."""

    @property
    def left(self) -> tuple[str, ...]:
        """Joints of the left wheels, back to front."""

    @property
    def right(self) -> tuple[str, ...]:
        """Joints of the right wheels, back to front."""

    @property
    def separation(self) -> float:
        """Effective distance of left and right wheels, m."""

    @property
    def wheel_diameter(self) -> float:
        """The diameter of the wheels, m."""


class WheelDrivePart(DrivePart):
    """Runs a drive with wheels; speeds of its wheels command it as well as a velocity of its body."""

    def __init__(self, drive: Wheeled, model: Model, engine: Engine) -> None:
        super().__init__(drive, model, engine)
        self._wheels = drive

    def _body_twist(self, speeds: WheelSpeeds) -> Sequence[float]:
        """Return the numbers of the body's twist for these wheel speeds, averaged over each side."""
        left, right = (
            (speeds.back_left + speeds.front_left) / 2,
            (speeds.back_right + speeds.front_right) / 2,
        )
        turn = (right - left) / self._wheels.separation
        return (left + right) / 2, 0.0, 0.0, 0.0, 0.0, turn

    def _wheel_speeds(self) -> WheelSpeeds:
        joints = self._engine.joint_states(self._model)
        speeds = dict(zip(joints.names, joints.velocities * self._wheels.wheel_diameter / 2, strict=True))
        left = [float(speeds[name]) for name in self._wheels.left]
        right = [float(speeds[name]) for name in self._wheels.right]
        return WheelSpeeds(left[0], right[0], left[-1], right[-1])


def wheels_in(plugin: Element, tags: tuple[str, ...], model: ModelParts) -> tuple[str, ...]:
    """Return the wheel joints of one side, named by tags of a plugin."""
    named = [joint for tag in tags for joint in plugin.all(tag)]
    if not named:
        raise plugin.error(f"a drive needs wheels on both sides; there is no <{tags[0]}>")
    return tuple(model.joint(joint).name for joint in named)
