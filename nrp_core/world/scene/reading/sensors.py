"""Find the sensors of a file: each is read by the class that is registered for its type or its plugin."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol, TypeVar

from nrp_core.errors import BackendError, did_you_mean
from nrp_core.registry import Registry
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Joint, Link
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import MountedSensor

Part = TypeVar("Part", Link, Joint)

PLUGIN = "plugin."
"""Before the name of a model's ``<plugin>`` in the names of the entry points."""


@dataclass(frozen=True, slots=True)
class Mount:
    """The link or joint that holds a ``<sensor>``.

    Args:
        name: of the link or joint.
        place: returns the pose of an element in the frame of the link or joint.
    """

    name: str
    place: Callable[[Element], Pose]


@dataclass(frozen=True, slots=True)
class ModelParts:
    """The links and joints of the model that has a ``<plugin>``."""

    links: Sequence[Link]
    joints: Sequence[Joint]

    def link(self, named: Element) -> Link:
        """Return the link that an element names."""
        return _named(named, self.links, "link")

    def joint(self, named: Element) -> Joint:
        """Return the joint that an element names."""
        return _named(named, self.joints, "joint")


class SensorReader(Protocol):
    """The class of a sensor as readers use it, a :class:`nrp_core.world.sensors.sensor.Sensor`."""

    @property
    def on_joint(self) -> bool:
        """Whether its ``<sensor>`` is in a ``<joint>`` instead of a ``<link>``."""

    def read(self, sensor: Element, mount: Mount, reading: Reading) -> MountedSensor:
        """Read a ``<sensor>``."""

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, MountedSensor]:
        """Read a ``<plugin>`` of a model, and return the link that it measures with the sensor."""


SENSORS: Registry[SensorReader] = Registry("nrp_core.sensors", "sensor")
"""Sensors by the types of ``<sensor>``, and by :data:`PLUGIN` with the names of plugins of models."""

_load = cache(SENSORS.load)


def link_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a link; those that cannot be simulated are warned of and left out."""
    seen: set[str] = set()
    for sensor in sensors:
        name = sensor.attribute("name")
        if name in seen:
            raise sensor.error(f"the link '{mount.name}' has two sensors named '{name}'")
        seen.add(name)
        found = _reader(sensor, sensor.attribute("type"))
        if found is None:
            _warn_of_type(sensor, reading)
        elif not found.on_joint:
            yield found.read(sensor, mount, reading)


def joint_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a joint likewise."""
    for sensor in sensors:
        found = _reader(sensor, sensor.attribute("type"))
        if found is not None and found.on_joint:
            yield found.read(sensor, mount, reading)
        else:
            _warn_of_type(sensor, reading)


def with_plugin_sensor(
    plugin: Element, links: Sequence[Link], joints: Sequence[Joint], reading: Reading
) -> list[Link] | None:
    """Return the links with the sensor that a ``<plugin>`` of a model stands for; None if it is none."""
    found = _reader(plugin, PLUGIN + plugin_name(plugin))
    if found is None:
        return None
    return with_sensors(links, *found.read_plugin(plugin, ModelParts(links, joints), reading))


def with_sensors(links: Sequence[Link], name: str, *sensors: MountedSensor) -> list[Link]:
    """Return links of which one has further sensors."""
    return [replace(each, sensors=(*each.sensors, *sensors)) if each.name == name else each for each in links]


def _reader(element: Element, name: str) -> SensorReader | None:
    """Return the class of a sensor, imported when a file first has one."""
    if name not in SENSORS.names():
        return None
    try:
        return _load(name)
    except BackendError as error:
        raise element.error(str(error)) from error


def _warn_of_type(sensor: Element, reading: Reading) -> None:
    reading.notes.warn(sensor, f"sensors of type '{sensor.attribute('type')}' are not simulated")


def _named(element: Element, parts: Sequence[Part], kind: str) -> Part:
    for part in parts:
        if part.name == element.text:
            return part
    hint = did_you_mean(element.text, [part.name for part in parts])
    raise element.error(f"the model has no {kind} '{element.text}'{hint}")
