"""Sensors of the force and torque in a joint."""

from __future__ import annotations

from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import Vector3, WrenchStamped
from nrp_core.world.messages.geometry_msgs import Wrench as WrenchMessage
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.sensing import ForceTorque
from nrp_core.world.sensors.sensor import SensorPart


class ForceTorquePart(SensorPart):
    """Serves what a joint carries, at the origin of its child link."""

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
