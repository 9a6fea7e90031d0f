"""Altimeters: the height above the start, and its rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from nrp_core.findings import Code
from nrp_core.world.engine import Engine
from nrp_core.world.messages.ros_gz_interfaces import Altimeter as Altitude
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import noise_of, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart


@dataclass(frozen=True, slots=True)
class Altimeter(Sensor):
    """Measures the height of its pose above where the model's file puts it; its noise is on the height, m."""

    tag: ClassVar[str] = "altimeter"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose = Pose()

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Altimeter:
        name, section = sensor.attribute("name"), sensor.section("altimeter")
        velocity = section.section("vertical_velocity")
        if noise_of(velocity, reading):
            message = "the <noise> of the <vertical_velocity> of altimeters is not simulated"
            reading.notes.warn(velocity, Code.NRP262, message, subject=name)
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/altimeter"), {}, reading)
        noise = noise_of(section.section("vertical_position"), reading)
        return cls(name, topic, rate_of(sensor, reading), mount.place(sensor), noise=noise)

    def part(self, model: Model, link: str, engine: Engine) -> AltimeterPart:
        return AltimeterPart(self, model, link, engine)


class AltimeterPart(SensorPart):
    """Publishes the heights of one altimeter."""

    def __init__(self, sensor: Altimeter, model: Model, link: str, engine: Engine) -> None:
        super().__init__(sensor, model.name, link, engine)
        self._pose = sensor.pose
        self._reference = (model.pose @ model.link(link).pose @ sensor.pose).position[2]
        self.topics = (self._served(sensor.topic, Altitude, f"height of {model.name}/{link}, m"),)

    def read(self, topic: str, now_ns: int) -> Altitude:
        motion = self._engine.link_motion(*self._place).at(self._pose)
        height = motion.pose.position[2] - self._reference + float(self._noise(topic, now_ns, ()))
        return Altitude(self._header(now_ns), height, motion.linear[2], self._reference)
