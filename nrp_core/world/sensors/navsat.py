"""Satellite navigation (GPS): the place on the Earth."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from nrp_core.findings import Code
from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.generated import required
from nrp_core.world.messages.geometry_msgs import Vector3
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.digest import LATER
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.sensor_elements import (
    noise_of,
    offset_of,
    plugin_sensor,
    rate_of,
    topic_in_namespace,
    topic_of,
)
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart

_OF_HECTOR = ("referenceLatitude", "referenceLongitude", "referenceAltitude", "referenceHeading")
_FIX, _GPS = 0, 1
"""``STATUS_FIX`` and ``SERVICE_GPS`` of ``sensor_msgs/NavSatStatus``."""
_DIAGONAL_KNOWN = 2
"""``COVARIANCE_TYPE_DIAGONAL_KNOWN`` of ``sensor_msgs/NavSatFix``."""


@dataclass(frozen=True, slots=True)
class NavSat(Sensor):
    """A receiver of satellite navigation; its noise is in m, in all directions.

    Args:
        pose: where it is on its link.
        velocity_topic: the topic of its velocity in the world (m/s), which has no noise; empty for none.
    """

    tag: ClassVar[str] = "navsat"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose = Pose()
    velocity_topic: str = field(default="", metadata=LATER)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> NavSat:
        """Read a receiver; the horizontal noise of positions is used for all directions."""
        name = sensor.attribute("name")
        section = sensor.section("navsat" if sensor.find("navsat") else "gps")
        noise = noise_of(section.section("position_sensing").section("horizontal"), reading)
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/navsat"), {}, reading)
        return cls(name, topic, rate_of(sensor, reading), mount.place(sensor), noise=noise)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, NavSat]:
        """Read ``hector_gazebo_ros_gps``; places on the Earth are those of the world."""
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading, "fix")
        if ignored := plugin.all(*_OF_HECTOR):
            tags, verb = " and ".join(f"<{each.tag}>" for each in ignored), "are" if ignored[1:] else "is"
            message = f"{tags} {verb} not used: the world's <spherical_coordinates> say where it is"
            reading.notes.warn(ignored[0], Code.NRP263, message, subject=ignored[0].tag)
        link = model.link(plugin.require("bodyName")).name
        velocity = topic_in_namespace(plugin, plugin.word("velocityTopicName", "fix_velocity"), reading)
        return link, cls(name, topic, rate_hz, offset_of(plugin), velocity, noise=noise)

    def part(self, model: Model, link: str, engine: Engine) -> NavSatPart:
        return NavSatPart(self, model.name, link, engine)


class NavSatPart(SensorPart):
    """Publishes the fixes of one receiver."""

    def __init__(self, sensor: NavSat, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._pose, self._variance = sensor.pose, sensor.noise.stddev**2
        self._message = required("sensor_msgs/msg/NavSatFix")
        self._status = required("sensor_msgs/msg/NavSatStatus")(_FIX, _GPS)
        self._vector, self._velocity_topic = (
            required("geometry_msgs/msg/Vector3Stamped"),
            sensor.velocity_topic,
        )
        self.topics = (self._served(sensor.topic, self._message, f"place of {model}/{link} on the Earth"),)
        if sensor.velocity_topic:
            what = f"velocity of {model}/{link} in the world"
            self.topics += (self._served(sensor.velocity_topic, self._vector, what),)

    def read(self, topic: str, now_ns: int) -> Any:
        motion = self._engine.link_motion(*self._place).at(self._pose)
        if topic == self._velocity_topic:
            return self._vector(Header(Time.from_ns(now_ns), WORLD), Vector3(*motion.linear))
        position = motion.pose.position
        (measured,) = self._noisy(topic, now_ns, position)
        place = self._engine.scene.surroundings.on_earth(measured)
        covariance = (np.eye(3) * self._variance).ravel()
        return self._message(self._header(now_ns), self._status, *place, covariance, _DIAGONAL_KNOWN)
