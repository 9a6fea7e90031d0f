"""ROS package geometry_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import message
from nrp_core.messages.std_msgs import Header


@message("geometry_msgs/msg/Vector3")
class Vector3:
    """A vector."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@message("geometry_msgs/msg/Point")
class Point:
    """A position in m."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@message("geometry_msgs/msg/Quaternion")
class Quaternion:
    """An orientation, a unit quaternion."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@message("geometry_msgs/msg/Pose")
class Pose:
    """A position and an orientation."""

    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@message("geometry_msgs/msg/Twist")
class Twist:
    """Linear (m/s) and angular (rad/s) velocity."""

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@message("geometry_msgs/msg/PoseWithCovariance")
class PoseWithCovariance:
    """A pose with the covariance of (x, y, z, roll, pitch, yaw), row by row."""

    pose: Pose = field(default_factory=Pose)
    covariance: tuple[float, ...] = (0.0,) * 36


@message("geometry_msgs/msg/TwistWithCovariance")
class TwistWithCovariance:
    """A twist with its covariance, row by row."""

    twist: Twist = field(default_factory=Twist)
    covariance: tuple[float, ...] = (0.0,) * 36


@message("geometry_msgs/msg/Wrench")
class Wrench:
    """A force (N) and a torque (N m)."""

    force: Vector3 = field(default_factory=Vector3)
    torque: Vector3 = field(default_factory=Vector3)


@message("geometry_msgs/msg/WrenchStamped")
class WrenchStamped:
    """A wrench with the time and frame of its measurement."""

    header: Header = field(default_factory=Header)
    wrench: Wrench = field(default_factory=Wrench)
