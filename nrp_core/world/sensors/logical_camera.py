"""Logical cameras: which models are in front of them, and where."""

from __future__ import annotations

from dataclasses import dataclass
from math import tan
from typing import ClassVar

from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import PoseWithCovariance
from nrp_core.world.messages.vision_msgs import (
    BoundingBox3D,
    Detection3D,
    Detection3DArray,
    ObjectHypothesis,
    ObjectHypothesisWithPose,
)
from nrp_core.world.pose_messages import pose_message
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import field_of_view, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart


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
