"""Drives: a commanded body velocity, with a time-out, odometry and wheel speeds."""

from __future__ import annotations

from math import isfinite
from typing import Any

from nrp_core.clock import from_seconds
from nrp_core.world.drives.steering import ackermann_velocity, wheel_angles
from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.gazebo_msgs import WheelSpeeds
from nrp_core.world.messages.geometry_msgs import (
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
)
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.pose_messages import pose_message, twist_message
from nrp_core.world.rigid.motion import BodyVelocity, JointAim
from nrp_core.world.scene.acting import Ackermann, PlanarDrive, PlanarMove
from nrp_core.world.scene.joint_inertia import joint_inertias, stiff_gains
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Model
from nrp_core.world.topics import Direction, TopicInfo


class DrivePart(Part):
    """Serves one drive of :mod:`nrp_core.world.scene.acting` that moves on the ground.

    A command holds until the next one or until the time-out; speeds are not clamped.
    """

    def __init__(self, drive: PlanarDrive, model: Model, engine: Engine) -> None:
        self._drive, self._model, self._engine = drive, model.name, engine
        self._frame = f"{model.name}/{model.links[0].name}"
        self._home = model.pose.inverse()
        self._inertias = joint_inertias(bodies_of(model)) if isinstance(drive, Ackermann) else {}
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
        self._aim(self._commanded(message))
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

    def _commanded(self, message: Any) -> BodyVelocity:
        forward, turn = float(message.linear.x), float(message.angular.z)
        match self._drive:
            case PlanarMove():
                return BodyVelocity(forward, float(message.linear.y), turn)
            case Ackermann():
                return ackermann_velocity(self._drive, forward, turn)
        return BodyVelocity(forward, 0.0, turn)

    def _aim(self, velocity: BodyVelocity) -> None:
        self._velocity = velocity
        self._engine.set_drive(self._model, self._drive.name, velocity)
        if isinstance(self._drive, Ackermann):
            angles = wheel_angles(self._drive, velocity.steer)
            for joint, angle in zip(self._drive.steering, angles, strict=True):
                gains = stiff_gains(self._inertias[joint])
                self._engine.set_joint_aim(self._model, joint, JointAim(gains.p, gains.d, position=angle))

    def _odometry(self, now_ns: int) -> Odometry:
        motion = self._engine.model_motion(self._model)
        pose, to_body = self._home @ motion.pose, motion.pose.rotate_back
        moving = twist_message(to_body(motion.linear), to_body(motion.angular))
        header = Header(Time.from_ns(now_ns), f"{self._model}/odom")
        place = PoseWithCovariance(pose_message(pose))
        return Odometry(header, self._frame, place, TwistWithCovariance(moving))

    def _wheel_speeds(self) -> WheelSpeeds:
        assert not isinstance(self._drive, PlanarMove)
        joints = self._engine.joint_states(self._model)
        speeds = dict(zip(joints.names, joints.velocities * self._drive.wheel_diameter / 2, strict=True))
        left = [float(speeds[name]) for name in self._drive.left]
        right = [float(speeds[name]) for name in self._drive.right]
        return WheelSpeeds(left[0], right[0], left[-1], right[-1])
