"""Sonars of SDF: the nearest thing in a cone, found by rays."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan
from typing import ClassVar

from nrp_core.findings import Code
from nrp_core.world.engine import Engine
from nrp_core.world.messages.sensor_msgs import Range
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.laser import Laser, LaserPart

_RAYS = 9
"""Rays across the cone, and up and down."""


@dataclass(frozen=True, slots=True)
class Sonar(Laser):
    """Measures along x of its pose; its rays fill the square pyramid around its cone."""

    tag: ClassVar[str] = "sonar"

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Sonar:
        sonar, name = sensor.section("sonar"), sensor.attribute("name")
        low, high = sonar.number("min", 0.0), sonar.positive("max", 1.0)
        if not 0 <= low < high:
            raise sonar.error(f"the <min> range must be from 0 to below <max>, {high:g} m, not {low:g}")
        if sonar.word("geometry", "cone") != "cone":
            shape = sonar.require("geometry")
            message = f"a sonar measures in a cone here, not in a '{shape.text}'"
            reading.notes.warn(shape, Code.NRP262, message)
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/sonar"), {}, reading)
        half = atan(sonar.positive("radius", 0.5) / high)
        return cls(
            name, topic, rate_of(sensor, reading), _RAYS, -half, half, low, high, mount.place(sensor),
            _RAYS, -half, half, range_topic=topic, cone=2 * half,
        )  # fmt: skip

    def part(self, model: Model, link: str, engine: Engine) -> SonarPart:
        return SonarPart(self, model.name, link, engine)


class SonarPart(LaserPart):
    """Publishes the distance of one sonar."""

    def __init__(self, sonar: Sonar, model: str, link: str, engine: Engine) -> None:
        super().__init__(sonar, model, link, engine)
        self.topics = (self._served(sonar.topic, Range, f"nearest thing to {sonar.name}"),)
