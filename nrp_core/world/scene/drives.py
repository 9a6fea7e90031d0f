"""Wheel drives, from the parameters of Gazebo's plugins."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import dist, inf
from posixpath import join

from nrp_core.errors import did_you_mean
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.acting import Ackermann, Drive, Flight, PlanarMove, WheelDrive
from nrp_core.world.scene.model import Cylinder, Joint, Link, Sphere
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name, ros_topic, vector_in
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import resolve_name

Number = tuple[str, float]
"""A parameter and its default."""
Text = tuple[str, str]


@dataclass(frozen=True, slots=True)
class _Dialect:
    """How a plugin calls its parameters, and their defaults there.

    Args:
        left, right: the tags that name wheel joints, back to front; a tag may come several times.
        wheel: the diameter, or with ``is_radius`` the radius.
        torque: limit of a wheel; None where the plugin has none.
        command, odometry, wheel_speeds: topics; ``{robot}`` stands for the name of the robot.
        timeout: ``commandTimeout`` is read for every plugin, though none of Gazebo's has it.
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: Number
    wheel: Number
    torque: Number | None
    command: Text
    odometry: Text
    rate: Number
    timeout: float = inf
    wheel_speeds: Text | None = None
    is_radius: bool = False


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

_DIALECTS = {
    "husky_gazebo_plugins": (_HUSKY,),
    "gazebo_ros_diff_drive": (_ROS1, _ROS2),
    "gazebo_ros_skid_steer_drive": (_ROS1_SKID_STEER,),
    "DiffDrive": (_GZ_SIM,),
}


def read_drive(
    plugin: Element, links: Sequence[Link], joints: Sequence[Joint], reading: Reading
) -> Drive | None:
    """Read the drive that a ``<plugin>`` of a model stands for; None if it is no drive.

    Args:
        plugin: the element.
        links: of the model.
        joints: of the model.
        reading: what is carried along.

    Raises:
        SceneError: it names no wheels, joints that the model does not have, or wheels that are not round.
    """
    names = [joint.name for joint in joints]
    if plugin_name(plugin) == "gazebo_ros_planar_move":
        return _planar_move(plugin, reading)
    if plugin_name(plugin) in _FLIGHTS:
        return _FLIGHTS[plugin_name(plugin)](plugin, reading)
    if plugin_name(plugin) == "AckermannSteering":
        return _ackermann(plugin, names, reading)
    if plugin_name(plugin) == "gazebo_ros_ackermann_drive":
        return _ros_ackermann(plugin, links, joints, reading)
    dialects = _DIALECTS.get(plugin_name(plugin))
    if dialects is None:
        return None
    known = [dialect for dialect in dialects if plugin.all(*dialect.left)]
    if not known:
        raise plugin.error(f"a drive needs its wheels; name their joints in <{dialects[0].left[0]}> ...")
    return _drive(plugin, known[0], names, reading)


def _drive(plugin: Element, dialect: _Dialect, joints: Collection[str], reading: Reading) -> WheelDrive:
    size = plugin.positive(*dialect.wheel)

    def topic(parameter: Text) -> str:
        tag, default = parameter
        return ros_topic(plugin, plugin.word(tag, default.format(robot=reading.robot)), reading)

    return WheelDrive(
        name=plugin.attribute("name"),
        command_topic=topic(dialect.command),
        left=_wheels(plugin, dialect.left, joints),
        right=_wheels(plugin, dialect.right, joints),
        separation=plugin.positive(*dialect.separation),
        wheel_diameter=2 * size if dialect.is_radius else size,
        torque=plugin.positive(*dialect.torque) if dialect.torque else inf,
        timeout=plugin.positive("commandTimeout", dialect.timeout),
        rate_hz=plugin.positive(*dialect.rate),
        odometry_topic=topic(dialect.odometry),
        wheel_speeds_topic=topic(dialect.wheel_speeds) if dialect.wheel_speeds else None,
    )


def _planar_move(plugin: Element, reading: Reading) -> PlanarMove:
    return PlanarMove(
        plugin.attribute("name"),
        ros_topic(plugin, plugin.word("commandTopic", "cmd_vel"), reading),
        timeout=plugin.positive("commandTimeout", inf),
        rate_hz=plugin.number("odometryRate", 0.0) or plugin.positive("publish_rate", 20.0),
        odometry_topic=ros_topic(plugin, plugin.word("odometryTopic", "odom"), reading),
    )


def _velocity_control(plugin: Element, reading: Reading) -> Flight:
    """The system of gz-sim that lets a body move as it is told."""
    for ignored in plugin.all("link_name"):
        reading.notes.warn(ignored, "the <link_name> of a VelocityControl has no effect: it moves the model")
    first = vector_in(plugin, "initial_linear"), vector_in(plugin, "initial_angular")
    begins = bool(plugin.all("initial_linear", "initial_angular"))
    topic = resolve_name(plugin.word("topic", f"/model/{reading.robot}/cmd_vel"), reading.robot)
    return Flight(plugin.attribute("name"), topic, first if begins else None)


def _multicopter(plugin: Element, reading: Reading) -> Flight:
    """The controller of gz-sim for rotors, which are not simulated: the body flies as they would let it."""
    topic = join("/", plugin.word("robotNamespace"), plugin.word("commandSubTopic", "cmd_vel"))
    return Flight(plugin.attribute("name"), resolve_name(topic, reading.robot))


_FLIGHTS = {"VelocityControl": _velocity_control, "MulticopterVelocityControl": _multicopter}


def _ackermann(plugin: Element, joints: Collection[str], reading: Reading) -> Ackermann:
    """The car of gz-sim; in the files its front wheels may be named first."""
    steering = [_wheels(plugin, (f"{side}_steering_joint",), joints)[0] for side in ("left", "right")]
    return Ackermann(
        plugin.attribute("name"),
        resolve_name(plugin.word("topic", f"/model/{reading.robot}/cmd_vel"), reading.robot),
        _wheels(plugin, ("left_joint",), joints)[::-1],
        _wheels(plugin, ("right_joint",), joints)[::-1],
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


def _ros_ackermann(
    plugin: Element, links: Sequence[Link], joints: Sequence[Joint], reading: Reading
) -> Ackermann:
    """The car of Gazebo's plugin for ROS 2, which takes its measures from the collisions of its wheels."""
    names = [joint.name for joint in joints]

    def named(tag: str) -> str:
        name = plugin.word(tag, tag)  # the plugin's own default is the tag
        if name not in names:
            raise plugin.error(f"the model has no joint '{name}'{did_you_mean(name, names)}")
        return name

    corners = [f"{end}_{side}_joint" for side in ("left", "right") for end in ("rear", "front")]
    wheels = {corner: named(corner) for corner in corners}
    collisions = {corner: _collision_of(wheels[corner], links, joints, plugin) for corner in corners}
    rear_left, front_left, rear_right, front_right = (place for place, _ in collisions.values())
    axles = [
        [(a + b) / 2 for a, b in zip(left, right, strict=True)]
        for left, right in ((rear_left, rear_right), (front_left, front_right))
    ]
    odometry = plugin.word("publish_odom", "false").lower() in ("true", "1")
    return Ackermann(
        plugin.attribute("name"),
        ros_topic(plugin, "cmd_vel", reading),
        (wheels[corners[0]], wheels[corners[1]]),
        (wheels[corners[2]], wheels[corners[3]]),
        (named("left_steering_joint"), named("right_steering_joint")),
        dist(front_left, front_right),
        dist(*axles),
        2 * collisions["rear_right_joint"][1],
        plugin.positive("max_steer", 0.6),
        steers=True,
        timeout=plugin.positive("commandTimeout", inf),
        rate_hz=plugin.positive("update_rate", 100.0),
        odometry_topic=ros_topic(plugin, "odom", reading) if odometry else None,
    )


def _collision_of(
    name: str, links: Sequence[Link], joints: Sequence[Joint], plugin: Element
) -> tuple[Vector, float]:
    """Return centre (in the model) and radius of the first collision of the wheel on a joint."""
    child = next(joint.child for joint in joints if joint.name == name)
    wheel = next(link for link in links if link.name == child)
    for collision in wheel.collisions[:1]:
        if isinstance(collision.geometry, Cylinder | Sphere):
            return (wheel.pose @ collision.pose).position, collision.geometry.radius
    raise plugin.error(f"the first collision of the wheel '{child}' must be a cylinder or a sphere")


def _wheels(plugin: Element, tags: tuple[str, ...], joints: Collection[str]) -> tuple[str, ...]:
    named = [joint for tag in tags for joint in plugin.all(tag)]
    if not named:
        raise plugin.error(f"a drive needs wheels on both sides; there is no <{tags[0]}>")
    for joint in named:
        if joint.text not in joints:
            raise joint.error(f"the model has no joint '{joint.text}'{did_you_mean(joint.text, joints)}")
    return tuple(joint.text for joint in named)
