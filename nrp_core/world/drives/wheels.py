"""Wheel drives: differential and skid-steer, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist, inf, isfinite
from typing import Any, ClassVar, Protocol, TypeAlias

import numpy as np

from nrp_core.clock import seconds
from nrp_core.findings import Code
from nrp_core.messages.gazebo_msgs import WheelSpeeds
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.scene.model import Cylinder, Model, Sphere
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, plugin_name, ros_topic
from nrp_core.scene.rigid import BodyVelocity
from nrp_core.world.drives.drive import Drive, DrivePart, GroundDrive
from nrp_core.world.engine import Engine

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
        command, odometry, wheel_speeds: topics; ``{robot}`` represents the name of the robot.
        timeout: ``commandTimeout`` is read for every plugin, though none of Gazebo's has it.
        acceleration: the parameter of the largest acceleration of a wheel; None if the plugin has none.
        has_legacy_mode: whether ``legacyMode`` selects the joints on the left.
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
    acceleration: str | None = None
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
    acceleration="wheelAcceleration",
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
    acceleration="max_wheel_acceleration",
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
class SpeedLimits:
    """Limits of a speed (m/s or rad/s) and of its rate of change, each with its sign."""

    min_velocity: float = -inf
    max_velocity: float = inf
    min_acceleration: float = -inf
    max_acceleration: float = inf

    @property
    def ramps(self) -> bool:
        """Whether the acceleration is limited."""
        return isfinite(self.min_acceleration) or isfinite(self.max_acceleration)

    def clamped(self, speed: float) -> float:
        """Return a speed within the limits."""
        # without min() and max(): a step counts its calls
        raised = self.min_velocity if speed < self.min_velocity else speed
        return self.max_velocity if raised > self.max_velocity else raised

    def toward(self, now: float, wanted: float, dt_s: float) -> float:
        """Return the speed after a time, s, on the way from one speed to another."""
        low, high = now + self.min_acceleration * dt_s, now + self.max_acceleration * dt_s
        return min(max(wanted, low), high)


@dataclass(frozen=True, slots=True)
class WheelDrive(Drive):
    """A differential or skid-steer drive, commanded by a body velocity as a Twist.

    Args:
        name: the name of the plugin.
        command_topic, odometry_topic, wheel_speeds_topic: absolute; None without such a topic.
        left, right: names of the wheel joints, back to front.
        separation: effective distance of left and right wheels, m.
        wheel_diameter: diameter of the wheels, m.
        torque: limit of each wheel, N m.
        timeout: seconds without a command after which the drive stops; ``inf`` for never.
        rate_hz: rate of odometry and wheel speeds, Hz.
        linear, angular: limits of the commanded velocity of the body.
        wheel: limits of the speed of a wheel, m/s.
        pose_variances, twist_variances: the diagonals of the covariances in its odometry; empty for zeros.
    """

    tag: ClassVar[str] = "wheels"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "angular.z")
    joint_fields: ClassVar[tuple[str, ...]] = ("left", "right")

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    wheel_diameter: float
    torque: float = inf
    timeout: float = 0.1
    rate_hz: float = 100.0
    odometry_topic: str | None = None
    wheel_speeds_topic: str | None = None
    linear: SpeedLimits = SpeedLimits()
    angular: SpeedLimits = SpeedLimits()
    wheel: SpeedLimits = SpeedLimits()
    pose_variances: tuple[float, ...] = ()
    twist_variances: tuple[float, ...] = ()

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

        steepest = (plugin.number(dialect.acceleration, 0.0) if dialect.acceleration else 0.0) or inf

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
            linear=_limits_in(plugin, "linear") if dialect is _GZ_SIM else SpeedLimits(),
            angular=_limits_in(plugin, "angular") if dialect is _GZ_SIM else SpeedLimits(),
            wheel=SpeedLimits(min_acceleration=-steepest, max_acceleration=steepest),
            pose_variances=(variances := _variances_in(plugin)),
            twist_variances=variances,
        )

    def part(self, model: Model, engine: Engine) -> WheelDrivePart:
        if self.linear.ramps or self.angular.ramps or self.wheel.ramps:
            return RampedDrivePart(self, model, engine)
        is_plain = self.linear == self.angular == SpeedLimits() and not self.pose_variances
        return (WheelDrivePart if is_plain and not self.twist_variances else LimitedDrivePart)(
            self, model, engine
        )


def _limits_in(plugin: Element, direction: str) -> SpeedLimits:
    """Return the limits of gz-sim: of one direction, or else of both."""

    def limit(end: str, quantity: str, default: float) -> float:
        both = plugin.number(f"{end}_{quantity}", default)
        return plugin.number(f"{end}_{direction}_{quantity}", both)

    return SpeedLimits(
        limit("min", "velocity", -inf),
        limit("max", "velocity", inf),
        limit("min", "acceleration", -inf),
        limit("max", "acceleration", inf),
    )


_VARIANCES = {
    "gazebo_ros_diff_drive": (1e-5, 1e-5, 1e-3),
    "gazebo_ros_skid_steer_drive": (1e-4, 1e-4, 1e-2),
}
"""The variances of x, y and yaw in the odometry of Gazebo's plugins for ROS whose files give none."""
_UNKNOWN_VARIANCE = 1e12
"""What Gazebo's plugins give for directions in which a drive does not move."""


def _variances_in(plugin: Element) -> tuple[float, ...]:
    """Return the variances of Gazebo's plugins for ROS, which a file may set; none for other plugins."""
    usual = _VARIANCES.get(plugin_name(plugin), ())
    tags = "covariance_x", "covariance_y", "covariance_yaw"
    given = [plugin.number(tag, default) for tag, default in zip(tags, usual, strict=False)]
    if not given:
        return ()
    x, y, yaw = given
    return x, y, _UNKNOWN_VARIANCE, _UNKNOWN_VARIANCE, _UNKNOWN_VARIANCE, yaw


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


class LimitedDrivePart(WheelDrivePart):
    """Runs a :class:`WheelDrive`, whose velocity has limits."""

    def __init__(self, drive: WheelDrive, model: Model, engine: Engine) -> None:
        super().__init__(drive, model, engine)
        self._limits = drive
        self._covariances = [
            tuple(np.diag(diagonal).ravel().tolist()) if diagonal else None
            for diagonal in (drive.pose_variances, drive.twist_variances)
        ]

    def _body_velocity(self, *numbers: float) -> BodyVelocity:
        wanted, drive = super()._body_velocity(*numbers), self._limits
        return BodyVelocity(drive.linear.clamped(wanted.forward), 0.0, drive.angular.clamped(wanted.turn))

    def _odometry(self, now_ns: int) -> Odometry:
        message = super()._odometry(now_ns)
        pose, twist = self._covariances
        message.pose.covariance = pose or message.pose.covariance
        message.twist.covariance = twist or message.twist.covariance
        return message


class RampedDrivePart(LimitedDrivePart):
    """Runs one with limited acceleration: each step on the way sets a new velocity."""

    _wanted = _before = BodyVelocity()
    _stop_ns: int | None = None
    _since_ns = -1

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        numbers = message if topic == self._drive.command_topic else self._body_twist(message)
        self._wanted = self._body_velocity(*numbers)
        self._stop_ns = None if self._timeout_ns is None else now_ns + self._timeout_ns
        self._approach(now_ns)

    def at_deadline(self, now_ns: int) -> None:
        if self._stop_ns is not None and now_ns >= self._stop_ns:
            self._wanted, self._stop_ns = BodyVelocity(), None
        self._approach(now_ns)

    def _approach(self, now_ns: int) -> None:
        if now_ns != self._since_ns:  # of several commands at a time, each begins at the same velocity
            self._before, self._since_ns = self._velocity, now_ns
        wanted, step_ns = self._wanted, self._engine.step_ns
        velocity = self._toward(wanted, seconds(step_ns))
        self.set_target_velocity(velocity)
        next_ns = None if velocity == wanted else now_ns + step_ns
        self.deadline_ns = min(filter(None, (next_ns, self._stop_ns)), default=None)

    def _toward(self, wanted: BodyVelocity, dt_s: float) -> BodyVelocity:
        """Return the velocity after a time, s, on the way to one."""
        before, drive = self._before, self._limits
        if drive.wheel.ramps:
            half = drive.separation / 2
            left, right = (
                drive.wheel.toward(
                    before.forward + side * before.turn, wanted.forward + side * wanted.turn, dt_s
                )
                for side in (-half, half)
            )
            wanted = BodyVelocity((left + right) / 2, 0.0, (right - left) / drive.separation)
        forward = drive.linear.toward(before.forward, wanted.forward, dt_s)
        return BodyVelocity(forward, 0.0, drive.angular.toward(before.turn, wanted.turn, dt_s))

    def reset(self) -> None:
        super().reset()
        self._wanted, self._stop_ns, self._since_ns = BodyVelocity(), None, -1

    def save(self) -> object:
        return super().save(), self._wanted, self._stop_ns, self._before, self._since_ns

    def restore(self, saved: Any) -> None:
        inner, self._wanted, self._stop_ns, self._before, self._since_ns = saved
        super().restore(inner)


def wheels_in(plugin: Element, tags: tuple[str, ...], model: ModelParts) -> tuple[str, ...]:
    """Return the wheel joints of one side, named by tags of a plugin."""
    named = [joint for tag in tags for joint in plugin.all(tag)]
    if not named:
        raise plugin.error(f"a drive needs wheels on both sides; there is no <{tags[0]}>")
    return tuple(model.joint(joint).name for joint in named)
