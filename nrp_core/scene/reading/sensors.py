"""The sensors of a file: common elements and frames; each is read by the class of its type or plugin."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import dist, hypot, pi
from posixpath import join
from typing import Final, NamedTuple, Protocol

from nrp_core.errors import hint_if_close
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.registry import Registry
from nrp_core.scene.bodies import free_name
from nrp_core.scene.consistency import rigid_groups
from nrp_core.scene.devices import ANY_CAMERA, MountedSensor, Noise
from nrp_core.scene.model import Joint, Link
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import (
    ModelParts,
    check_parameters,
    find_registered,
    plugin_name,
    remapped_topic,
    ros_namespace,
    vector_in,
    warn_of_plugin,
)
from nrp_core.scene.rigid import Pose, rotation_vector

DEFAULT_RATE_HZ = 30.0
_NOISES = "none", "gaussian", "gaussian_quantized"

_OUTPUTS = ("~/out", "bumper_states")
"""What ROS 2 plugins of sensors publish: those of contacts have a name of their own."""


def rate_of(sensor: Element, reading: Reading) -> float:
    """Return the update rate of a ``<sensor>``, Hz; 0 for each step of the physics."""
    rate_hz = sensor.number("update_rate", 0.0)
    if rate_hz < 0:
        raise sensor.error(f"an <update_rate> must be 0 or more, not {rate_hz:g}")
    if sensor.find("update_rate") is not None:
        return rate_hz
    name = sensor.attribute("name")
    reading.notes.warn(
        sensor,
        Code.NRP384,
        f"the sensor '{name}' has no <update_rate>: {DEFAULT_RATE_HZ:g} Hz is used",
        subject=name,
        alike="no rate",
    )
    return DEFAULT_RATE_HZ


def bit_mask(element: Element, tag: str, default: int) -> int:
    """Return the bits in a child, a whole number that may be hexadecimal.

    Raises:
        SceneError: it is not a whole number.
    """
    child = element.find(tag)
    try:
        return int(child.text, 0) & ANY_CAMERA if child and child.text else default
    except ValueError:
        message = f"<{tag}> must be a whole number, such as 1 or 0x01, not '{element.section(tag).text}'"
        raise element.section(tag).error(message) from None


def field_of_view(lens: Element, default: float, most: float = pi) -> float:
    """Return the ``<horizontal_fov>`` of a lens, rad; ``most`` is impossible unless it is a whole turn."""
    angle = lens.positive("horizontal_fov", default)
    if angle > most or angle == most == pi:
        limit = "below pi" if most == pi else "at most 2 pi"
        raise lens.error(f"the <horizontal_fov> must be {limit}, not {angle:g}")
    return angle


def noise_of(section: Element, reading: Reading) -> Noise:
    """Return the ``<noise>`` of a part of a sensor; zero noise if it has none."""
    noise = section.find("noise")
    if noise is None:
        return Noise()
    kind = noise.attributes.get("type") or noise.word("type", "none")
    if kind not in _NOISES:
        message = f"noise of type '{kind}' is not simulated{hint_if_close(kind, _NOISES)}"
        reading.notes.warn(noise, Code.NRP262, message, subject=kind)
        noise.passed_over = True
        return Noise()
    given = _numbers_of(noise)  # Gazebo rounds whatever the type is
    if kind == "none" and given:
        message = (
            "this <noise> has numbers and is of the type none: there is no noise; write <type>gaussian</type>"
        )
        reading.notes.warn(noise, Code.NRP383, message)
    return Noise() if kind == "none" else given


_OF_NOISE = (
    "mean", "stddev", "bias_mean", "bias_stddev", "dynamic_bias_stddev", "dynamic_bias_correlation_time",
    "precision",
)  # fmt: skip
"""The elements of a ``<noise>`` in the order of the fields of :class:`Noise`."""


def _numbers_of(noise: Element) -> Noise:
    """Return the numbers of a ``<noise>``, or of the part of one for one quantity."""
    for tag in ("stddev", "bias_stddev", "dynamic_bias_stddev"):
        if (deviation := noise.number(tag, 0.0)) < 0:
            raise noise.error(f"the <{tag}> of a <noise> must be 0 or more, not {deviation:g}")
    return Noise(*(noise.number(tag, 0.0) for tag in _OF_NOISE))


def noise_of_axes(section: Element, reading: Reading, *names: str) -> Noise:
    """Return the noise of a vector, each axis of which has an element with a ``<noise>``."""
    return Noise.of_axes(*(noise_of(section.section(name), reading) for name in names or "xyz"))


def noise_of_quantity(noise: Element, quantity: str) -> Noise:
    """Return the noise of one quantity in the ``<noise>`` of an IMU as SDF had it up to its version 1.4."""
    part = noise.find(quantity)
    return Noise() if part is None or noise.word("type", "none") == "none" else _numbers_of(part)


def topic_of(sensor: Element, default: str, tags: Mapping[str, str], reading: Reading) -> str:
    """Return the topic that a ROS plugin names, else the sensor's own, else a default.

    Args:
        sensor: the ``<sensor>``.
        default: the default topic.
        tags: for each known plugin, by its name, the parameter with the topic.
        reading: the context of the reading.
    """
    topic = sensor.word("topic", default)
    for plugin in sensor.all("plugin"):
        tag = tags.get(plugin_name(plugin))
        if tag is None:
            warn_of_plugin(plugin, reading)
        else:
            topic = plugin_topic(plugin, tag, topic)
    return resolve_name(topic, reading.robot)


def plugin_topic(plugin: Element, tag: str, default: str) -> str:
    """Return the topic in a parameter or remapping of a ROS plugin, else a default."""
    named = plugin.word(tag)  # which ROS 2 ignores
    return join(ros_namespace(plugin), output_of(plugin) or named or default)


def output_of(plugin: Element) -> str:
    """Return the name to which a ROS 2 plugin's output is remapped; empty if it is not."""
    ros = plugin.find("ros")
    rules = [rule.text.partition(":=") for rule in ros.all("remapping")] if ros else []
    return next((to for name, _, to in rules if name in _OUTPUTS), "")


class PluginSensor(NamedTuple):
    """The common parameters of all sensors that are plugins of a model."""

    name: str
    topic: str
    rate_hz: float
    noise: Noise


def plugin_sensor(plugin: Element, reading: Reading, usual: str = "", remapped: str = "") -> PluginSensor:
    """Return the common parameters of a ROS plugin of a model.

    Args:
        plugin: the ``<plugin>``.
        reading: the context of the reading.
        usual: the topic of a plugin that names none; empty where one is required.
        remapped: the topic of its form for ROS 2, which has no parameter for it, before remapping; empty for
            a plugin without such a form.
    """
    if remapped and plugin.find("topicName") is None:
        usual = remapped_topic(plugin, remapped)
    topic = plugin.word("topicName", usual) or plugin.require("topicName").text
    topic = topic_in_namespace(plugin, topic, reading)
    name = plugin.attributes.get("name") or plugin_name(plugin)
    rate_hz = plugin.number(_spelling(plugin, "updateRate"), 0.0) or 100.0
    return PluginSensor(name, topic, rate_hz, _noise_in(plugin))


def _spelling(plugin: Element, tag: str) -> str:
    """Return the tag of a parameter: as in ROS 1, or with underscores as in ROS 2."""
    if plugin.find(tag) is None:
        other = re.sub(r"[A-Z]", lambda capital: f"_{capital[0].lower()}", tag)
        return other if plugin.find(other) is not None else tag
    return tag


def topic_in_namespace(plugin: Element, topic: str, reading: Reading) -> str:
    """Return a topic of a ROS plugin, which is relative to the plugin's namespace in that of the robot."""
    if topic.startswith("/"):
        return topic
    return resolve_name(f"{ros_namespace(plugin)}/{topic}".lstrip("/"), reading.robot)


def _noise_in(plugin: Element) -> Noise:
    """Return the noise of a ROS plugin; the first of several numbers is used for all axes."""
    given = [plugin.find(tag) for tag in ("accelGaussianNoise", "gaussianNoise", "gaussian_noise")]
    numbers = next((each for each in given if each is not None and each.text), None)
    if numbers is None:
        return Noise()
    deviation, *others = numbers.numbers(len(numbers.text.split()))
    if min(deviation, *others, 0.0) < 0:
        raise numbers.error(f"a standard deviation must be 0 or more, not '{numbers.text}'")
    return Noise(0.0, deviation)


def offset_of(plugin: Element) -> Pose:
    """Return the pose that a ROS plugin of a model gives its sensor in the frame of its link."""
    place, turn = (vector_in(plugin, _spelling(plugin, tag)) for tag in ("xyzOffset", "rpyOffset"))
    return Pose.from_rpy(place, *turn)


_OF_SENSORS = ("gz_frame_id", "ignition_frame_id", "frame_id")
_OF_PLUGINS = ("frameName", "frame_name")
_NEAR_M, _NEAR_RAD = 1e-3, 2e-3  # files round right angles to 1.57


def frame_named(sensor: Element, reading: Reading) -> str:
    """Return the frame that a ``<sensor>`` or its plugin names, without the name of its robot; else ""."""
    names = [sensor.section("camera").word("optical_frame_id"), *map(sensor.word, _OF_SENSORS)]
    names += [plugin.word(tag) for plugin in sensor.all("plugin") for tag in _OF_PLUGINS]
    name = next(filter(None, names), "").strip("/")
    return name.removeprefix(f"{reading.robot}/")


@dataclass(frozen=True, slots=True)
class Misplaced:
    """A sensor whose frame is named like one that is elsewhere.

    Args:
        link: the link that holds it.
        sensor: its name.
        named: the frame that it names.
        why: how the two differ.
    """

    link: str
    sensor: str
    named: str
    why: str

    @property
    def message(self) -> str:
        """The message of a finding."""
        return f"the sensor '{self.sensor}' names the frame '{self.named}', {self.why}: it has its own frame"


def with_frames(links: Sequence[Link], joints: Iterable[Joint]) -> tuple[list[Link], list[Misplaced]]:
    """Return links whose sensors use the frames that they name, if these are at the sensors' poses.

    Args:
        links: the links of a model.
        joints: its joints.
    """
    fixed = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    rigid = rigid_groups([link.name for link in links], fixed)
    frames = {link.name: (link.name, link.pose) for link in links}
    misplaced: list[Misplaced] = []

    def settled(link: Link) -> Iterator[MountedSensor]:
        for sensor in link.sensors:
            if not sensor.frame_name or sensor.offset is None:
                yield sensor
                continue
            place = link.pose @ sensor.offset
            holder, there = frames.setdefault(sensor.frame_name, (link.name, place))
            why = _difference(place, there) if holder in rigid[link.name] else "which moves against it"
            if why:
                misplaced.append(Misplaced(link.name, sensor.name, sensor.frame_name, why))
            yield replace(sensor, frame_name="") if why else sensor

    return [replace(link, sensors=tuple(settled(link))) for link in links], misplaced


def _difference(place: Pose, other: Pose) -> str:
    """Return a description of how a pose differs from that of a sensor's frame, empty if equal."""
    away = dist(place.position, other.position)
    turned = hypot(*rotation_vector((place.inverse() @ other).orientation))
    parts = [f"{away:.3g} m away"] if away > _NEAR_M else []
    parts += [f"turned by {turned:.3g} rad"] if turned > _NEAR_RAD else []
    return f"which is {' and '.join(parts)}" if parts else ""


MULTICAMERA = "multicamera"
"""The type of a ``<sensor>`` with several cameras."""
_UNSIMULATED: Final = ("air_flow", "air_speed", "dvl", "rfid", "rfidtag", "transceiver")
"""The elements of types of sensors that no backend simulates."""
PLUGIN = "plugin."
"""Prefix of the names of entry points for a model's ``<plugin>``."""


@dataclass(frozen=True, slots=True)
class Mount:
    """The link or joint that holds a ``<sensor>``.

    Args:
        name: the name of the link or joint.
        place: returns the pose of an element in the frame of the link or joint.
    """

    name: str
    place: Callable[[Element], Pose]


class SensorReader(Protocol):
    """The class of a sensor for readers, a :class:`nrp_core.world.sensors.sensor.Sensor`."""

    @property
    def on_joint(self) -> bool:
        """Whether its ``<sensor>`` is in a ``<joint>`` instead of a ``<link>``."""

    @property
    def needs(self) -> tuple[str, ...]:
        """The capabilities that it needs of an engine."""

    def read(self, sensor: Element, mount: Mount, reading: Reading) -> MountedSensor:
        """Read a ``<sensor>``."""

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, MountedSensor]:
        """Read a ``<plugin>`` of a model, and return the link that it measures with the sensor."""


SENSORS: Registry[SensorReader] = Registry("nrp_core.sensors", "sensor")
"""Sensors by the types of ``<sensor>``, and by :data:`PLUGIN` and the names of plugins of models."""


def sensor_types() -> list[str]:
    """Return the types of ``<sensor>``, which are also the names of elements with their parameters."""
    return [name for name in SENSORS.names() if not name.startswith(PLUGIN)]


def link_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a link; omit those that cannot be simulated, with a warning."""
    seen: set[str] = set()
    for sensor in chain.from_iterable(map(_apart, sensors)):
        sensor = _with_free_name(sensor, seen, mount, reading)
        seen.add(sensor.attribute("name"))
        for read in _read_sensor(sensor, mount, reading, on_joint=False):
            yield read if read.offset is None else replace(read, frame_name=frame_named(sensor, reading))


def _apart(sensor: Element) -> list[Element]:
    """Return the cameras of a ``multicamera``, each as a ``<sensor>``; any other sensor is itself."""
    if sensor.attribute("type") != MULTICAMERA:
        return [sensor]
    sensor.require("camera")
    shared = [child for child in sensor.children if child.tag not in ("camera", "topic")]
    cameras = []
    for number, camera in enumerate(sensor.all("camera")):
        eye = camera.attributes.get("name") or str(number)
        name = f"{sensor.attribute('name')}_{eye}"
        topics = [replace(each, text=f"{each.text}/{eye}/image") for each in sensor.all("topic")]
        one = sensor.with_attributes(name=name, type="camera")
        cameras.append(replace(one, children=[*shared, *topics, camera]))
    return cameras


def _with_free_name(sensor: Element, taken: Collection[str], mount: Mount, reading: Reading) -> Element:
    """Return a sensor, renamed with a warning if its name is taken."""
    name = sensor.attribute("name")
    unique = free_name(name, taken)
    if unique == name:
        return sensor
    message = f"the link '{mount.name}' has two sensors named '{name}': this one is renamed '{unique}'"
    reading.notes.warn(sensor, Code.NRP266, message, subject=name)
    return sensor.with_attributes(name=unique)


def joint_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a joint in the same way."""
    for sensor in sensors:
        yield from _read_sensor(sensor, mount, reading, on_joint=True)


def _read_sensor(
    sensor: Element, mount: Mount, reading: Reading, *, on_joint: bool
) -> Iterator[MountedSensor]:
    """Yield a sensor of a joint or a link; warn instead if it cannot be simulated there."""
    kind, name = sensor.attribute("type"), sensor.attribute("name")
    found = find_registered(SENSORS, kind, sensor)
    if found is None:
        message = f"sensors of type '{kind}' are not simulated{hint_if_close(kind, sensor_types())}"
        reading.notes.warn(sensor, Code.NRP262, message, subject=kind)
        sensor.pass_over(*(child.tag for child in sensor.children))  # it may be a renamed copy
    elif found.on_joint != on_joint:
        holder = "joint" if found.on_joint else "link"
        message = f"the sensor '{name}' is left out: a sensor of type '{kind}' belongs in a <{holder}>"
        reading.notes.warn(sensor, Code.NRP262, message, subject=kind)
        sensor.pass_over(*(child.tag for child in sensor.children))  # it may be a renamed copy
    else:
        read = found.read(sensor, mount, reading)
        _warn_of_unread(sensor, reading)
        yield read


def _warn_of_unread(sensor: Element, reading: Reading) -> None:
    """Warn of the elements of other types of sensors, and of parameters of plugins without effect."""
    kind, name = sensor.attribute("type"), sensor.attribute("name")
    for child in sensor.children:
        if child.tag == "plugin":
            check_parameters(child, reading.notes)
        elif child.tag not in sensor.asked and child.tag in (*sensor_types(), *_UNSIMULATED):
            message = f"<{child.tag}> has no effect in the sensor '{name}', which is of type '{kind}'"
            reading.notes.warn(child, Code.NRP383, message, subject=child.tag)
            child.passed_over = True


def with_plugin_sensor(plugin: Element, model: ModelParts, reading: Reading) -> list[Link] | None:
    """Return the links with the sensor of a ``<plugin>`` of a model; None if the plugin is not a sensor."""
    found = find_registered(SENSORS, PLUGIN + plugin_name(plugin), plugin)
    if found is None:
        return None
    return with_sensors(model.links, *found.read_plugin(plugin, model, reading))


def with_sensors(links: Sequence[Link], name: str, *sensors: MountedSensor) -> list[Link]:
    """Return links with further sensors on one of them."""
    return [replace(each, sensors=(*each.sensors, *sensors)) if each.name == name else each for each in links]
