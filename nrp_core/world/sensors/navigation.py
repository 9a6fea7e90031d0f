"""Sensors of navigation: IMU, magnetometer, barometer, altimeter and satellite navigation."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, radians
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
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
    noise_of_axes,
    noise_of_quantity,
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
        pressure = float(self._measured(topic, now_ns, pressure))
        return self._message(self._header(now_ns), pressure, self._sensor.noise.stddev**2)


@dataclass(frozen=True, slots=True)
class Altimeter(Sensor):
    """Measures the height of its pose above where the model's file puts it, and how fast it rises.

    Its noise is on the height, m; ``velocity_noise`` is that of the velocity, m/s.
    """

    tag: ClassVar[str] = "altimeter"

    needs: ClassVar[tuple[str, ...]] = ("links",)
    noises: ClassVar[tuple[str, ...]] = ("velocity_noise",)

    pose: Pose = Pose()
    velocity_noise: Noise | None = field(default=None, kw_only=True, metadata=LATER)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Altimeter:
        name, section = sensor.attribute("name"), sensor.section("altimeter")
        velocity = noise_of(section.section("vertical_velocity"), reading) or None
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/altimeter"), {}, reading)
        noise = noise_of(section.section("vertical_position"), reading)
        rate_hz, place = rate_of(sensor, reading), mount.place(sensor)
        return cls(name, topic, rate_hz, place, noise=noise, velocity_noise=velocity)

    def part(self, model: Model, link: str, engine: Engine) -> AltimeterPart:
        return AltimeterPart(self, model, link, engine)


class AltimeterPart(SensorPart):
    """Publishes the heights of one altimeter."""

    def __init__(self, sensor: Altimeter, model: Model, link: str, engine: Engine) -> None:
        super().__init__(sensor, model.name, link, engine)
        self._pose, self._velocity_noise = sensor.pose, sensor.velocity_noise or Noise()
        self._reference = (model.pose @ model.link(link).pose @ sensor.pose).position[2]
        self.topics = (self._served(sensor.topic, Altitude, f"height of {model.name}/{link}, m"),)

    def read(self, topic: str, now_ns: int) -> Altitude:
        motion = self._engine.link_motion(*self._place).at(self._pose)
        height = float(self._measured(topic, now_ns, motion.pose.position[2] - self._reference))
        rise = float(self._measured(f"{topic}/velocity", now_ns, motion.linear[2], self._velocity_noise))
        return Altitude(self._header(now_ns), height, rise, self._reference)


_LEVELS = ("horizontal", "horizontal", "vertical")
"""The directions in which a file gives the noise along east, north and up."""
_OF_HECTOR = ("referenceLatitude", "referenceLongitude", "referenceAltitude", "referenceHeading")
_FIX, _GPS = 0, 1
"""``STATUS_FIX`` and ``SERVICE_GPS`` of ``sensor_msgs/NavSatStatus``."""
_DIAGONAL_KNOWN = 2
"""``COVARIANCE_TYPE_DIAGONAL_KNOWN`` of ``sensor_msgs/NavSatFix``."""


@dataclass(frozen=True, slots=True)
class NavSat(Sensor):
    """A receiver of satellite navigation; its noise is in m.

    Args:
        pose: its pose on its link.
        velocity_topic: the topic of its velocity in the world (m/s); empty for none.
        velocity_noise: the noise of the velocity.
    """

    tag: ClassVar[str] = "navsat"

    needs: ClassVar[tuple[str, ...]] = ("links",)
    noises: ClassVar[tuple[str, ...]] = ("velocity_noise",)

    pose: Pose = Pose()
    velocity_topic: str = field(default="", metadata=LATER)
    velocity_noise: Noise | None = field(default=None, kw_only=True, metadata=LATER)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> NavSat:
        """Read a receiver; without a topic of its velocity, the noise of that has no effect."""
        name = sensor.attribute("name")
        section = sensor.section("navsat" if sensor.find("navsat") else "gps")
        noise = noise_of_axes(section.section("position_sensing"), reading, *_LEVELS)
        velocity = noise_of_axes(section.section("velocity_sensing"), reading, *_LEVELS)
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/navsat"), {}, reading)
        rate_hz, place = rate_of(sensor, reading), mount.place(sensor)
        fast = f"{topic}/velocity" if velocity else ""
        return cls(name, topic, rate_hz, place, fast, noise=noise, velocity_noise=velocity or None)

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
        self._pose, self._velocity_noise = sensor.pose, sensor.velocity_noise or Noise()
        self._covariance = _covariance(sensor.noise)
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
            (velocity,) = self._noisy(topic, now_ns, motion.linear, own=(self._velocity_noise,))
            return self._vector(Header(Time.from_ns(now_ns), WORLD), Vector3(*velocity))
        position = motion.pose.position
        (measured,) = self._noisy(topic, now_ns, position)
        place = self._engine.scene.surroundings.on_earth(measured)
        covariance = self._covariance.copy()
        return self._message(self._header(now_ns), self._status, *place, covariance, _DIAGONAL_KNOWN)


def _covariance(noise: Noise) -> FloatArray:
    """Return the covariance matrix of a vector with a noise, row by row."""
    return np.diag([axis.stddev**2 for axis in noise.on(3)]).ravel()


_IMU_TOPICS = {"gazebo_ros_imu_sensor": "topicName"}


@dataclass(frozen=True, slots=True)
class Imu(Sensor):
    """A sensor of orientation, turn rate and acceleration (0 in free fall) in the frame of its pose.

    Args:
        pose: its pose on its link.
        turn_noise: the noise of the turn rate; None for that of all numbers.
        reference, reference_rpy: the frame to which its orientation relates: roll, pitch and yaw in the world
            if ``reference`` is empty, else in east, north and up on the Earth.
        has_orientation: whether it measures its orientation.
    """

    tag: ClassVar[str] = "imu"

    needs: ClassVar[tuple[str, ...]] = ("links",)
    noises: ClassVar[tuple[str, ...]] = ("turn_noise",)

    pose: Pose = Pose()
    turn_noise: Noise | None = field(default=None, kw_only=True, metadata=LATER)
    reference: str = field(default="", kw_only=True, metadata=LATER)
    reference_rpy: Vector = field(default=(0.0, 0.0, 0.0), kw_only=True, metadata=LATER)
    has_orientation: bool = field(default=True, kw_only=True, metadata=LATER)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Imu:
        """Read an inertial sensor, also with the ``<noise>`` of SDF before its version 1.5."""
        name, imu = sensor.attribute("name"), sensor.section("imu")
        noise = noise_of_axes(imu.section("linear_acceleration"), reading)
        turn_noise = noise_of_axes(imu.section("angular_velocity"), reading)
        if old := imu.find("noise"):
            noise, turn_noise = noise_of_quantity(old, "accel"), noise_of_quantity(old, "rate")
        for plugin in sensor.all("plugin") if not (noise or turn_noise) else ():
            noise = turn_noise = Noise(0.0, plugin.number("gaussianNoise", 0.0))
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/imu"), _IMU_TOPICS, reading)
        own = None if turn_noise == noise else turn_noise
        frame, rpy = _reference(imu.section("orientation_reference_frame"), reading)
        return cls(
            name, topic, rate_of(sensor, reading), mount.place(sensor), noise=noise, turn_noise=own,
            reference=frame, reference_rpy=rpy, has_orientation=imu.flag("enable_orientation", True),
        )  # fmt: skip

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


_CUSTOM = "CUSTOM"
_FRAMES = {"ENU": (0.0, 0.0, 0.0), "NED": (pi, 0.0, pi / 2), "NWU": (0.0, 0.0, pi / 2)}
"""Roll, pitch and yaw of frames of reference on the Earth, in the one of east, north and up."""


def _reference(section: Element, reading: Reading) -> tuple[str, Vector]:
    """Return the frame to which an ``<orientation_reference_frame>`` relates, and its roll, pitch and yaw.

    The frame is the world's if it is empty, else that of east, north and up on the Earth.
    """
    kind = section.word("localization", _CUSTOM)
    rpy = section.section("custom_rpy")
    x, y, z = rpy.numbers(3) if rpy.text else (0.0, 0.0, 0.0)
    parent = rpy.attributes.get("parent_frame", "")
    if (kind != _CUSTOM and kind not in _FRAMES) or parent not in ("", WORLD):
        given = f"<localization> {kind}" if kind not in (_CUSTOM, *_FRAMES) else f"parent_frame '{parent}'"
        message = f"the {given} of an IMU is not simulated: its orientation is that in the world"
        reading.notes.warn(section, Code.NRP262, message, subject="orientation_reference_frame")
        return "", (0.0, 0.0, 0.0)
    return ("", (x, y, z)) if kind == _CUSTOM else ("ENU", _FRAMES[kind])


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
        message = ImuMessage(self._header(now_ns), self._orientation(motion.pose))
        message.angular_velocity, message.linear_acceleration = Vector3(*turning), Vector3(*feeling)
        noise, turn_noise = self._imu.noise, self._imu.turn_noise
        message.linear_acceleration_covariance = _covariance(noise)
        message.angular_velocity_covariance = _covariance(noise if turn_noise is None else turn_noise)
        if not self._imu.has_orientation:
            message.orientation_covariance[0] = -1.0  # as ROS marks a value that is not measured
        return message

    def _orientation(self, pose: Pose) -> Quaternion:
        """Return the orientation of the sensor in its frame of reference."""
        if not self._imu.has_orientation:
            return Quaternion()
        frame = Pose.from_rpy((0.0, 0.0, 0.0), *self._imu.reference_rpy)
        if self._imu.reference:  # the world's x axis is turned from east
            turn = radians(self._engine.scene.surroundings.heading)
            frame = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, -turn) @ frame
        return Quaternion(*(frame.inverse() @ Pose(orientation=pose.orientation)).orientation)

    def reset(self) -> None:
        super().reset()
        self._before = None

    def save(self) -> object:
        return self._before, super().save()

    def restore(self, saved: Any) -> None:
        self._before, biases = saved
        super().restore(biases)

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
        """Read a magnetometer."""
        name = sensor.attribute("name")
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/magnetic_field"), {}, reading)
        noise = noise_of_axes(sensor.section("magnetometer"), reading)
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
        self._covariance = _covariance(sensor.noise)
        self.topics = (self._served(sensor.topic, self._message, f"magnetic field at {model}/{link}, T"),)

    def read(self, topic: str, now_ns: int) -> Any:
        turned = self._engine.link_motion(*self._place).at(self._pose).pose
        felt = turned.rotate_back(self._engine.scene.surroundings.magnetic_field)
        (measured,) = self._noisy(topic, now_ns, felt)
        return self._message(self._header(now_ns), Vector3(*measured), self._covariance.copy())
