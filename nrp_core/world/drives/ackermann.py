"""Cars: driven rear wheels and steered front wheels."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, copysign, dist, inf, tan
from typing import ClassVar

from nrp_core.messages.base import resolve_name
from nrp_core.scene.merged_bodies import bodies_of, joint_inertias, stiff_gains
from nrp_core.scene.model import Cylinder, Model, Sphere
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, plugin_name, ros_topic
from nrp_core.scene.rigid import BodyVelocity, ServoTarget, Vector
from nrp_core.world.drives.drive import Drive
from nrp_core.world.drives.wheels import WheelDrivePart, wheels_in
from nrp_core.world.engine import Engine


@dataclass(frozen=True, slots=True)
class Ackermann(Drive):
    """A car: rear wheels driven by a body velocity, and steered front wheels.

    Args:
        left, right: names of the wheel joints, back to front.
        steering: joints that turn the left and the right front wheel.
        separation: distance of left and right wheels, m.
        wheel_base: distance of front and rear axle, m.
        wheel_diameter: diameter of the wheels, m.
        max_steer: limit of the steering angle, rad.
        max_speed: limit of the speed, m/s.
        steers: whether ``angular.z`` commands the steering angle (as Gazebo's ROS plugin, which steers to the
            other side in reverse) instead of the turn rate.
    """

    tag: ClassVar[str] = "ackermann"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "angular.z")
    joint_fields: ClassVar[tuple[str, ...]] = ("left", "right", "steering")
    servo_fields: ClassVar[tuple[str, ...]] = ("steering",)

    left: tuple[str, ...]
    right: tuple[str, ...]
    steering: tuple[str, str]
    separation: float
    wheel_base: float
    wheel_diameter: float
    max_steer: float = 0.6
    max_speed: float = inf
    steers: bool = False
    torque: float = inf
    timeout: float = inf
    rate_hz: float = 100.0
    odometry_topic: str | None = None
    wheel_speeds_topic: str | None = None

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Ackermann:
        if plugin_name(plugin) == "gazebo_ros_ackermann_drive":
            return cls._read_ros(plugin, model, reading)
        usual = f"/model/{reading.robot}/{plugin.word('sub_topic', 'cmd_vel')}"
        # files may name the front wheels first
        steering = [wheels_in(plugin, (f"{side}_steering_joint",), model)[0] for side in ("left", "right")]
        return cls(
            plugin.attribute("name"),
            resolve_name(plugin.word("topic", usual), reading.robot),
            wheels_in(plugin, ("left_joint",), model)[::-1],
            wheels_in(plugin, ("right_joint",), model)[::-1],
            (steering[0], steering[1]),
            plugin.positive("wheel_separation", 1.0),
            plugin.positive("wheel_base", 1.0),
            2 * plugin.positive("wheel_radius", 0.2),
            plugin.positive("steering_limit", 0.5),
            timeout=plugin.positive("commandTimeout", inf),
            rate_hz=plugin.positive("odom_publish_frequency", 50.0),
            odometry_topic=resolve_name(
                plugin.word("odom_topic", f"/model/{reading.robot}/odometry"), reading.robot
            ),
        )

    @classmethod
    def _read_ros(cls, plugin: Element, model: ModelParts, reading: Reading) -> Ackermann:
        """The car of Gazebo's plugin for ROS 2, which measures the collisions of its wheels."""

        def named(tag: str) -> str:
            by_default = tag  # as in the plugin
            return model.joint(plugin, plugin.word(tag, by_default)).name

        corners = [f"{end}_{side}_joint" for side in ("left", "right") for end in ("rear", "front")]
        wheels = {corner: named(corner) for corner in corners}
        collisions = {corner: _collision_of(wheels[corner], model, plugin) for corner in corners}
        rear_left, front_left, rear_right, front_right = (place for place, _ in collisions.values())
        axles = [
            [(a + b) / 2 for a, b in zip(left, right, strict=True)]
            for left, right in ((rear_left, rear_right), (front_left, front_right))
        ]
        odometry = plugin.flag("publish_odom", False)
        return cls(
            plugin.attribute("name"),
            ros_topic(plugin, "cmd_vel", reading),
            (wheels[corners[0]], wheels[corners[1]]),
            (wheels[corners[2]], wheels[corners[3]]),
            (named("left_steering_joint"), named("right_steering_joint")),
            dist(front_left, front_right),
            dist(*axles),
            2 * collisions["rear_right_joint"][1],
            plugin.positive("max_steer", 0.6),
            plugin.positive("max_speed", 20.0),
            steers=True,
            timeout=plugin.positive("commandTimeout", inf),
            rate_hz=plugin.positive("update_rate", 100.0),
            odometry_topic=ros_topic(plugin, "odom", reading) if odometry else None,
        )

    def part(self, model: Model, engine: Engine) -> AckermannPart:
        return AckermannPart(self, model, engine)


class AckermannPart(WheelDrivePart):
    """Serves one car."""

    steers = True

    def __init__(self, drive: Ackermann, model: Model, engine: Engine) -> None:
        super().__init__(drive, model, engine)
        self._car, self._inertias = drive, joint_inertias(bodies_of(model))

    def _body_velocity(
        self, x: float, y: float, z: float, roll: float, pitch: float, turn: float
    ) -> BodyVelocity:
        return ackermann_velocity(self._car, x, turn)

    def _steer(self, velocity: BodyVelocity) -> None:
        angles = wheel_angles(self._car, velocity.steer)
        for joint, angle in zip(self._car.steering, angles, strict=True):
            gains = stiff_gains(self._inertias[joint])
            self._engine.set_servo_target(self._model, joint, ServoTarget(gains.p, gains.d, position=angle))


def ackermann_velocity(drive: Ackermann, forward: float, turn: float) -> BodyVelocity:
    """Return the velocity of the middle of the rear axle for a command.

    Args:
        drive: the car.
        forward: speed, m/s.
        turn: the steering angle (rad; to the other side in reverse) if the drive ``steers``, else the turn
            rate (rad/s), limited by the steering. A car without speed does not turn.
    """
    forward = min(max(forward, -drive.max_speed), drive.max_speed)
    if drive.steers:
        angle = min(max(copysign(1.0, forward) * turn, -drive.max_steer), drive.max_steer)
    elif forward:
        angle = atan(drive.wheel_base * turn / forward)
        angle = min(max(angle, -drive.max_steer), drive.max_steer)
    else:
        angle = 0.0
    return BodyVelocity(forward, turn=forward * tan(angle) / drive.wheel_base, steer=angle)


def wheel_angles(drive: Ackermann, steer: float) -> tuple[float, float]:
    """Return the angles of the left and right front wheel, such that all axles meet in one point."""
    radius = drive.wheel_base / tan(steer) if steer else inf
    if radius == inf:
        return 0.0, 0.0
    left, right = radius - drive.separation / 2, radius + drive.separation / 2
    return _angle(drive.wheel_base, left, steer), _angle(drive.wheel_base, right, steer)


def _angle(wheel_base: float, radius: float, steer: float) -> float:
    return copysign(atan(wheel_base / abs(radius)), steer) if radius else steer


def _collision_of(name: str, model: ModelParts, plugin: Element) -> tuple[Vector, float]:
    """Return centre (in the model) and radius of the first collision of the wheel on a joint."""
    child = next(joint.child for joint in model.joints if joint.name == name)
    wheel = next(link for link in model.links if link.name == child)
    for collision in wheel.collisions[:1]:
        if isinstance(collision.geometry, Cylinder | Sphere):
            return (wheel.pose @ collision.pose).position, collision.geometry.radius
    raise plugin.error(f"the first collision of the wheel '{child}' must be a cylinder or a sphere")
