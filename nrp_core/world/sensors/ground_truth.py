"""Exact states: poses of links, models in front of a logical camera, and joint states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import tan
from typing import ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.findings import Code
from nrp_core.messages.base import Time, resolve_name
from nrp_core.messages.geometry_msgs import PoseWithCovariance, TwistWithCovariance
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import JointState
from nrp_core.messages.std_msgs import Header
from nrp_core.messages.vision_msgs import (
    BoundingBox3D,
    Detection3D,
    Detection3DArray,
    ObjectHypothesis,
    ObjectHypothesisWithPose,
)
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, plugin_name
from nrp_core.scene.reading.sensors import (
    Mount,
    field_of_view,
    offset_of,
    plugin_sensor,
    rate_of,
    topic_of,
)
from nrp_core.scene.rigid import ModelMotion, Pose, Vector
from nrp_core.world.engine import Engine
from nrp_core.world.model_states import pose_message, relative_motion, twist_message
from nrp_core.world.part import Part
from nrp_core.world.sensors.sensor import Sensor, SensorPart
from nrp_core.world.topics import Direction, TopicInfo


@dataclass(frozen=True, slots=True)
class LogicalCamera(Sensor):
    """Reports the other models whose origins are in its field of view, hidden or not, as Gazebo's does.

    Args:
        near, far: distances along x of its pose, m.
        horizontal_fov: width of its field of view, rad.
        aspect_ratio: width of the field divided by its height.
    """

    tag: ClassVar[str] = "logical_camera"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    near: float = 0.0
    far: float = 1.0
    horizontal_fov: float = 1.0
    aspect_ratio: float = 1.0
    pose: Pose = Pose()

    @property
    def offset(self) -> Pose:
        return self.pose

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> LogicalCamera:
        name, lens = sensor.attribute("name"), sensor.section("logical_camera")
        near, far = lens.number("near", 0.0), lens.positive("far", 1.0)
        fov, ratio = field_of_view(lens, 1.0), lens.positive("aspect_ratio", 1.0)
        if not 0 <= near < far:
            raise lens.error(
                f"the <near> distance ({near:g} m) must be from 0 to below the <far> one ({far:g} m)"
            )
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/logical_camera"), {}, reading)
        return cls(name, topic, rate_of(sensor, reading), near, far, fov, ratio, mount.place(sensor))

    def sees(self, point: Vector) -> bool:
        """Return whether a point, in its frame, is in its field of view."""
        x, y, z = point
        wide = x * tan(self.horizontal_fov / 2)
        return self.near <= x <= self.far and abs(y) <= wide and abs(z) * self.aspect_ratio <= wide

    def part(self, model: Model, link: str, engine: Engine) -> LogicalCameraPart:
        return LogicalCameraPart(self, model.name, link, engine)


class LogicalCameraPart(SensorPart):
    """Publishes the models that one camera sees, in the order of the scene."""

    def __init__(self, sensor: LogicalCamera, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor = sensor
        self.topics = (self._served(sensor.topic, Detection3DArray, f"models seen by {sensor.name}"),)

    def read(self, topic: str, now_ns: int) -> Detection3DArray:
        to_camera = self._engine.link_motion(*self._place).at(self._sensor.pose).pose.inverse()
        others = [model.name for model in self._engine.scene.models if model.name != self._place[0]]
        poses = {name: to_camera @ self._engine.model_motion(name).pose for name in others}
        seen = [
            self._detection(*each, now_ns) for each in poses.items() if self._sensor.sees(each[1].position)
        ]
        return Detection3DArray(self._header(now_ns), seen)

    def _detection(self, name: str, pose: Pose, now_ns: int) -> Detection3D:
        there = pose_message(pose)
        found = ObjectHypothesisWithPose(ObjectHypothesis(name, 1.0), PoseWithCovariance(there))
        return Detection3D(self._header(now_ns), [found], BoundingBox3D(there), name)


class JointStatesPart(Part):
    """Serves the joint states of one model, in the order of its file, then those of joints led in pairs."""

    def __init__(self, model: Model, engine: Engine) -> None:
        assert model.joint_states_topic is not None
        self._model, self._engine = model.name, engine
        self._pairs = list({pair.name: pair for pair in model.pair_controllers}.values())
        what = f"joints of {model.name}"
        self.topics = (TopicInfo(model.joint_states_topic, JointState, Direction.OUT, None, what),)

    def read(self, topic: str, now_ns: int) -> JointState:
        joints = self._engine.joint_states(self._model)
        header = Header(Time.from_ns(now_ns), self._model)
        names = [*joints.names, *(pair.name for pair in self._pairs)]
        efforts = np.append(joints.efforts, np.zeros(len(self._pairs)))
        positions, velocities = (
            self._with_pairs(row, joints.names) for row in (joints.positions, joints.velocities)
        )
        return JointState(header, names, positions, velocities, efforts)

    def _with_pairs(self, row: FloatArray, names: Sequence[str]) -> FloatArray:
        """Return values of joints, and the means and differences of coupled pairs."""
        values = dict(zip(names, row.tolist(), strict=True))
        return np.append(row, [pair.value(*(values[joint] for joint in pair.joints)) for pair in self._pairs])


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
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading, remapped="odom")
        body = plugin.find("body_name") or plugin.require("bodyName")
        link, offset = model.link(body).name, offset_of(plugin)
        frame = (plugin.word("frame_name") or plugin.word("frameName", "world")).strip("/")
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
            motion = relative_motion(self._engine.model_motion(self._sensor.reference), motion)
        velocities = motion.linear, motion.angular
        if self._sensor.along_link:
            velocities = motion.pose.rotate_back(motion.linear), motion.pose.rotate_back(motion.angular)
        position, linear, angular = self._noisy(topic, now_ns, motion.pose.position, *velocities)
        header = self._header(now_ns)
        header.frame_id = self._sensor.reference
        noisy = ModelMotion(Pose(position, motion.pose.orientation), linear, angular)
        pose, twist = pose_message(noisy.pose), twist_message(noisy.linear, noisy.angular)
        variance = tuple((self._sensor.noise.stddev**2 * np.eye(6)).ravel().tolist())
        return Odometry(
            header, self._frame, PoseWithCovariance(pose, variance), TwistWithCovariance(twist, variance)
        )  # fmt: skip
