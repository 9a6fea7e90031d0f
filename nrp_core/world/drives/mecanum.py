"""Bases that move in any direction: with four mecanum wheels, or without wheels."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar

from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, ros_topic
from nrp_core.scene.rigid import BodyVelocity
from nrp_core.world.drives.drive import Drive, DrivePart
from nrp_core.world.drives.wheels import wheels_in
from nrp_core.world.engine import Engine


@dataclass(frozen=True, slots=True)
class PlanarMove(Drive):
    """A base without wheels that moves forward and sideways and turns at the velocities of a Twist.

    Its base slides without friction. Its fields are those of
    :class:`~nrp_core.world.drives.wheels.WheelDrive`.
    """

    tag: ClassVar[str] = "planar_move"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "linear.y", "angular.z")

    timeout: float = inf
    rate_hz: float = 20.0
    odometry_topic: str | None = None
    wheel_speeds_topic: None = None

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> PlanarMove:
        timeout = plugin.number("cmdTimeout", -1.0)  # none if it is not above 0
        return cls(
            plugin.attribute("name"),
            ros_topic(plugin, plugin.word("commandTopic", "cmd_vel"), reading),
            timeout=timeout if timeout > 0 else plugin.positive("commandTimeout", inf),
            rate_hz=plugin.number("odometryRate", 0.0) or plugin.positive("publish_rate", 20.0),
            odometry_topic=ros_topic(plugin, plugin.word("odometryTopic", "odom"), reading),
        )

    def part(self, model: Model, engine: Engine) -> PlanarMovePart:
        return PlanarMovePart(self, model, engine)


class PlanarMovePart(DrivePart):
    """Runs one planar base."""

    def _body_velocity(
        self, x: float, y: float, z: float, roll: float, pitch: float, turn: float
    ) -> BodyVelocity:
        return BodyVelocity(x, y, turn)


_CORNERS = ("back_left_joint", "front_left_joint", "back_right_joint", "front_right_joint")


@dataclass(frozen=True, slots=True)
class MecanumDrive(Drive):
    """A base on four mecanum wheels that moves forward and sideways and turns at the velocities of a Twist.

    The rollers are not simulated: the wheels roll without friction and spin as they would with rollers at 45
    degrees that form an X seen from above::

        spin = (forward -/+ left -/+ separation / 2 * turn) / radius    front left, front right
        spin = (forward +/- left -/+ separation / 2 * turn) / radius    back left, back right

    Its fields are those of :class:`~nrp_core.world.drives.wheels.WheelDrive`.

    Args:
        left, right: names of the wheel joints, the back and the front one.
        separation: the distance of left and right wheels plus that of front and back wheels, m: the rollers
            turn the base as if its wheels had this distance.
    """

    tag: ClassVar[str] = "mecanum"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "linear.y", "angular.z")
    joint_fields: ClassVar[tuple[str, ...]] = ("left", "right")

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    wheel_diameter: float
    torque: float = inf
    timeout: float = inf
    rate_hz: float = 50.0
    odometry_topic: str | None = None
    wheel_speeds_topic: None = None

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> MecanumDrive:
        corners = [wheels_in(plugin, (corner,), model)[0] for corner in _CORNERS]
        separation = plugin.positive("wheel_separation", 1.0) + plugin.positive("wheelbase", 1.0)
        command = plugin.word("topic", f"/model/{reading.robot}/cmd_vel")
        odometry = plugin.word("odom_topic", f"/model/{reading.robot}/odometry")
        return cls(
            plugin.attribute("name"),
            ros_topic(plugin, command, reading),
            (corners[0], corners[1]),
            (corners[2], corners[3]),
            separation,
            2 * plugin.positive("wheel_radius", 0.2),
            timeout=plugin.positive("commandTimeout", inf),
            rate_hz=plugin.positive("odom_publish_frequency", 50.0),
            odometry_topic=ros_topic(plugin, odometry, reading),
        )

    def part(self, model: Model, engine: Engine) -> PlanarMovePart:
        return PlanarMovePart(self, model, engine)
