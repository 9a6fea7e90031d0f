"""True poses of links, as Gazebo's ``p3d`` plugin tells them."""

from __future__ import annotations

from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import PoseWithCovariance, TwistWithCovariance
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.pose_messages import pose_message, seen_from, twist_message
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.sensing import GroundTruth
from nrp_core.world.sensors.sensor import SensorPart


class GroundTruthPart(SensorPart):
    """Serves where one link is and how it moves, both in the frame of reference."""

    def __init__(self, sensor: GroundTruth, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor = sensor
        self.topics = (self._served(sensor.topic, Odometry, f"true pose of {model}/{link}"),)

    def read(self, topic: str, now_ns: int) -> Odometry:
        motion = self._engine.link_motion(*self._place).at(self._sensor.pose)
        if self._sensor.reference != "world":
            motion = seen_from(self._engine.model_motion(self._sensor.reference), motion)
        velocities = motion.linear, motion.angular
        if self._sensor.along_link:
            velocities = motion.pose.rotate_back(motion.linear), motion.pose.rotate_back(motion.angular)
        position, linear, angular = self._noisy(topic, now_ns, motion.pose.position, *velocities)
        header = self._header(now_ns)
        header.frame_id = self._sensor.reference
        noisy = ModelMotion(Pose(position, motion.pose.orientation), linear, angular)
        pose, twist = pose_message(noisy.pose), twist_message(noisy.linear, noisy.angular)
        return Odometry(header, self._frame, PoseWithCovariance(pose), TwistWithCovariance(twist))
