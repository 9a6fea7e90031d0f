"""True poses of links, as from Gazebo's ``p3d`` plugin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from nrp_core.findings import Code
from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import PoseWithCovariance, TwistWithCovariance
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.pose_messages import pose_message, seen_from, twist_message
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.sensor_elements import offset_of, plugin_sensor
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart
from nrp_core.world.topics import resolve_name


@dataclass(frozen=True, slots=True)
class GroundTruth(Sensor):
    """The true pose and velocity of its link (Gazebo's ``p3d``), in ``reference``, ``world`` or a model.

    Args:
        along_link: whether the velocities are given along the axes of the link.
    """

    tag: ClassVar[str] = "ground_truth"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose = Pose()
    reference: str = "world"
    along_link: bool = False

    @property
    def is_odometry(self) -> bool:
        """Whether it repeats the odometry of a drive on the same topic."""
        return self.along_link

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, GroundTruth]:
        """Read ``gazebo_ros_p3d``, or the odometry of gz-sim."""
        if plugin_name(plugin) == "OdometryPublisher":
            return cls._odometry(plugin, model, reading)
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading)
        link, offset = model.link(plugin.require("bodyName")).name, offset_of(plugin)
        frame = plugin.word("frameName", "world").strip("/")
        if frame not in ("map", "world", "odom"):
            reading.notes.warn(
                plugin, Code.NRP262, f"the true pose is given in the world frame, not in '{frame}'"
            )
        return link, cls(name, topic, rate_hz, offset, noise=noise)

    @classmethod
    def _odometry(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, GroundTruth]:
        link = model.links[0]
        topic = resolve_name(plugin.word("odom_topic", f"/model/{reading.robot}/odometry"), reading.robot)
        rate_hz = plugin.positive("odom_publish_frequency", 50.0)
        name = plugin.attributes.get("name") or "odometry"
        return link.name, cls(name, topic, rate_hz, link.pose.inverse(), along_link=True)

    def part(self, model: Model, link: str, engine: Engine) -> GroundTruthPart:
        return GroundTruthPart(self, model.name, link, engine)


class GroundTruthPart(SensorPart):
    """Publishes pose and velocity of one link in the frame of reference."""

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
