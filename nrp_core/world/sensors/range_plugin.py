"""Plugins of Gazebo for ROS that make one distance of the rays of a sensor, as sonars do."""

from __future__ import annotations

from typing import Final, NamedTuple

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.sensor_elements import plugin_topic
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import Noise
from nrp_core.world.topics import resolve_name

RANGE: Final = "sensor_msgs/Range"
RANGE_PLUGIN: Final = "gazebo_ros_range"
_RADIATIONS: Final = ("ultrasound", "infrared")


class RangePlugin(NamedTuple):
    """What such a plugin says.

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
    """Return what the plugins of a ``<sensor>`` with rays say of its distance.

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
