"""Find the sensors of a file: each is read by the class registered for its type or plugin."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final, Protocol

from nrp_core.errors import slip_of
from nrp_core.findings import Code
from nrp_core.registry import Registry
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.bodies import free_name
from nrp_core.world.scene.model import Link
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.frame_names import frame_named
from nrp_core.world.scene.reading.parameters import check_parameters
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.registered import ModelParts, registered
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import MountedSensor

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

    def read(self, sensor: Element, mount: Mount, reading: Reading) -> MountedSensor:
        """Read a ``<sensor>``."""

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, MountedSensor]:
        """Read a ``<plugin>`` of a model, and return the link that it measures with the sensor."""


SENSORS: Registry[SensorReader] = Registry("nrp_core.sensors", "sensor")
"""Sensors by the types of ``<sensor>``, and by :data:`PLUGIN` and the names of plugins of models."""


def link_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a link; those that cannot be simulated are left out with a warning."""
    seen: set[str] = set()
    for sensor in chain.from_iterable(map(_apart, sensors)):
        sensor = _with_free_name(sensor, seen, mount, reading)
        seen.add(sensor.attribute("name"))
        found = registered(SENSORS, sensor.attribute("type"), sensor)
        if found is None:
            _warn_of_type(sensor, reading)
        elif found.on_joint:
            _warn_of_holder(sensor, "joint", reading)
        else:
            read = found.read(sensor, mount, reading)
            _warn_of_unread(sensor, reading)
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
        attributes = {**sensor.attributes, "name": name, "type": "camera"}
        cameras.append(replace(sensor, attributes=attributes, children=[*shared, *topics, camera]))
    return cameras


def _with_free_name(sensor: Element, taken: Collection[str], mount: Mount, reading: Reading) -> Element:
    """Return a sensor; one whose name is taken gets another one, with a warning."""
    name = sensor.attribute("name")
    unique = free_name(name, taken)
    if unique == name:
        return sensor
    message = f"the link '{mount.name}' has two sensors named '{name}': this one is renamed '{unique}'"
    reading.notes.warn(sensor, Code.NRP266, message, subject=name)
    return replace(sensor, attributes={**sensor.attributes, "name": unique})


def joint_sensors(sensors: Iterable[Element], mount: Mount, reading: Reading) -> Iterator[MountedSensor]:
    """Read the sensors of a joint in the same way."""
    for sensor in sensors:
        found = registered(SENSORS, sensor.attribute("type"), sensor)
        if found is None:
            _warn_of_type(sensor, reading)
        elif not found.on_joint:
            _warn_of_holder(sensor, "link", reading)
        else:
            yield found.read(sensor, mount, reading)
            _warn_of_unread(sensor, reading)


def _warn_of_unread(sensor: Element, reading: Reading) -> None:
    """Warn of the elements of other types of sensors, and of parameters of plugins without effect."""
    kind, name = sensor.attribute("type"), sensor.attribute("name")
    for child in sensor.children:
        if child.tag == "plugin":
            check_parameters(child, reading)
        elif child.tag not in sensor.asked and (child.tag in SENSORS.names() or child.tag in _UNSIMULATED):
            message = f"<{child.tag}> has no effect in the sensor '{name}', which is of type '{kind}'"
            reading.notes.warn(child, Code.NRP263, message, subject=child.tag)


def with_plugin_sensor(plugin: Element, model: ModelParts, reading: Reading) -> list[Link] | None:
    """Return the links with the sensor of a ``<plugin>`` of a model; None if the plugin is not a sensor."""
    found = registered(SENSORS, PLUGIN + plugin_name(plugin), plugin)
    if found is None:
        return None
    return with_sensors(model.links, *found.read_plugin(plugin, model, reading))


def with_sensors(links: Sequence[Link], name: str, *sensors: MountedSensor) -> list[Link]:
    """Return links with further sensors on one of them."""
    return [replace(each, sensors=(*each.sensors, *sensors)) if each.name == name else each for each in links]


def _warn_of_holder(sensor: Element, holder: str, reading: Reading) -> None:
    kind, name = sensor.attribute("type"), sensor.attribute("name")
    message = f"the sensor '{name}' is left out: a sensor of type '{kind}' belongs in a <{holder}>"
    reading.notes.warn(sensor, Code.NRP262, message, subject=kind)


def _warn_of_type(sensor: Element, reading: Reading) -> None:
    kind = sensor.attribute("type")
    types = [name for name in SENSORS.names() if not name.startswith("plugin.")]
    message = f"sensors of type '{kind}' are not simulated{slip_of(kind, types)}"
    reading.notes.warn(sensor, Code.NRP262, message, subject=kind)
