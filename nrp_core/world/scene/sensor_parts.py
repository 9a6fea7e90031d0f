"""What all sensors of SDF say in the same way: how often, where, how well."""

from __future__ import annotations

from collections.abc import Mapping
from posixpath import join

from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name, ros_namespace, warn_of_plugin
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import Noise
from nrp_core.world.topics import resolve_name

DEFAULT_RATE_HZ = 30.0


def rate_of(sensor: Element, reading: Reading) -> float:
    """Return the samples a second that a ``<sensor>`` asks for."""
    rate_hz = sensor.number("update_rate", 0.0)
    if rate_hz < 0:
        raise sensor.error(f"an <update_rate> is 0 or more, not {rate_hz:g}")
    if rate_hz:
        return rate_hz
    name = sensor.attribute("name")
    reading.notes.warn(sensor, f"the sensor '{name}' has no <update_rate>: {DEFAULT_RATE_HZ:g} Hz are taken")
    return DEFAULT_RATE_HZ


def noise_of(section: Element, reading: Reading) -> Noise:
    """Return the ``<noise>`` of a part of a sensor, none where it has none."""
    noise = section.find("noise")
    if noise is None:
        return Noise()
    kind = noise.attributes.get("type") or noise.word("type", "none")
    if kind not in ("none", "gaussian", "gaussian_quantized"):
        reading.notes.warn(noise, f"noise of type '{kind}' is not simulated")
        return Noise()
    if kind == "gaussian_quantized":
        reading.notes.warn(noise, "noise is not quantized")
    return Noise(noise.number("mean", 0.0), noise.number("stddev", 0.0)) if kind != "none" else Noise()


def topic_of(sensor: Element, default: str, tags: Mapping[str, str], reading: Reading) -> str:
    """Return the topic that a ROS plugin names, else the sensor's own, else a default.

    Args:
        sensor: the ``<sensor>``.
        default: a topic.
        tags: of each plugin that is known, by its name, the parameter that names the topic.
        reading: what is carried along.
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
    """Return the topic that a ROS plugin names by a parameter or a remapping, else a default."""
    return join(ros_namespace(plugin), plugin.word(tag) or output_of(plugin) or default)


def output_of(plugin: Element) -> str:
    """Return what a plugin of ROS 2 remaps its output ``~/out`` to; empty for nothing."""
    ros = plugin.find("ros")
    rules = [rule.text.partition(":=") for rule in ros.all("remapping")] if ros else []
    return next((to for name, _, to in rules if name == "~/out"), "")
