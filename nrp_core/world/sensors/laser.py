"""Laser scanners and sonars: distances along rays, as scans, points or one range."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from math import atan, pi
from typing import ClassVar, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.messages.point_cloud2 import create_cloud
from nrp_core.messages.sensor_msgs import LaserScan, PointCloud2, Range
from nrp_core.scene.devices import LATER, Noise
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import plugin_name, warn_of_plugin
from nrp_core.scene.reading.sensors import Mount, noise_of, plugin_topic, rate_of, topic_of
from nrp_core.scene.rigid import Pose
from nrp_core.world.engine import Engine
from nrp_core.world.raycast.beams import Beams, directions
from nrp_core.world.sensors.sensor import Sensor, SensorPart

RANGE: Final = "sensor_msgs/Range"
RANGE_PLUGIN: Final = "gazebo_ros_range"
_RADIATIONS: Final = ("ultrasound", "infrared")


class RangePlugin(NamedTuple):
    """The settings of such a plugin.

    Args:
        topic: the absolute topic of distances, None for none.
        infrared: whether it is not ultrasound.
        cone: the angle of its cone, rad.
        noise: noise on the distances.
    """

    topic: str | None = None
    infrared: bool = False
    cone: float = 0.0
    noise: Noise = Noise()


def range_plugin(sensor: Element, reading: Reading) -> RangePlugin:
    """Return the settings for distances in the plugins of a ``<sensor>`` with rays.

    Raises:
        SceneError: its kind of radiation is unknown.
    """
    for plugin in sensor.all("plugin"):
        if plugin_name(plugin) != RANGE_PLUGIN and plugin.word("output_type") != RANGE:
            continue
        tag = "radiation" if plugin.find("radiation") else "radiation_type"
        radiation = plugin.word(tag, _RADIATIONS[0]).lower()
        if radiation not in _RADIATIONS:
            hint = did_you_mean(radiation, _RADIATIONS)
            raise plugin.require(tag).error(f"'{radiation}' is not a kind of radiation{hint}")
        default = reading.topic_of(sensor.attribute("name"), "range")
        topic = resolve_name(plugin_topic(plugin, "topicName", default), reading.robot)
        deviation = plugin.number("gaussianNoise", 0.0)
        if deviation < 0:
            given = plugin.require("gaussianNoise")
            raise given.error(f"a standard deviation must be 0 or more, not {deviation:g}")
        cone = plugin.positive("fov", 0.05)
        return RangePlugin(topic, radiation == _RADIATIONS[1], cone, Noise(0.0, deviation))
    return RangePlugin()


_SCANS, _POINTS = "sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"
_OUTPUTS = {
    "gazebo_ros_laser": _SCANS,
    "gazebo_ros_gpu_laser": _SCANS,
    "gazebo_ros_block_laser": _POINTS,
    "gazebo_ros_velodyne_laser": _POINTS,
    "gazebo_ros_velodyne_gpu_laser": _POINTS,
    "gazebo_ros_ray_sensor": _POINTS,  # default
    RANGE_PLUGIN: RANGE,
}
POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")])
"""A point of a cloud in the frame of its sensor; its ring is its layer, from the lowest."""


@dataclass(frozen=True, slots=True)
class Laser(Sensor):
    """A scanner that measures distances, counter-clockwise from x of its pose, in one or several layers.

    Args:
        topic: absolute topic of the scans of its middle layer.
        angle_min, angle_max: angles of the first and last ray of a layer, rad.
        samples: number of rays of a layer, spread evenly from one to the other; a single one is at 0.
        range_min, range_max: limits of the measured distances, m.
        layers: number of layers, from the lowest; a single one is in the plane z = 0.
        elevation_min, elevation_max: elevations of the first and last layer above the plane, rad.
        points_topic: absolute topic of the points of all layers, None for none.
        range_topic: absolute topic of the shortest distance of all rays, None for none.
        infrared, cone: fields of its messages: whether the radiation is infrared, else ultrasound; the angle,
            rad.
    """

    tag: ClassVar[str] = "laser"

    needs: ClassVar[tuple[str, ...]] = ("links",)

    samples: int = 640
    angle_min: float = -pi / 2
    angle_max: float = pi / 2
    range_min: float = 0.1
    range_max: float = 10.0
    pose: Pose = Pose()
    layers: int = 1
    elevation_min: float = 0.0
    elevation_max: float = 0.0
    points_topic: str | None = None
    range_topic: str | None = field(default=None, metadata=LATER)
    infrared: bool = field(default=False, metadata=LATER)
    cone: float = field(default=0.0, metadata=LATER)

    @property
    def beams(self) -> Beams:
        """Its rays."""
        return Beams(
            self.pose,
            self.samples,
            (self.angle_min, self.angle_max),
            self.layers,
            (self.elevation_min, self.elevation_max),
            (self.range_min, self.range_max),
        )

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Laser:
        laser = sensor.section("lidar" if sensor.find("lidar") else "ray")
        horizontal = laser.section("scan").section("horizontal")
        reach = laser.section("range")
        vertical = laser.section("scan").section("vertical")
        layers = _count(vertical, 1)
        low, high = reach.number("min", 0.0), reach.number("max", 10.0)
        if not 0 <= low < high:
            raise reach.error(f"a laser's <min> range ({low:g} m) must be below its <max> ({high:g} m)")
        for scan in (horizontal, vertical):
            _require_sensible(scan, reading)
        scans, points = _topics(sensor, mount, layers, reading)
        single = range_plugin(sensor, reading)
        return cls(
            sensor.attribute("name"),
            scans,
            rate_of(sensor, reading),
            _count(horizontal, 640),
            horizontal.number("min_angle", -pi / 2),
            horizontal.number("max_angle", pi / 2),
            low,
            high,
            mount.place(sensor),
            layers,
            vertical.number("min_angle", 0.0) if layers > 1 else 0.0,
            vertical.number("max_angle", 0.0) if layers > 1 else 0.0,
            points,
            single.topic,
            single.infrared,
            single.cone,
            noise=noise_of(laser, reading) or single.noise,
        )

    @property
    def offset(self) -> Pose:
        return self.pose

    def part(self, model: Model, link: str, engine: Engine) -> LaserPart:
        return LaserPart(self, model.name, link, engine)


class LaserPart(SensorPart):
    """Publishes the scans of one laser, whose rays hit the collision shapes of other bodies."""

    def __init__(self, laser: Laser, model: str, link: str, engine: Engine) -> None:
        super().__init__(laser, model, link, engine)
        self._laser, self._beams = laser, laser.beams
        rays = f"laser {laser.name}, {laser.samples} rays"
        self.topics = (self._served(laser.topic, LaserScan, rays),)
        if laser.points_topic is not None:
            layers = f"{rays} in {laser.layers} layer{'s' if laser.layers > 1 else ''}"
            self.topics += (self._served(laser.points_topic, PointCloud2, layers),)
        if laser.range_topic is not None:
            self.topics += (self._served(laser.range_topic, Range, f"shortest distance of {rays}"),)

    def read(self, topic: str, now_ns: int) -> LaserScan | PointCloud2 | Range:
        ranges = self._ranges(now_ns)
        if topic == self._laser.range_topic:
            return self._range(float(ranges.min()), now_ns)
        return (
            self._points(ranges, now_ns) if topic == self._laser.points_topic else self._scan(ranges, now_ns)
        )

    def _ranges(self, now_ns: int) -> npt.NDArray[np.float64]:
        """Return the distances along all rays, shape ``(layers, samples)``."""
        laser = self._laser
        ranges = self._engine.scan(*self._place, self._beams).reshape(laser.layers, laser.samples)
        if laser.noise:
            noisy = self._measured(laser.topic, now_ns, ranges)  # the same in all forms
            ranges = np.where(np.isfinite(ranges), np.clip(noisy, 0.0, None), ranges)
        return ranges

    def _scan(self, ranges: npt.NDArray[np.float64], now_ns: int) -> LaserScan:
        right, left, step, nearest, farthest = _constants(self._laser)
        middle = ranges[self._laser.layers // 2].astype(np.float32)
        return LaserScan(self._header(now_ns), right, left, step, 0.0, 0.0, nearest, farthest, middle)

    def _range(self, nearest: float, now_ns: int) -> Range:
        laser = self._laser
        kind = Range.INFRARED if laser.infrared else Range.ULTRASOUND
        cone, low, high = (
            float(np.float32(number)) for number in (laser.cone, laser.range_min, laser.range_max)
        )
        return Range(self._header(now_ns), kind, cone, low, high, float(np.float32(nearest)))

    def _points(self, ranges: npt.NDArray[np.float64], now_ns: int) -> PointCloud2:
        """Return a row of points for each layer in the frame of the sensor; NaN for rays that hit nothing."""
        laser = self._laser
        points = np.zeros(ranges.shape, POINT)
        met = np.where(np.isfinite(ranges), ranges, np.nan)
        for axis, along in zip("xyz", directions(self._beams).T, strict=True):
            points[axis] = along.reshape(ranges.shape) * met
        points["ring"] = np.arange(laser.layers)[:, None]
        return create_cloud(self._header(now_ns), points)


_ONE_RAD: Final = 1.0
"""Angles farther apart than this are meant for several rays."""


def _require_sensible(scan: Element, reading: Reading) -> None:
    """Warn of invalid angles."""
    low, high = scan.number("min_angle", 0.0), scan.number("max_angle", 0.0)
    if high - low > 4 * pi:  # real scanners cover a little more than a turn
        message = f"rays from {low:g} to {high:g} rad are more than a turn; angles are in radians"
        reading.notes.warn(scan, Code.NRP264, message)
    elif scan.find("min_angle") and scan.find("max_angle") and low > high:
        message = f"the <min_angle> of a laser, {low:g} rad, is above its <max_angle>, {high:g} rad"
        reading.notes.warn(scan, Code.NRP264, message)
    elif scan.find("samples") and _count(scan, 1) == 1 and high - low > _ONE_RAD:
        message = f"a laser with one ray has angles from {low:g} to {high:g} rad: the ray points to the first"
        reading.notes.warn(scan, Code.NRP264, message)


def _count(angles: Element, default: int) -> int:
    """Return the number of rays from one angle to the other."""
    samples = angles.positive("samples", default)
    if samples != int(samples):
        raise angles.require("samples").error(f"<samples> must hold a whole number, not '{samples:g}'")
    return max(1, round(samples * angles.positive("resolution", 1.0)))


def _topics(sensor: Element, mount: Mount, layers: int, reading: Reading) -> tuple[str, str | None]:
    """Return the topics of scans and points: those of ROS plugins, else those of gz-sim."""
    scans = sensor.word("topic", reading.topic_of(mount.name, f"{sensor.attribute('name')}/scan"))
    points = f"{scans}/points" if layers > 1 else None
    for plugin in sensor.all("plugin"):
        usual = _OUTPUTS.get(plugin_name(plugin))
        output = plugin.word("output_type", usual or "")
        if output == RANGE:
            continue
        if usual is None:
            warn_of_plugin(plugin, reading)
        elif output == _SCANS:
            scans = plugin_topic(plugin, "topicName", scans)
        else:
            if output != _POINTS:
                reading.notes.warn(plugin, Code.NRP262, f"points are published as {_POINTS}, not as {output}")
            points = plugin_topic(plugin, "topicName", points or f"{scans}/points")
    return resolve_name(scans, reading.robot), resolve_name(points, reading.robot) if points else None


@cache
def _constants(laser: Laser) -> list[float]:
    """Return angles, the step between them, and range limits in single precision, as in a message."""
    step = (laser.angle_max - laser.angle_min) / max(1, laser.samples - 1)
    numbers = laser.angle_min, laser.angle_max, step, laser.range_min, laser.range_max
    return [float(np.float32(number)) for number in numbers]


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
            message = f"the <geometry> of a sonar is a cone here, not a '{shape.text}'"
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
