"""The common elements of all sensors of SDF: rate, noise and topic."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from posixpath import join
from typing import NamedTuple

from nrp_core.errors import slip_of
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name, ros_namespace, vector_in, warn_of_plugin
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import Noise
from nrp_core.world.topics import resolve_name

DEFAULT_RATE_HZ = 30.0
_NOISES = "none", "gaussian", "gaussian_quantized"

_OUTPUTS = ("~/out", "bumper_states")
"""What ROS 2 plugins of sensors publish: those of contacts have a name of their own."""


def rate_of(sensor: Element, reading: Reading) -> float:
    """Return the update rate of a ``<sensor>``, Hz."""
    rate_hz = sensor.number("update_rate", 0.0)
    if rate_hz < 0:
        raise sensor.error(f"an <update_rate> must be 0 or more, not {rate_hz:g}")
    if rate_hz:
        return rate_hz
    name = sensor.attribute("name")
    reading.notes.warn(
        sensor,
        Code.NRP264,
        f"the sensor '{name}' has no <update_rate>: {DEFAULT_RATE_HZ:g} Hz is used",
        subject=name,
    )
    return DEFAULT_RATE_HZ


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
        message = f"noise of type '{kind}' is not simulated{slip_of(kind, _NOISES)}"
        reading.notes.warn(noise, Code.NRP262, message, subject=kind)
        return Noise()
    if kind == "gaussian_quantized":
        reading.notes.warn(noise, Code.NRP262, "the quantization of noise is not simulated")
    deviation = noise.number("stddev", 0.0)
    if deviation < 0:
        raise noise.error(f"the <stddev> of a <noise> must be 0 or more, not {deviation:g}")
    given = Noise(noise.number("mean", 0.0), deviation)
    if kind == "none" and given:
        message = (
            "this <noise> has numbers and is of the type none: there is no noise; write <type>gaussian</type>"
        )
        reading.notes.warn(noise, Code.NRP264, message)
    return Noise() if kind == "none" else given


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
    return join(ros_namespace(plugin), plugin.word(tag) or output_of(plugin) or default)


def output_of(plugin: Element) -> str:
    """Return the target of a ROS 2 plugin's remapping of what it publishes; empty for none."""
    ros = plugin.find("ros")
    rules = [rule.text.partition(":=") for rule in ros.all("remapping")] if ros else []
    return next((to for name, _, to in rules if name in _OUTPUTS), "")


class PluginSensor(NamedTuple):
    """The common parameters of all sensors that are plugins of a model."""

    name: str
    topic: str
    rate_hz: float
    noise: Noise


def plugin_sensor(plugin: Element, reading: Reading, usual: str = "") -> PluginSensor:
    """Return the common parameters of a ROS plugin of a model.

    Args:
        plugin: the ``<plugin>``.
        reading: the context of the reading.
        usual: the topic of a plugin that names none; empty where one is required.
    """
    topic = plugin.word("topicName", usual) or plugin.require("topicName").text
    topic = topic_in_namespace(plugin, topic, reading)
    name = plugin.attributes.get("name") or plugin_name(plugin)
    rate_hz = plugin.number("updateRate", 0.0) or 100.0
    return PluginSensor(name, topic, rate_hz, _noise_in(plugin))


def topic_in_namespace(plugin: Element, topic: str, reading: Reading) -> str:
    """Return a topic of a ROS plugin, which is relative to the plugin's namespace in that of the robot."""
    if topic.startswith("/"):
        return topic
    return resolve_name(f"{ros_namespace(plugin)}/{topic}".lstrip("/"), reading.robot)


def _noise_in(plugin: Element) -> Noise:
    """Return the noise of a ROS plugin; the first of several numbers is used for all axes."""
    given = [plugin.find(tag) for tag in ("accelGaussianNoise", "gaussianNoise")]
    numbers = next((each for each in given if each is not None and each.text), None)
    if numbers is None:
        return Noise()
    deviation, *others = numbers.numbers(len(numbers.text.split()))
    if min(deviation, *others, 0.0) < 0:
        raise numbers.error(f"a standard deviation must be 0 or more, not '{numbers.text}'")
    return Noise(0.0, deviation)


def offset_of(plugin: Element) -> Pose:
    """Return the pose that a ROS plugin of a model gives its sensor in the frame of its link."""
    return Pose.from_rpy(vector_in(plugin, "xyzOffset"), *vector_in(plugin, "rpyOffset"))
