"""Sensors of navigation: IMU, magnetometer, barometer, altimeter and satellite navigation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from nrp_core.findings import Code
from nrp_core.messages.base import Time
from nrp_core.messages.generated import required
from nrp_core.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.messages.ros_gz_interfaces import Altimeter as Altitude
from nrp_core.messages.sensor_msgs import Imu as ImuMessage
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.devices import LATER, Noise
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, plugin_name
from nrp_core.scene.reading.sensors import (
    Mount,
    noise_of,
    offset_of,
    plugin_sensor,
    rate_of,
    topic_in_namespace,
    topic_of,
)
from nrp_core.scene.rigid import ModelMotion, Pose, Vector
from nrp_core.world.engine import Engine
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


_OF_HECTOR = ("referenceLatitude", "referenceLongitude", "referenceAltitude", "referenceHeading")
_FIX, _GPS = 0, 1
"""``STATUS_FIX`` and ``SERVICE_GPS`` of ``sensor_msgs/NavSatStatus``."""
_DIAGONAL_KNOWN = 2
"""``COVARIANCE_TYPE_DIAGONAL_KNOWN`` of ``sensor_msgs/NavSatFix``."""


@dataclass(frozen=True, slots=True)
class NavSat(Sensor):
    """A receiver of satellite navigation; its noise is in m, in all directions.

    Args:
        pose: its pose on its link.
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
            reading.notes.warn(ignored[0], Code.NRP383, message, subject=ignored[0].tag)
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


_IMU_TOPICS = {"gazebo_ros_imu_sensor": "topicName"}


@dataclass(frozen=True, slots=True)
class Imu(Sensor):
    """A sensor of orientation, turn rate and acceleration (0 in free fall) in the frame of its pose."""

    tag: ClassVar[str] = "imu"

    needs: ClassVar[tuple[str, ...]] = ("links",)
    noises: ClassVar[tuple[str, ...]] = ("turn_noise",)

    pose: Pose = Pose()
    turn_noise: Noise | None = field(default=None, kw_only=True, metadata=LATER)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Imu:
        """Read an inertial sensor; the noise along x is used for all axes."""
        name = sensor.attribute("name")
        noise = _noise_of_axes(sensor, "linear_acceleration", reading)
        turn_noise = _noise_of_axes(sensor, "angular_velocity", reading)
        for plugin in sensor.all("plugin") if not (noise or turn_noise) else ():
            noise = turn_noise = Noise(0.0, plugin.number("gaussianNoise", 0.0))
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/imu"), _IMU_TOPICS, reading)
        own = None if turn_noise == noise else turn_noise
        return cls(name, topic, rate_of(sensor, reading), mount.place(sensor), noise=noise, turn_noise=own)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, Imu]:
        """Read ``gazebo_ros_imu`` and ``hector_gazebo_ros_imu``."""
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading, "imu" if _is_hector(plugin) else "")
        link = model.link(plugin.require("bodyName")).name
        return link, cls(name, topic, rate_hz, offset_of(plugin), noise=noise)

    @property
    def offset(self) -> Pose:
        return self.pose

    def part(self, model: Model, link: str, engine: Engine) -> ImuPart:
        return ImuPart(self, model.name, link, engine)


def _noise_of_axes(sensor: Element, quantity: str, reading: Reading) -> Noise:
    """Return the noise of a vector, that along x; other noise along y and z is reported."""
    section = sensor.section("imu").section(quantity)
    along_x = noise_of(section.section("x"), reading)
    for axis in "yz":
        if noise_of(section.section(axis), reading) != along_x:
            message = (
                f"the noise of <x> is used for all axes of <{quantity}>, and that of <{axis}> is another"
            )
            reading.notes.warn(sensor, Code.NRP264, message, subject=sensor.attribute("name"))
            break
    return along_x


def _is_hector(plugin: Element) -> bool:
    return plugin_name(plugin).startswith("hector")


class ImuPart(SensorPart):
    """Publishes the measurements of one inertial sensor.

    An accelerometer measures the change of its velocity relative to free fall; here over the last physics
    step, in the same way in every engine. After the start, and after its model was moved, it measures gravity
    alone.
    """

    needs_previous_step = True

    def __init__(self, imu: Imu, model: str, link: str, engine: Engine) -> None:
        super().__init__(imu, model, link, engine)
        self._imu = imu
        self._before: tuple[int, Vector] | None = None
        self.topics = (self._served(imu.topic, ImuMessage, f"inertial sensor {imu.name}"),)

    def prepare_sample(self, topic: str, now_ns: int) -> None:
        self._before = now_ns, self._motion().linear

    def read(self, topic: str, now_ns: int) -> ImuMessage:
        motion = self._motion()
        to_sensor = motion.pose.inverse()
        felt = [
            a - g for a, g in zip(self._acceleration(motion, now_ns), self._engine.scene.gravity, strict=True)
        ]
        acceleration = to_sensor.rotate((felt[0], felt[1], felt[2]))
        vectors = to_sensor.rotate(motion.angular), acceleration
        turning, feeling = self._noisy(topic, now_ns, *vectors, own=(self._imu.turn_noise, None))
        message = ImuMessage(self._header(now_ns), Quaternion(*motion.pose.orientation))
        message.angular_velocity, message.linear_acceleration = Vector3(*turning), Vector3(*feeling)
        return message

    def reset(self) -> None:
        self._before = None

    def save(self) -> object:
        return self._before

    def restore(self, saved: Any) -> None:
        self._before = saved

    def _motion(self) -> ModelMotion:
        return self._engine.link_motion(*self._place).at(self._imu.pose)

    def _acceleration(self, motion: ModelMotion, now_ns: int) -> Vector:
        if self._before is None or self._before[0] >= now_ns:
            return 0.0, 0.0, 0.0
        before_ns, velocity = self._before
        dt = (now_ns - before_ns) * 1e-9
        x, y, z = ((now - then) / dt for now, then in zip(motion.linear, velocity, strict=True))
        return x, y, z


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
