"""Sensors of the force and torque in a joint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import Vector3, WrenchStamped
from nrp_core.world.messages.geometry_msgs import Wrench as WrenchMessage
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.sensor_elements import plugin_sensor, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart

_TOPICS = {"gazebo_ros_ft_sensor": "topicName"}
_DIRECTIONS = "child_to_parent", "parent_to_child"


@dataclass(frozen=True, slots=True)
class ForceTorque(Sensor):
    """A sensor of the force and torque in a joint; it belongs to the joint's child link.

    Args:
        joint: the name of the joint.
        frame: the frame of the axes: ``child``, ``parent`` or ``sensor``.
        onto_child: whether it is the force of the parent on the child, or the reverse.
    """

    tag: ClassVar[str] = "force_torque"

    needs: ClassVar[tuple[str, ...]] = ("joint_wrenches",)
    on_joint: ClassVar[bool] = True

    joint: str
    frame: str = "child"
    onto_child: bool = False
    pose: Pose = Pose()

    @property
    def measured_joints(self) -> tuple[str, ...]:
        """The joints of its model in which it measures forces."""
        return (self.joint,)

    def renamed(self, named: Callable[[str], str]) -> ForceTorque:
        """Return the same sensor for a model whose links and joints are renamed."""
        return replace(super(ForceTorque, self).renamed(named), joint=named(self.joint))

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> ForceTorque:
        name, section = sensor.attribute("name"), sensor.section("force_torque")
        frame = section.choice("frame", ("child", "parent", "sensor"), "child")
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/forcetorque"), _TOPICS, reading)
        onto_child = section.choice("measure_direction", _DIRECTIONS, _DIRECTIONS[0]) == _DIRECTIONS[1]
        return cls(name, topic, rate_of(sensor, reading), mount.name, frame, onto_child)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, ForceTorque]:
        """Read ``gazebo_ros_ft_sensor``."""
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading)
        joint = model.joint(plugin.require("jointName"))
        return joint.child, cls(name, topic, rate_hz, joint.name, noise=noise)

    def part(self, model: Model, link: str, engine: Engine) -> ForceTorquePart:
        return ForceTorquePart(self, model, link, engine)


class ForceTorquePart(SensorPart):
    """Publishes the wrench in a joint, at the origin of its child link."""

    def __init__(self, sensor: ForceTorque, model: Model, link: str, engine: Engine) -> None:
        super().__init__(sensor, model.name, link, engine)
        self._sensor = sensor
        parent = next(joint.parent for joint in model.joints if joint.name == sensor.joint)
        self._parent = parent if any(each.name == parent for each in model.links) else link
        self.topics = (self._served(sensor.topic, WrenchStamped, f"force and torque in {sensor.joint}"),)

    def read(self, topic: str, now_ns: int) -> WrenchStamped:
        model, link = self._place
        wrench = self._engine.joint_wrench(model, self._sensor.joint)
        along = self._engine.link_motion(model, self._parent if self._sensor.frame == "parent" else link).pose
        if self._sensor.frame == "sensor":
            along = along @ self._sensor.pose
        sign = -1.0 if self._sensor.onto_child else 1.0
        turned = [along.inverse().rotate(vector) for vector in (wrench.force, wrench.torque)]
        force, torque = self._noisy(topic, now_ns, *((sign * x, sign * y, sign * z) for x, y, z in turned))
        return WrenchStamped(self._header(now_ns), WrenchMessage(Vector3(*force), Vector3(*torque)))
