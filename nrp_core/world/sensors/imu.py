"""Inertial measurement units: orientation, turn rate and acceleration."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from nrp_core.findings import Code
from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.world.messages.sensor_msgs import Imu as ImuMessage
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.digest import LATER
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.sensor_elements import noise_of, offset_of, plugin_sensor, rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import Noise
from nrp_core.world.sensors.sensor import Sensor, SensorPart

_TOPICS = {"gazebo_ros_imu_sensor": "topicName"}


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
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/imu"), _TOPICS, reading)
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
            reading.notes.warn(sensor, Code.NRP263, message, subject=sensor.attribute("name"))
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

    foresees = True

    def __init__(self, imu: Imu, model: str, link: str, engine: Engine) -> None:
        super().__init__(imu, model, link, engine)
        self._imu = imu
        self._before: tuple[int, Vector] | None = None
        self.topics = (self._served(imu.topic, ImuMessage, f"inertial sensor {imu.name}"),)

    def foresee(self, topic: str, now_ns: int) -> None:
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
