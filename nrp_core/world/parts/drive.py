"""Wheel drives: a commanded body velocity, with a time-out, odometry and wheel speeds."""

from __future__ import annotations

from math import isfinite
from typing import Any

from nrp_core.clock import from_seconds
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.gazebo_msgs import WheelSpeeds
from nrp_core.world.messages.geometry_msgs import (
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.parts.base import BodyVelocity, Engine, Part
from nrp_core.world.scene.model import Model, WheelDrive
from nrp_core.world.topics import Direction, TopicInfo


class DrivePart(Part):
    """Serves one :class:`~nrp_core.world.scene.model.WheelDrive`.

    A command holds until the next one or until the time-out; speeds are not clamped.
    """

    def __init__(self, drive: WheelDrive, model: Model, engine: Engine) -> None:
        self._drive, self._model, self._engine = drive, model.name, engine
        self._frame = f"{model.name}/{model.links[0].name}"
        self._home = model.pose.inverse()
        self._timeout_ns = from_seconds(drive.timeout) if isfinite(drive.timeout) else None
        command = TopicInfo(
            drive.command_topic, Twist, Direction.IN, what=f"velocity command of {model.name}"
        )
        topics = [command]
        if drive.odometry_topic is not None:
            what = f"odometry of {model.name}"
            topics.append(TopicInfo(drive.odometry_topic, Odometry, Direction.OUT, drive.rate_hz, what))
        if drive.wheel_speeds_topic is not None:
            what = f"wheel speeds of {model.name}, m/s"
            topics.append(
                TopicInfo(drive.wheel_speeds_topic, WheelSpeeds, Direction.OUT, drive.rate_hz, what)
            )
        self.topics = tuple(topics)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._aim(BodyVelocity(forward=float(message.linear.x), turn=float(message.angular.z)))
        self.deadline_ns = None if self._timeout_ns is None else now_ns + self._timeout_ns

    def at_deadline(self, now_ns: int) -> None:
        self._aim(BodyVelocity())
        self.deadline_ns = None

    def read(self, topic: str, now_ns: int) -> Any:
        return self._odometry(now_ns) if topic == self._drive.odometry_topic else self._wheel_speeds()

    def reset(self) -> None:
        self.deadline_ns = None
        self._aim(BodyVelocity())

    def save(self) -> object:
        return self.deadline_ns, self._velocity

    def restore(self, saved: Any) -> None:
        self.deadline_ns, velocity = saved
        self._aim(velocity)

    _velocity = BodyVelocity()

    def _aim(self, velocity: BodyVelocity) -> None:
        self._velocity = velocity
        self._engine.set_drive(self._model, self._drive.name, velocity)

    def _odometry(self, now_ns: int) -> Odometry:
        motion = self._engine.model_motion(self._model)
        pose, to_body = self._home @ motion.pose, motion.pose.inverse()
        place = Pose(Point(*pose.position), Quaternion(*pose.orientation))
        linear, angular = to_body.rotate(motion.linear), to_body.rotate(motion.angular)
        moving = Twist(Vector3(*linear), Vector3(*angular))
        header = Header(Time.from_ns(now_ns), f"{self._model}/odom")
        return Odometry(header, self._frame, PoseWithCovariance(place), TwistWithCovariance(moving))

    def _wheel_speeds(self) -> WheelSpeeds:
        joints = self._engine.joint_states(self._model)
        speeds = dict(zip(joints.names, joints.velocities * self._drive.wheel_diameter / 2, strict=True))
        left = [float(speeds[name]) for name in self._drive.left]
        right = [float(speeds[name]) for name in self._drive.right]
        return WheelSpeeds(left[0], right[0], left[-1], right[-1])
