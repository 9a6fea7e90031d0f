"""Barometers: the pressure of the air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from nrp_core.world.engine import Engine
from nrp_core.world.messages.generated import required
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import noise_of, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart


@dataclass(frozen=True, slots=True)
class AirPressure(Sensor):
    """A sensor of the pressure of the air (Pa); ``altitude`` (m) is that of the world's origin."""

    tag: ClassVar[str] = "air_pressure"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose = Pose()
    altitude: float = 0.0

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> AirPressure:
        name, air = sensor.attribute("name"), sensor.section("air_pressure")
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/air_pressure"), {}, reading)
        place, altitude = mount.place(sensor), air.number("reference_altitude", 0.0)
        noise = noise_of(air.section("pressure"), reading)
        return cls(name, topic, rate_of(sensor, reading), place, altitude, noise=noise)

    def part(self, model: Model, link: str, engine: Engine) -> AirPressurePart:
        return AirPressurePart(self, model.name, link, engine)


class AirPressurePart(SensorPart):
    """Publishes the measurements of one barometer; its variance is that of its noise."""

    def __init__(self, sensor: AirPressure, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor, self._message = sensor, required("sensor_msgs/msg/FluidPressure")
        self.topics = (self._served(sensor.topic, self._message, f"air pressure at {model}/{link}, Pa"),)

    def read(self, topic: str, now_ns: int) -> Any:
        height = self._engine.link_motion(*self._place).at(self._sensor.pose).pose.position[2]
        pressure = self._engine.scene.surroundings.pressure_at(self._sensor.altitude + height)
        pressure += float(self._noise(topic, now_ns, ()))
        return self._message(self._header(now_ns), pressure, self._sensor.noise.stddev**2)
