"""Magnetometers: the magnetic field of the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from nrp_core.world.engine import Engine
from nrp_core.world.messages.generated import required
from nrp_core.world.messages.geometry_msgs import Vector3
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import noise_of, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart


@dataclass(frozen=True, slots=True)
class Magnetometer(Sensor):
    """A sensor of the magnetic field of the world (T) along the axes of its pose."""

    tag: ClassVar[str] = "magnetometer"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose = Pose()

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Magnetometer:
        """Read a magnetometer; the noise along x is used for all axes."""
        name = sensor.attribute("name")
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/magnetic_field"), {}, reading)
        noise = noise_of(sensor.section("magnetometer").section("x"), reading)
        return cls(name, topic, rate_of(sensor, reading), mount.place(sensor), noise=noise)

    @property
    def offset(self) -> Pose:
        return self.pose

    def part(self, model: Model, link: str, engine: Engine) -> MagnetometerPart:
        return MagnetometerPart(self, model.name, link, engine)


class MagnetometerPart(SensorPart):
    """Publishes the measurements of one magnetometer."""

    def __init__(self, sensor: Magnetometer, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._pose, self._message = sensor.pose, required("sensor_msgs/msg/MagneticField")
        self.topics = (self._served(sensor.topic, self._message, f"magnetic field at {model}/{link}, T"),)

    def read(self, topic: str, now_ns: int) -> Any:
        turned = self._engine.link_motion(*self._place).at(self._pose).pose
        felt = turned.rotate_back(self._engine.scene.surroundings.magnetic_field)
        (measured,) = self._noisy(topic, now_ns, felt)
        return self._message(self._header(now_ns), Vector3(*measured))
